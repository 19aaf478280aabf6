"""Runs of the arm with an effect hidden in one axis, from its FMUs, to practise diagnosing on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.chain import axis_name
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.arm.measured import AMBIENT, DEMANDS, MEASURED, header_of
from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue as causes
from warmlink.orchestration.diagnosis.practice.by_fmus import (
    HiddenEffect,
    of_cause,
    recorded,
    rows_of,
    values_together,
)
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS
from warmlink.orchestration.diagnosis.practice.hide import WHITE, Noise, noisy
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.units import ZERO_CELSIUS

PROGRAM = "six_axis_random_jobs"
_DUTY = ("duty.speed", "duty.torque")
"""What the duty cycle of an axis says of `DEMANDS`, in order."""

_ROOM = f"{axis_name(1)}.duty.ambient_temperature"


def hide_in_arm(
    effects: Mapping[str, float],
    number: int,
    store: FmuStore,
    noise: Noise = WHITE,
    seed: int = 0,
) -> dict[str, Array]:
    """Make a run of the arm that hides effects in one of its axes: columns by header as in a CSV file.

    Effects are strengths in SI by name, as `hide` of `diagnosis/practice` has them; only what a parameter
    of the motor or link of the axis `number`, from 1, can be. InputError is raised if there is no such
    axis, or an effect cannot be hidden in an axis.
    """
    if not 1 <= number <= AXES:
        raise InputError(f"{argument('axis', number)}: the arm has no such axis; choose 1 to {AXES}")
    hidden: dict[str, HiddenEffect] = {}
    for effect in effects:
        cause = _cause(effect)
        if cause is None:
            raise InputError(
                f"effect: {effect!r} cannot be hidden in an axis of the arm; "
                f"{instead(effect, possible_effects())}"
            )
        variables = [f"{axis_name(number)}.{name}" for name in cause.frees]
        hidden[effect] = of_cause(cause, variables)

    def values(system: System) -> dict[str, float]:
        return values_together(system, hidden, effects)

    names = [*_DUTY, *MEASURED.values()]
    record = [*(f"{axis_name(i)}.{name}" for i in range(1, AXES + 1) for name in names), _ROOM]
    # No compensator acts on the plant, and what it corrects is not asked for.
    scenario = replace(load_scenario(PROGRAM), controller=catalogue.shipped(NO_CONTROLLER))
    return _columns(
        recorded(scenario, store, record, values, scenario.step_size), noise, np.random.default_rng(seed)
    )


def possible_effects() -> list[str]:
    """Effects that can be hidden in an axis."""
    return [name for name in EFFECTS if _cause(name) is not None]


def _cause(effect: str) -> Cause | None:
    """The cause that stands for an effect, where its parameters belong to motor or link."""
    cause = next((each for each in causes() if each.name == effect and each.kind == "plant"), None)
    ours = cause is not None and all(name.startswith(("motor.", "link.")) for name in cause.frees)
    return cause if ours else None


def _columns(result: Result, noise: Noise, random: np.random.Generator) -> dict[str, Array]:
    """Columns of a run: a row every interval, which does not know when a duty cycle changes."""
    kept = rows_of(result, random)
    time = result.times[kept]
    columns = {"time [s]": time, AMBIENT: result[_ROOM][kept] - ZERO_CELSIUS}
    for i in range(1, AXES + 1):
        for header, name in zip(DEMANDS, _DUTY, strict=True):
            columns[header_of(i, header)] = result[f"{axis_name(i)}.{name}"][kept]
        true = {
            header.partition(" ")[0]: result[f"{axis_name(i)}.{name}"][kept]
            for header, name in MEASURED.items()
        }
        for header, values in zip(MEASURED, noisy(time, true, noise, random).values(), strict=True):
            columns[header_of(i, header)] = (
                1e6 * values if header.startswith("elongation") else values - ZERO_CELSIUS
            )
    return columns
