"""How the cost of a run grows with the number of axes, and what an 8-hour shift of six axes takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.arm_kinematics.equations import AXES as SHIFT_AXES
from warmlink.orchestration.arm.blueprint import arm_blueprint, arm_values, merged
from warmlink.orchestration.arm.compensation import OBSERVER
from warmlink.orchestration.arm.program import Program, load_program
from warmlink.orchestration.arm.run import arm_system, program_values
from warmlink.orchestration.arm.scenario import load_arm_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.compiled import prepare
from warmlink.orchestration.master.gauss_seidel import GaussSeidel
from warmlink.orchestration.master.run import simulate
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
        If there is no C compiler, or no Numba.
    """
    prepare()
    program = load_program("six_axis_inspection")
    for count in counts:
        yield _timed("motors and links", _plain(program, count), count, max(1, axis_steps // count), REPEATS)
    shift = load_arm_scenario(SHIFT)
    steps, store = round(shift.stop_time), FmuStore("native")
    for what, controller in (("8 h shift", None), ("8 h shift, observers", OBSERVER)):
        yield _timed(what, arm_system(shift, controller, store), SHIFT_AXES, steps, 2)


def _plain(program: Program, count: int) -> System:
    blueprint = arm_blueprint(count, compensated=False)
    files = FmuStore("native").files(set(blueprint.components.values()))
    return blueprint.system(files, None, merged(arm_values(count), program_values(program, count)))


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


def scale_table(found: Sequence[Scale]) -> Any:
    """Rich table of the times."""
    from rich.table import Table

    table = Table(title="arms by number of axes", title_justify="left", box=None)
    for heading in (
        "axes",
        "components",
        "steps",
        "seconds",
        "us a step and component",
        "us a step and axis",
    ):
        table.add_column(heading, justify="right")
    for each in found:
        table.add_row(
            each.what,
            str(each.axes),
            str(each.components),
            str(each.steps),
            f"{each.seconds:.2f}",
            f"{each.us_per_step_and_component:.3f}",
            f"{each.us_per_step_and_axis:.3f}",
        )
    return table
