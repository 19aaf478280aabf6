"""How far the observers can be trusted: fresh runs, nominal, with wrong models, with failing sensors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from benchmarks.command import positive_share, start
from benchmarks.rollout import Cell, demand_table, library
from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.progress import progress_bar

if TYPE_CHECKING:
    from benchmarks.innovations import Whiteness
    from benchmarks.law_trials import FaultRun
    from warmlink.orchestration.scenarios.duties.duty import Duty

WITH_CAMERA: Mapping[str, bool] = {"observer": False, "observer_drift": True}
"""The laws whose `correction_std` is a promise, and whether the camera is one of their instruments."""

WHITENESS_SECONDS = 3000.0
LEVEL = 0.05


@dataclass(frozen=True)
class Counts:
    """Runs of a law: for coverage at nominal parameters, for whiteness, with wrong models, with a fault."""

    coverage: int = 200
    whiteness: int = 200
    mismatch: int = 200
    faults: int = 1000

    def shared(self, share: float) -> Counts:
        """A share of each count, at least two."""
        return Counts(*(max(2, round(share * count)) for count in vars(self).values()))


@dataclass(frozen=True)
class Trial:
    """One run; what does not belong to its kind is None.

    Attributes
    ----------
    removed : % of the largest thermal error
    largest : largest remaining error in m
    covered : share of the run within two stated standard deviations
    white : tests of the innovations of each sensor
    fault : what came of a fault
    """

    law: str
    kind: str
    seed: int
    duty: str
    removed: float | None = None
    largest: float | None = None
    covered: float | None = None
    white: tuple[Whiteness, ...] = ()
    fault: FaultRun | None = None


def bench_laws(
    counts: Counts, seed: int, jobs: int = 1, progress: Callable[[float], None] = lambda share: None
) -> list[Trial]:
    """Run all trials of both observers.

    Parameters
    ----------
    counts : of runs of each kind and law
    seed : of all random choices; another one gives fresh runs
    jobs : processes
    progress : told the share that is done

    Raises
    ------
    InputError
        If there is no process to run them.
    """
    if jobs < 1:
        raise InputError(f"--jobs {jobs}: no process would run; give 1 or more")
    tasks = list(_tasks(counts, seed))
    for name in WITH_CAMERA:
        _cell(name)  # once, where processes begin as copies of this one
    found = []
    with ProcessPoolExecutor(jobs) as pool:
        for trial in pool.map(_trial, tasks, chunksize=4):
            found.append(trial)
            progress(len(found) / len(tasks))
    return found


def _tasks(counts: Counts, seed: int) -> Iterator[tuple[str, str, int, int]]:
    for name in WITH_CAMERA:
        for which, (kind, count) in enumerate(vars(counts).items()):
            if kind == "whiteness" and name != "observer":
                continue  # the other's innovations are those of the same filter
            first = int(np.random.default_rng([seed, which]).integers(1, 2**30))
            yield from ((name, kind, i, first + i) for i in range(count))


def _trial(task: tuple[str, str, int, int]) -> Trial:
    from benchmarks.law_trials import (
        FILTER_ALONE,
        coverage,
        fault_runs,
        instruments,
        removed_percent,
        told_of_their_heat,
    )

    name, kind, place, seed = task
    cell = _cell(name)
    if kind == "faults":
        (run,) = fault_runs(cell, library(), [seed], WITH_CAMERA[name])
        return Trial(name, kind, seed, run.duty, fault=run)
    duties = told_of_their_heat() if kind in {"coverage", "whiteness"} else library()
    duty = duties[place % len(duties)]
    if kind == "whiteness":
        return Trial(name, kind, seed, duty.name, white=_white(cell, duty, seed))
    values = {**instruments(seed), **_plant(kind, seed), "compensator": dict(FILTER_ALONE)}
    record = cell.run(demand_table(duty, cell.step), values)
    return Trial(
        name,
        kind,
        seed,
        duty.name,
        removed_percent(record),
        float(np.abs(record.error).max()),
        coverage(record),
    )


def _plant(kind: str, seed: int) -> dict[str, dict[str, float]]:
    from benchmarks.law_trials import mismatched

    if kind != "mismatch":
        return {}
    plant = mismatched(seed)
    return {name: plant.given_of(name) for name in ("motor", "link")}


def _white(cell: Cell, duty: Duty, seed: int) -> tuple[Whiteness, ...]:
    from benchmarks.innovations import innovations, whiteness
    from benchmarks.law_trials import instruments

    demands = demand_table(duty, cell.step, WHITENESS_SECONDS)
    series = innovations(cell.run(demands, instruments(seed)))
    return tuple(whiteness(each) for each in series.values())


@cache
def _cell(law: str) -> Cell:
    from benchmarks.rollout import Cell

    return Cell(catalogue.controller(law), law_states=True)


def laws_table(trials: list[Trial]) -> str:
    """What the trials came to, as text."""
    lines = []
    for name in WITH_CAMERA:
        lines.append(name)
        for kind in ("coverage", "mismatch"):
            lines += _removal_lines(kind, [t for t in trials if (t.law, t.kind) == (name, kind)])
        white = [t for t in trials if t.law == name and t.white]
        if white:
            lines += _whiteness_lines(white)
        lines += _fault_lines([t.fault for t in trials if t.law == name and t.fault is not None])
    return "\n".join(lines)


def _removal_lines(kind: str, trials: list[Trial]) -> Iterator[str]:
    word = "nominal" if kind == "coverage" else "wrong model"
    removed = np.array([t.removed for t in trials], float)
    largest = 1e6 * np.array([t.largest for t in trials], float)
    worst = trials[int(removed.argmin())]
    yield (
        f"  {word}: {len(trials)} runs, removed {removed.min():.1f} % at least (in {worst.duty}), "
        f"{np.median(removed):.1f} % in the middle; largest error {largest.max():.2f} µm"
    )
    if kind == "coverage":
        covered = 100 * np.array([t.covered for t in trials], float)
        middle, error = covered.mean(), covered.std(ddof=1) / np.sqrt(covered.size)
        yield f"  correction_std at 2 sigma: covers {middle:.1f} % of the time (± {2 * error:.1f} %)"


def _whiteness_lines(trials: list[Trial]) -> Iterator[str]:
    found = [w for t in trials for w in t.white]
    rejected = np.mean([w.p < LEVEL for w in found])
    neighbours, size = (np.mean([getattr(w, name) for w in found]) for name in ("neighbours", "std"))
    yield (
        f"  innovations: {len(found)} series, {100 * rejected:.1f} % rejected as not white at "
        f"{100 * LEVEL:.0f} % (Ljung-Box), correlation of neighbours {neighbours:+.3f}, "
        f"of stated size times {size:.3f}"
    )
    by_duty: dict[str, list[bool]] = {}
    for trial in trials:
        by_duty.setdefault(trial.duty, []).extend(w.p < LEVEL for w in trial.white)
    most = max(by_duty, key=lambda duty: float(np.mean(by_duty[duty])))
    yield f"    most in {most}: {sum(by_duty[most])} of {len(by_duty[most])} series"


def _fault_lines(runs: list[FaultRun]) -> Iterator[str]:
    from warmlink.fmus import faults

    worst = max(runs, key=lambda run: run.worse_by)
    yield (
        f"  faults: {len(runs)} runs, worse than uncompensated by {1e6 * worst.worse_by:.2f} µm at most "
        f"({worst.fault.instrument}, {worst.duty})"
    )
    kinds = {"stuck": faults.STUCK, "jump": faults.JUMP, "drift": faults.DRIFT, "dropout": faults.DROPOUT}
    for word, kind in kinds.items():
        chosen = [run for run in runs if run.fault.kind == kind]
        delays = np.array([run.delay for run in chosen if run.delay is not None])
        if not chosen:
            continue
        line = f"    {word:<8}{len(chosen):>5} runs, noticed {100 * delays.size / len(chosen):>4.0f} %"
        if delays.size:
            middle, late = np.percentile(delays, [50, 90])
            line += f", after {middle:.0f} s in the middle, {late:.0f} s in 9 of 10"
        yield line


def main(
    share: Annotated[
        float, typer.Option(help="Share of the full counts, 1,000 runs with a fault per law.")
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Count how far the observers can be trusted: wrong models, honest deviations, failing sensors."""
    with progress_bar("Observers") as progress:
        trials = bench_laws(Counts().shared(positive_share(share)), seed, jobs, progress)
    if json:
        answer_json([asdict(trial) for trial in trials])
        return
    answer(laws_table(trials))
    answer(f"seed {seed}")


if __name__ == "__main__":
    start(main)
