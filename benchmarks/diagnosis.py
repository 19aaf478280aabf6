"""How often the diagnosis is right: fresh runs with hidden effects, and what was said of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.command import positive_share, start
from benchmarks.diagnosis_trial import Trial, trial
from benchmarks.hidden_effects import KINDS
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.progress import progress_bar

FULL = {
    "single": 400,
    "weak": 200,
    "pair": 200,
    "triple": 100,
    "none": 400,
    "unknown": 200,
    "single, real noise": 200,
    "pair, real noise": 100,
    "none, real noise": 200,
    "unknown, real noise": 100,
    "still": 50,
    "moving": 50,
    "none, noise called half": 100,
    "none, noise called twice": 100,
    "single, noise called half": 50,
    "single, noise called twice": 50,
    "none, columns missing and gaps": 50,
    "single, columns missing and gaps": 100,
    "any cause, any duty": 240,
}


@dataclass(frozen=True)
class Bench:
    """All trials; `table` gives the figures, `confusion` who was taken for whom."""

    trials: tuple[Trial, ...]

    def table(self) -> list[dict[str, Any]]:
        """Figures by kind of trial; shares in percent, None where there is nothing to count."""
        rows = []
        for kind in dict.fromkeys(t.kind for t in self.trials):
            trials = [t for t in self.trials if t.kind == kind]
            held = [t.heldout for t in trials if t.heldout is not None]
            covered = [c for t in trials for c in t.covered]
            rows.append(
                {
                    "kind": kind,
                    "runs": len(trials),
                    "right_percent": _percent(t.right for t in trials),
                    "wrong_name_percent": _percent(t.wrong_name for t in trials),
                    **{word: sum(t.verdict == word for t in trials) for word in _WORDS},
                    "in_interval_percent": _percent(covered),
                    "heldout_within_10_percent": _percent(h < 1.1 for h in held),
                    "next_experiment_right_percent": _percent(
                        t.followed for t in trials if t.followed is not None
                    ),
                    "next_experiment_as_said_percent": _percent(
                        t.as_said for t in trials if t.as_said is not None
                    ),
                    "seconds": float(np.mean([t.seconds for t in trials])),
                }
            )
        return rows

    def confusion(self) -> dict[tuple[str, str], int]:
        """Number of runs by hidden causes and causes said, without their channels."""
        counts = Counter((_stems(t.truth), _stems(t.found) if t.found else t.verdict) for t in self.trials)
        return dict(counts)

    def write(self, folder: Path) -> None:
        """Write `bench_diagnosis.csv`, `confusion.csv` and each trial in `trials.csv`."""
        import pandas as pd

        folder.mkdir(parents=True, exist_ok=True)
        pd.DataFrame(self.table()).to_csv(folder / "bench_diagnosis.csv", index=False)
        confusion = [{"hidden": a, "said": b, "runs": n} for (a, b), n in sorted(self.confusion().items())]
        pd.DataFrame(confusion).to_csv(folder / "confusion.csv", index=False)
        pd.DataFrame([vars(t) for t in self.trials]).to_csv(folder / TRIALS, index=False)


TRIALS = "trials.csv"

_WORDS = ("adequate", "named", "ambiguous", "unknown")


def bench_diagnosis(
    counts: dict[str, int] | None = None,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
    folder: Path | None = None,
) -> Bench:
    """Run trials of every kind.

    Parameters
    ----------
    counts : trials by kind; default the full counts
    seed : of all random choices; a fresh one gives fresh trials
    jobs : processes
    progress : told how many trials are done, of how many
    folder : where each trial is written to `trials.csv` as soon as it is done
    """
    chosen = FULL if counts is None else counts
    # Kinds take turns in proportion, so that a bench that is stopped has something of each.
    tasks = sorted(
        ((kind, seed, i) for kind, count in chosen.items() for i in range(count)),
        key=lambda task: (task[2] + 0.5) / chosen[task[0]],
    )
    trials: list[Trial] = []

    def keep(done: Trial) -> None:
        trials.append(done)
        if folder is not None:
            _append(done, folder / TRIALS, first=len(trials) == 1)
        progress(len(trials), len(tasks))

    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    if jobs == 1:
        for task in tasks:
            keep(trial(task))
    else:
        with ProcessPoolExecutor(jobs) as pool:
            for done in pool.map(trial, tasks):
                keep(done)
    return Bench(tuple(sorted(trials, key=lambda t: list(KINDS).index(t.kind))))


def _append(done: Trial, path: Path, first: bool) -> None:
    """Add a trial to a file as soon as it is done, for a bench takes hours and may be stopped."""
    import pandas as pd

    pd.DataFrame([vars(done)]).to_csv(path, index=False, header=first, mode="w" if first else "a")


def _percent(values: Iterable[bool]) -> float | None:
    counted = list(values)
    return 100.0 * sum(counted) / len(counted) if counted else None


def _stems(names: Sequence[str]) -> str:
    return " + ".join(sorted(name.partition(":")[0] for name in names)) or "nothing"


def main(
    share: Annotated[float, typer.Option(help="Share of the full counts, 400 runs per kind at most.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    out: Annotated[Path, typer.Option(help="Folder for the tables.")] = Path("out/bench_diagnosis"),
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Hide effects in fresh runs and count how often the diagnosis is right: shares and confusion matrix."""
    share = positive_share(share)
    counts = {kind: max(1, round(share * count)) for kind, count in FULL.items()}
    with progress_bar("Hidden effects") as progress:
        bench = bench_diagnosis(counts, seed, jobs, lambda done, total: progress(done / total), out)
    bench.write(out)
    if json:
        answer_json(bench.table())
        return
    _print_shares(bench.table())
    answer(f"seed {seed}; confusion matrix and every trial in {out}")


_SHARES = {
    "right": "right_percent",
    "wrong": "wrong_name_percent",
    "95 %": "in_interval_percent",
    "held": "heldout_within_10_percent",
    "next": "next_experiment_right_percent",
    "said": "next_experiment_as_said_percent",
}
"""Columns of the table in the terminal, which all are shares in percent."""


def _print_shares(rows: list[dict[str, Any]]) -> None:
    answer(f"{'':<33}{'runs':>5}" + "".join(f"{heading:>7}" for heading in _SHARES) + f"{'s':>6}")
    for row in rows:
        shares = [row[name] for name in _SHARES.values()]
        cells = "".join(f"{'-' if share is None else f'{share:.1f}':>7}" for share in shares)
        answer(f"{row['kind']:<33}{row['runs']:>5}{cells}{row['seconds']:>6.2f}")
    answer(
        "in %: right or in the stated set; wrong name; strength in its 95 % interval; held-out error\n"
        "within 10 % of the noise; next experiment led to the right name; or did what it said it can.\n"
        "s: processor time of a search"
    )


if __name__ == "__main__":
    start(main)
