"""Compensators for the arm's axes, each designed for the motor and link of its own axis."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from warmlink.controllers.design.chain import NEIGHBOUR
from warmlink.controllers.design.gains import Design, design_controller
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, Plant, plant_model
from warmlink.controllers.lag.component import COMPONENT as LAW
from warmlink.controllers.lag.fit import first_order
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.orchestration.arm.blueprint import axis_name
from warmlink.orchestration.arm.geometry import axis
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.shipped import COMPENSATOR

OBSERVER, LAG = "observer", "lag"

DESIGNED = ("none", LAG, OBSERVER)
"""Laws that have a design for any axis; the others come with the parameters of the warm-up cell."""

_FIT_TIME, _FIT_POINTS, _FIT_HEAT, _FIT_SPEED = 7200.0, 721, 20.0, 0.7
"""The lag law is fitted to two hours of 20 W in the shaft at 0.7 rad/s."""


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
        number = (i - 1) % AXES + 1
        if law == OBSERVER:
            design = _observer(number, sensor, noise)
            values[f"{axis_name(i)}.{COMPENSATOR}"] = dict(by_scalar(design.parameters))
        elif law == LAG:
            values[f"{axis_name(i)}.{COMPENSATOR}"] = dict(_lag(number))
    return values


@lru_cache(maxsize=64)
def _observer(number: int, sensor: str, noise: float) -> Design:
    """Observer of one axis by itself: what comes from its neighbours is unknown heat."""
    return design_controller(OBSERVER, (sensor,), noise, plant=plant(number, coupled=False))


@lru_cache(maxsize=AXES)
def _lag(number: int) -> dict[str, float]:
    """Lag law of one axis by itself, fitted to the step response of its linear plant."""
    model = plant_model(plant(number, coupled=False))
    state, into = model.at(_FIT_SPEED)
    values, vectors = np.linalg.eig(state)
    weights = np.linalg.solve(vectors, into[:, INPUTS.index("shaft_heat")] * _FIT_HEAT)
    time = np.linspace(0.0, _FIT_TIME, _FIT_POINTS)
    rise = np.expm1(np.outer(time, values)) / values * weights
    growth = np.real(rise @ vectors.T @ model.C[OUTPUTS.index("elongation")])
    found = first_order(time, np.full_like(time, _FIT_HEAT), growth)
    motor = axis(number).motor
    losses = {name: motor[name] for name in LAW.p.index if name in motor}
    return {"gain": found.gain, "time_constant": found.time_constant, **losses}
