"""How the cost of a run grows with the number of axes, and what an 8-hour shift of six axes takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated

import typer

from benchmarks.command import start
from warmlink.fmus.arm_kinematics.equations import AXES as SHIFT_AXES
from warmlink.orchestration.arm.chain import arm_chain, arm_values
from warmlink.orchestration.arm.program import OBSERVER, Program
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.machine import merged
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.compiled.loop import library
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.system.model import System

AXES = (1, 2, 6, 12, 24)
AXIS_STEPS = 20_000
"""Axes times macro steps: every run takes about as long, so that a busy machine disturbs all alike."""

SHIFT = "six_axis_shift"
REPEATS = 5


@dataclass(frozen=True)
class Scale:
    """What stepping an arm took, the best of several runs.

    Attributes
    ----------
    what : which arm
    axes, components : how many there are
    steps : macro steps of 1 s
    seconds : of stepping
    """

    what: str
    axes: int
    components: int
    steps: int
    seconds: float

    @property
    def us_per_step_and_component(self) -> float:
        """Time in us of one macro step, a component."""
        return 1e6 * self.seconds / (self.steps * self.components)

    @property
    def us_per_step_and_axis(self) -> float:
        """Time in us of one macro step, an axis: what grows in proportion stays the same."""
        return 1e6 * self.seconds / (self.steps * self.axes)


def bench_scale(counts: Sequence[int] = AXES, axis_steps: int = AXIS_STEPS) -> Iterator[Scale]:
    """Time arms of several lengths, then the 8-hour shift, without compensators and with observers.

    Native FMUs, 1 s steps, Gauss-Seidel, compiled stepping.

    Parameters
    ----------
    counts : numbers of axes
    axis_steps : axes times macro steps of each run

    Yields
    ------
    Scale
        One an arm, then two of the shift.

    Raises
    ------
    InputError
        If there is no C compiler.
    """
    library()
    for count in counts:
        yield _timed("motors and links", _plain(count), count, max(1, axis_steps // count), REPEATS)
    shift = load_scenario(SHIFT)
    steps, store = round(shift.stop_time), FmuStore("native")
    for what, name in (("8 h shift, no controller", NO_CONTROLLER), ("8 h shift, observers", OBSERVER)):
        scenario = replace(shift, controller=shipped(name))
        system = scenario.system(scenario.files(store))
        yield _timed(what, system, SHIFT_AXES, steps, 2)


def _plain(count: int) -> System:
    """Motors and links of an arm alone, doing what its inspection program asks."""
    machine = arm_chain(count, compensated=False)
    files = FmuStore("native").files(set(machine.parts.values()))
    program = load_scenario("six_axis_inspection").duty
    assert isinstance(program, Program)
    driven = replace(program, axes=count).start_values()
    return machine.system(files, None, merged(arm_values(count), driven))


def _timed(what: str, system: System, axes: int, steps: int, repeats: int) -> Scale:
    def seconds() -> float:
        result = simulate(
            system,
            float(steps),
            1.0,
            GaussSeidel(),
            stepping="compiled",
            record=("kinematics.error_norm",),
            balances=(),
        )
        return result.statistics.wall_seconds

    return Scale(what, axes, len(system.components), steps, min(seconds() for _ in range(repeats)))


def scale_table(found: Sequence[Scale]) -> str:
    """The times as text; how far off proportional they are is told of arms of the same kind."""
    lines = [f"{'':<22}{'axes':>6}{'components':>12}{'steps':>8}{'s':>8}{'µs/component':>14}{'µs/axis':>9}"]
    for each in found:
        lines.append(
            f"{each.what:<22}{each.axes:>6}{each.components:>12}{each.steps:>8}{each.seconds:>8.2f}"
            f"{each.us_per_step_and_component:>14.3f}{each.us_per_step_and_axis:>9.3f}"
        )
    alike = [each.us_per_step_and_component for each in found if each.what == found[0].what]
    if len(alike) > 1:
        middle = (min(alike) + max(alike)) / 2
        lines.append(
            f"µs a step; {found[0].what} are proportional to their components within "
            f"{100 * (max(alike) / middle - 1):.0f} %"
        )
    return "\n".join(lines)


def main(json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Time arms of 1, 2, 6, 12 and 24 axes per macro step, and an 8-hour shift of six axes."""
    found = list(bench_scale())
    if json:
        answer_json(
            [
                {
                    **asdict(each),
                    "us_per_step_and_component": each.us_per_step_and_component,
                    "us_per_step_and_axis": each.us_per_step_and_axis,
                }
                for each in found
            ]
        )
    else:
        answer(scale_table(found))


if __name__ == "__main__":
    start(main)
