"""What each core that steps through time gains: it and what would have to do without it, in turn.

The step of ROS2 stands once, in `fmus/component/integrator.py`; the native FMU's C is generated from it. What
is written besides is written for speed, and earns its place here.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from itertools import count
from typing import Annotated

import numpy as np
import typer

from benchmarks.command import start
from warmlink.fmus.packaging.native.rollout_code import compiled as rollout
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.steps import SEARCH
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.master.run import Stepping, simulate
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import recorded

SCENARIO, LAW, STOP, STEP = "windshield_wiper", "lag", 3600.0, 1.0
SLOTS = ("link.emissivity", "motor.coulomb_friction", "motor.joint_resistance")
OUTPUTS = ("motor.shaft_temperature", "link.tip_temperature")

Work = Callable[[], object]


@dataclass(frozen=True)
class Gain:
    """Times in ms of the same work with a core and without it, and their ratio: the medians of the rounds."""

    core: str
    against: str
    ms: float
    ms_without: float
    ratio: float

    def __str__(self) -> str:
        times = f"{self.ms:>10.2f}{self.ms_without:>12.2f}{self.ratio:>9.3g}"
        return f"{self.core:<46}{self.against:<34}{times}"


def in_turn(core: str, against: str, work: Work, other: Work, rounds: int, share: float = 1.0) -> Gain:
    """Time two kinds of work in turn, once before it counts; the first does `share` times as much."""
    work(), other()
    pairs = [(_seconds(work) / share, _seconds(other)) for _ in range(rounds)]
    first, second = (statistics.median(column) for column in zip(*pairs, strict=True))
    ratio = statistics.median(b / a for a, b in pairs)
    return Gain(core, against, 1e3 * first, 1e3 * second, ratio)


def _seconds(work: Work) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def scenario() -> Scenario:
    """An hour of the closed cell."""
    asked = replace(load_scenario(SCENARIO), controller=shipped(LAW), step_size=STEP)
    return replace(asked, duty=asked.duty.until(STOP))


def fmu_run(kind: FmuKind, stepping: Stepping) -> Work:
    """An hour of the cell's FMUs under a master."""
    asked = scenario()
    system, names = asked.system(asked.files(FmuStore(kind))), recorded(asked.machine)
    return lambda: simulate(system, STOP, STEP, record=names, stepping=stepping, check_stability=False)


def rollouts(side_by_side: bool) -> tuple[Work, int]:
    """So many hours of the cell in one piece, as studies have it, and how many these are."""
    asked = scenario()
    whole = rollout(asked.joined(), recorded(asked.machine), side_by_side)
    runs = [asked.values()] * whole.lanes
    return lambda: whole.run(runs, round(STOP / STEP), STEP), whole.lanes


def forward(compiled: bool) -> Work:
    """A measured hour simulated with its derivatives, by rows of 10 s."""
    equations = Equations(rig("WarmupCell"), SLOTS, OUTPUTS)
    time_s = np.arange(0.0, STOP + 1, 10.0)
    driven = {"motor.speed": 3.4, "motor.torque": 2.5, "link.speed": 3.4}
    inputs = {name: np.where(time_s % 900 < 600, value, 0.0) for name, value in driven.items()}
    run = Run("hour", time_s, inputs, {})
    equations.compile()
    if not compiled:
        equations.library = lambda ahead=0: None  # type: ignore[method-assign]
    model = Forward(equations, run, {}, SEARCH)
    start, tries = model.start_values(), count()
    # The course at the last values is kept, so that others are asked for each time.
    return lambda: model(start * (1 + 1e-6 * next(tries)), run.time)


def gains(rounds: int) -> Iterator[Gain]:
    """Time one core after the other; InputError if there is no C compiler."""
    lanes, many = rollouts(True)
    single, _ = rollouts(False)
    master = fmu_run("native", "compiled")
    native = "native FMU: model_step.h"
    yield in_turn(native, "Python FMU: integrator.py", master, fmu_run("python", "compiled"), rounds)
    yield in_turn("master: compiled/loop.c", "the loop in Python", master, fmu_run("native", "plain"), rounds)
    yield in_turn("joined run: rollout.c", "FMUs by loop.c", single, master, rounds)
    yield in_turn(f"{many} joined runs side by side", "FMUs by loop.c", lanes, master, rounds, many)
    yield in_turn("diagnosis: integrator.c", "CasADi's own machine", forward(True), forward(False), rounds)


def main(
    rounds: Annotated[int, typer.Option(help="Pairs of timings of each core.", min=1)] = 9,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Print what each core gains: processor time in ms for an hour of the cell, with it and without."""
    found = list(gains(rounds))
    if json:
        answer_json([asdict(each) for each in found])
        return
    answer(f"{'core':<46}{'without it':<34}{'ms':>10}{'ms without':>12}{'ratio':>9}")
    for each in found:
        answer(str(each))


if __name__ == "__main__":
    start(main)
