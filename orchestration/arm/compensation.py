"""Compensators for the arm's axes, each designed for the motor and link of its own axis."""

from __future__ import annotations

from functools import lru_cache

from warmlink.controllers.design.chain import NEIGHBOUR
from warmlink.controllers.design.gains import Design, design_controller
from warmlink.controllers.design.plant import Plant
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.orchestration.arm.blueprint import axis_name
from warmlink.orchestration.arm.geometry import axis
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.shipped import COMPENSATOR

DESIGNED = "observer"
"""Law that has a design for any axis; the others come with the parameters of the warm-up cell."""


def plant(number: int, coupled: bool = True) -> Plant:
    """Nominal motor and link of an axis; `coupled` with the conductance to the link before it."""
    motor = dict(axis(number).motor)
    if not coupled:
        del motor[NEIGHBOUR]
    return Plant(motor, dict(axis(number).link))


def compensator_values(law: str, sensor: str, noise: float, count: int = AXES) -> dict[str, dict[str, Value]]:
    """Start values of sensors and compensators by instance.

    Parameters
    ----------
    law : name of the controller
    sensor : which temperature each axis measures, as `middle`
    noise : standard deviation of a reading in K
    count : number of axes
    """
    values: dict[str, dict[str, Value]] = {}
    for i in range(1, count + 1):
        values[f"{axis_name(i)}.sensors"] = {
            **{f"noise[{channel}]": noise for channel in range(1, 9)},
            "seed": i,
        }
        if law == DESIGNED:
            design = _design((i - 1) % AXES + 1, sensor, noise)
            values[f"{axis_name(i)}.{COMPENSATOR}"] = dict(by_scalar(design.parameters))
    return values


@lru_cache(maxsize=64)
def _design(number: int, sensor: str, noise: float) -> Design:
    """Design of one axis by itself: what comes from its neighbours is unknown heat."""
    return design_controller(DESIGNED, (sensor,), noise, plant=plant(number, coupled=False))
