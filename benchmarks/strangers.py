"""What the diagnosis says of runs unlike those that it was made for: `python -m benchmarks.strangers`."""

from __future__ import annotations

import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from benchmarks.strange_runs import LINES, measured
from warmlink.orchestration.console import answer
from warmlink.orchestration.diagnosis.answer.claims import Claim
from warmlink.orchestration.diagnosis.practice.hidden import Truth, simulate
from warmlink.orchestration.diagnosis.practice.hide import write_csv
from warmlink.orchestration.scenarios.duties import duty_files


@dataclass(frozen=True)
class ReadOptions:
    """What was said of one run: the verdict in a word of the table, the sets of causes, and figures.

    `foreseen` has the largest error in um of the uncorrected and of the named model by unseen duty cycle.
    """

    line: str
    word: str
    right: str
    sets: tuple[str, ...]
    heldout: tuple[float, float]
    seconds: float
    foreseen: tuple[tuple[float, float], ...]


def trial(task: tuple[str, int, int]) -> ReadOptions:
    """Make a run and diagnose it, given its line, the seed and its number in the line."""
    from warmlink.orchestration.diagnosis.data.experiment import read_experiment
    from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment

    line, seed, number = task
    random = np.random.default_rng([seed, list(LINES).index(line), number])
    hidden = LINES[line](random)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        write_csv(measured(hidden, random), path)
        experiment = read_experiment(path)
    began = time.process_time()
    found = diagnose_experiment(experiment)
    seconds = time.process_time() - began
    sets = tuple(each.name for each in (found.assessment.best, *found.assessment.rivals))
    word: str = found.verdict
    if word in ("named", "ambiguous"):
        true = [set(each.split("+")) for each in hidden.names]
        said = [set(each.split("+")) for each in sets]
        in_part = any(each < whole for each in said[:1] for whole in true)
        word += " right" if any(each in true for each in said) else " in part" if in_part else " wrong"
    errors = (found.scores.rmse(each, True) for each in (found.before, found.after))
    before, after = (float("nan") if each is None else each[0] for each in errors)
    foreseen = (
        tuple(_errors(claim, hidden.truth) for claim in found.claims) if found.verdict == "named" else ()
    )
    return ReadOptions(line, word, " or ".join(hidden.names), sets, (before, after), seconds, foreseen)


def _errors(claim: Claim, truth: Truth) -> tuple[float, float]:
    """Largest error in um of the uncorrected and of the named model; the other solver has the truth."""
    grown = simulate(truth, list(duty_files.load(claim.duty).unrolled()), claim.time).elongation
    before, after = (float(1e6 * np.abs(grown - each).max()) for each in (claim.before, claim.elongation))
    return before, after


WORDS = (
    "named right",
    "named in part",
    "named wrong",
    "ambiguous right",
    "ambiguous in part",
    "ambiguous wrong",
    "empirical",
    "unknown",
    "adequate",
)


def main(
    runs: Annotated[int, typer.Option(help="Runs per line.")] = 10,
    seed: Annotated[int | None, typer.Option(help="Of all random choices; default a fresh one.")] = None,
    only: Annotated[str, typer.Option(help="Lines whose name contains this.")] = "",
    jobs: Annotated[int, typer.Option(help="Processes at once.")] = 1,
    verbose: Annotated[bool, typer.Option(help="Print every run.")] = False,
) -> None:
    """Print what is said of fresh runs of every kind."""
    seed = int(np.random.SeedSequence().generate_state(1)[0] % 10**6) if seed is None else seed
    lines = [line for line in LINES if only in line]
    tasks = [(line, seed, number) for line in lines for number in range(runs)]
    counts: dict[str, Counter[str]] = {line: Counter() for line in lines}
    seconds: list[float] = []
    foreseen: list[tuple[float, float]] = []
    with ProcessPoolExecutor(jobs) as pool:
        for said in pool.map(trial, tasks) if jobs > 1 else map(trial, tasks):
            counts[said.line][said.word] += 1
            seconds.append(said.seconds)
            foreseen += said.foreseen
            if verbose:
                held = " -> ".join(f"{each:.2f}" for each in said.heldout)
                answer(
                    f"{said.line}: {said.word}; held out {held}; {said.seconds:.1f} s; "
                    f"{said.right or 'nothing'} | {', '.join(said.sets[:4])}"
                )
    answer(f"{'hidden':<30}" + "".join(f"{word:>19}" for word in WORDS))
    for line in lines:
        answer(f"{line:<30}" + "".join(f"{counts[line][word] or '':>19}" for word in WORDS))
    answer(f"{'all':<30}" + "".join(f"{sum(c[word] for c in counts.values()) or '':>19}" for word in WORDS))
    if foreseen:
        errors = np.array(foreseen)
        better, worse = np.mean(errors[:, 1] <= errors[:, 0]), np.max(errors[:, 1] - errors[:, 0])
        answer(
            f"{len(errors)} unseen duty cycles foreseen by named models: {100 * better:.0f} % no worse than "
            f"the uncorrected one, at most {worse:.2f} um worse; off by {np.max(errors[:, 1]):.2f} um at most"
        )
    answer(f"seed {seed}; processor time {np.mean(seconds):.1f} s each, {max(seconds):.1f} s at most")


if __name__ == "__main__":
    start(main)
