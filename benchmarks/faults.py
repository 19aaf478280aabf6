"""What every kind of fault on a shop floor costs with each observer, against no compensation at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import positive_share, start
from benchmarks.fault_kinds import UNTOLD, Kind, kinds
from benchmarks.law_trials import mismatched
from benchmarks.rollout import demand_table, library
from benchmarks.told import DUTY, STEP, Rig, Told, bare_cell, truth
from warmlink.controllers.design.regression import SENSORS
from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.learnt import learn
from warmlink.controllers.learning.logs import Log
from warmlink.controllers.learning.observers import taught
from warmlink.controllers.start_values import by_scalar
from warmlink.orchestration import catalogue
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.progress import progress_bar

LAWS = ("observer", "observer_drift")
LEARNT_LAWS = ("regression", *LAWS)
TRAINING = "shift_with_breaks"
"""Duty cycle of the machine itself whose log teaches them, with a probe each minute that is off by 0.5 um."""

WATCHED = ("observer_drift",)
"""Laws that a camera tells what thermometers do not."""

LONGEST = 4 * 3600
"""s of a duty cycle that a run takes at most; of the one with a night in it, all."""

ALLOWED = 5e-6
"""m by which a fault may make a law worse than no compensation."""

ALLOWED_READY = 1e-3
"""Share of the time in which `ready` may be wrong."""


@dataclass(frozen=True)
class FaultTrial:
    """One run with a fault.

    Attributes
    ----------
    worse_by : by how much in m the error was ever larger than the elongation itself, at one and the same time
    ready_wrong : share of the time in which the law said ready while the error was beyond the tolerance
    ready_share : share of the time in which it said ready
    """

    law: str
    group: str
    kind: str
    duty: str
    plant: int
    seed: int
    worse_by: float
    ready_wrong: float
    ready_share: float


def bench_faults(
    chosen: Sequence[str],
    each: int,
    seed: int,
    jobs: int = 1,
    progress: Callable[[float], None] = lambda share: None,
    laws: Sequence[str] = LAWS,
    learnt: bool = False,
) -> list[FaultTrial]:
    """Run every kind of fault in so many duty cycles, in turns with the model right and wrong.

    Parameters
    ----------
    chosen : names of kinds
    each : runs of each kind and law
    seed : of all random choices; another one gives fresh runs
    jobs : processes
    progress : told the share that is done
    learnt : whether laws were learnt from a log of the machine, and are not those that ship
    """
    draw = np.random.default_rng(seed)
    duties = [duty.name for duty in library()]
    wrong = int(draw.integers(1, 2**20))
    runs: dict[tuple[str, int], list[tuple[str, int]]] = {}
    for place, kind in enumerate(chosen):
        for i, duty in enumerate(draw.permutation(np.resize(duties, max(each, len(duties))))[:each]):
            plant = wrong + i // 2 % 4 if (place + i) % 2 else 0
            runs.setdefault((str(duty), plant), []).append((kind, int(draw.integers(2**30))))
    tasks = [(law, *key, part, learnt) for key, part in runs.items() for law in laws]
    found: list[FaultTrial] = []
    if jobs == 1:
        for task in tasks:
            found += _trials(task)
            progress(len(found) / (each * len(chosen) * len(laws)))
        return found
    with ProcessPoolExecutor(jobs) as pool:
        for trials in pool.map(_trials, tasks):
            found += trials
            progress(len(found) / (each * len(chosen) * len(laws)))
    return found


def _trials(task: tuple[str, str, int, list[tuple[str, int]], bool]) -> list[FaultTrial]:
    law, duty, plant, runs, learnt = task
    return [trial(law, _kinds()[kind], duty, plant, seed, learnt) for kind, seed in runs]


def trial(law: str, kind: Kind, duty: str, plant: int, seed: int, learnt: bool = False) -> FaultTrial:
    """One run of a law with a fault, in a duty cycle of the library and a plant (0: as designed for)."""
    told = kind.apply(truth_of(duty, plant), np.random.default_rng(seed))
    if learnt:
        told = replace(told, parameters=learnt_values(law, plant))
    outcome = rig(law).run(told)
    ready = float(np.mean(outcome.ready > 0))
    wrong = outcome.ready_wrong(ALLOWED)
    return FaultTrial(law, kind.group, kind.name, duty, plant, seed, outcome.worse_by, wrong, ready)


@cache
def _kinds() -> Mapping[str, Kind]:
    return {kind.name: kind for kind in kinds()}


@cache
def learnt_values(law: str, plant: int, sensors: tuple[str, ...] = SENSORS) -> Mapping[str, float]:
    """Parameter set of a law that was learnt from a log of a plant, by scalar."""
    told, draw = truth_of(TRAINING, plant), np.random.default_rng([plant, 45])
    growth = told["elongation"] + 5e-7 * draw.normal(size=len(told.rows))
    seconds = np.arange(len(told.rows)) * np.float64(STEP)
    temperature = np.column_stack([told[name] for name in SENSED])
    measured = np.where(seconds % 60 == 0, growth, np.nan)
    log = Log(TRAINING, seconds, temperature, measured, {name: told[name] for name in DUTY})
    found = learn([log], sensors)
    return by_scalar(found.values if law == "regression" else taught(law, found, STEP))


@cache
def rig(law: str) -> Rig:
    """A shipped law by itself, compiled once."""
    return Rig(catalogue.controller(law))


@cache
def truth_of(duty: str, plant: int) -> Told:
    """What sound instruments tell in a duty cycle of the library and a plant (0: as designed for)."""
    cycle = next(each for each in library() if each.name == duty)
    length = cycle.stop_time if "overnight" in duty else min(cycle.stop_time, LONGEST)
    off = mismatched(plant)
    values = {name: off.given_of(name) for name in ("motor", "link")}
    return truth(bare_cell(), demand_table(cycle, 1.0, length), values, 0.1, plant + 1)


def faults_table(trials: Sequence[FaultTrial], full: bool = False) -> str:
    """For each law the worst kinds of fault, by what they cost and by how often `ready` was wrong."""
    laws = dict.fromkeys(trial.law for trial in trials)
    return "\n".join(line for law in laws for line in _law_lines(law, trials, full))


def _law_lines(law: str, trials: Sequence[FaultTrial], full: bool) -> Iterator[str]:
    mine = [t for t in trials if t.law == law]
    if not mine:
        return
    names = {t.kind: t.group for t in mine}
    worst = {kind: max((t for t in mine if t.kind == kind), key=lambda t: t.worse_by) for kind in names}
    wrong = {kind: float(np.mean([t.ready_wrong for t in mine if t.kind == kind])) for kind in names}
    beyond = [kind for kind in names if worst[kind].worse_by > ALLOWED]
    false = [kind for kind in names if wrong[kind] > ALLOWED_READY]
    overall = float(np.mean([t.ready_wrong for t in mine]))
    yield (
        f"{law}: {len(mine)} runs, {len(names)} kinds of fault; {len(beyond)} kinds worse than none by more "
        f"than {1e6 * ALLOWED:g} µm; ready wrong in {100 * overall:.2f} % of the time, in {len(false)} kinds "
        f"more than {100 * ALLOWED_READY:g} %"
    )
    untold = [kind for kind in names if _kinds()[kind].untold]
    if law not in WATCHED and untold and len(untold) < len(names):
        told = float(np.mean([t.ready_wrong for t in mine if t.kind not in untold]))
        yield (
            f"  ready wrong in {100 * told:.2f} % without {len(untold)} kinds of which only a camera tells: "
            f"{UNTOLD}"
        )
    ready = float(np.mean([t.ready_share for t in mine]))
    yield f"  ready in {100 * ready:.1f} % of the time"
    for group in dict.fromkeys(names.values()):
        of = [kind for kind in names if names[kind] == group]
        yield (
            f"  {group:<13}{len(of):>4} kinds {sum(k in beyond for k in of):>4} beyond, worst "
            f"{1e6 * max(worst[k].worse_by for k in of):>9.1f} µm; ready wrong "
            f"{100 * float(np.mean([wrong[k] for k in of])):>6.2f} %"
        )
    shown = names if full else [kind for kind in names if kind in beyond or kind in false]
    for kind in sorted(shown, key=lambda kind: -worst[kind].worse_by):
        at = worst[kind]
        yield (
            f"    {1e6 * at.worse_by:>9.1f} µm {100 * wrong[kind]:>6.2f} %  {kind}  "
            f"[{at.duty}, {'right' if at.plant == 0 else 'wrong'} model, plant {at.plant}, seed {at.seed}]"
        )


def main(
    each: Annotated[int, typer.Option(help="Runs of each kind and law.", min=1)] = 4,
    share: Annotated[float, typer.Option(help="Share of the kinds, drawn at random.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.", min=1)] = 1,
    full: Annotated[
        bool, typer.Option(help="List every kind, not only those beyond what is allowed.")
    ] = False,
    learnt: Annotated[bool, typer.Option(help="Laws that a log of the machine taught.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Try every kind of fault of thermometers, duty, ambient, camera and supply on both observers."""
    names = list(_kinds())
    count = max(1, round(positive_share(share) * len(names)))
    chosen = np.random.default_rng([seed, 7]).permutation(names)[:count]
    with progress_bar("Faults") as progress:
        laws, kinds_of = LEARNT_LAWS if learnt else LAWS, [str(name) for name in chosen]
        trials = bench_faults(kinds_of, each, seed, jobs, progress, laws, learnt)
    if json:
        answer_json([asdict(trial) for trial in trials])
        return
    answer(faults_table(trials, full))
    answer(f"seed {seed}")


if __name__ == "__main__":
    start(main)
