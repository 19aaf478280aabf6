"""The arm as what scenarios run in, its compensators designed each for the motor and link of its axis."""

from __future__ import annotations

from functools import cache, lru_cache, partial
from typing import Any

import numpy as np

from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, Plant, cell_plant, plant_model
from warmlink.controllers.lag.component import COMPONENT as LAW
from warmlink.controllers.lag.fit import first_order
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.orchestration.arm.blueprint import KINEMATICS, arm_blueprint, arm_values, axis_name
from warmlink.orchestration.arm.errors import ArmErrors
from warmlink.orchestration.arm.geometry import axis
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.scenarios.expression import Expression
from warmlink.orchestration.scenarios.setup import Roles, Sensors, Setup
from warmlink.orchestration.system.model import StartValues, Value
from warmlink.orchestration.system.shipped import COMPENSATOR

OBSERVER, LAG = "observer", "lag"

SENSORS = Sensors(0.1, ("middle",))
"""One thermometer for each axis, half-way along its link, unless a scenario says otherwise."""

DESIGNED = ("none", LAG, OBSERVER)
"""Laws that have a design for any axis; the others come with the parameters of the warm-up cell."""

_FIT_TIME, _FIT_POINTS, _FIT_HEAT, _FIT_SPEED = 7200.0, 721, 20.0, 0.7
"""The lag law is fitted to two hours of 20 W in the shaft at 0.7 rad/s."""


def plant(number: int) -> Plant:
    """Nominal motor and link of an axis by itself, without the conductance to the link before it."""
    motor = {name: value for name, value in axis(number).motor.items() if name != "neighbour_conductance"}
    return cell_plant(motor, axis(number).link)


def designs(law: str, sensors: Sensors, count: int = AXES) -> StartValues | None:
    """Start values of the compensators by instance for a law's name; None where it has no design here.

    `sensors` says what noise a reading has, and which temperatures each axis measures.
    """
    if law not in DESIGNED:
        return None
    values: dict[str, dict[str, Value]] = {}
    for i in range(1, count + 1):
        number, compensator = (i - 1) % AXES + 1, f"{axis_name(i)}.{COMPENSATOR}"
        if law == OBSERVER:
            values[compensator] = dict(_observer(number, sensors.used or (), sensors.noise or 0.0))
        elif law == LAG:
            values[compensator] = dict(_lag(number))
    return values


@cache
def arm(count: int = AXES) -> Setup:
    """The arm, or one of another number of axes."""
    elongations = tuple(f"{axis_name(i)}.link.elongation" for i in range(1, count + 1))
    score = Expression(f"{KINEMATICS}.error_norm")
    without = Expression(f"{KINEMATICS}.uncompensated_error_norm", "uncompensated")
    return Setup(
        arm_blueprint(count),
        Roles(score, without, elongations),
        arm_values(count),
        SENSORS,
        partial(designs, count=count),
        detail=_detail,
    )


def _detail(result: Result) -> dict[str, Any]:
    return ArmErrors(result).to_dict()


@lru_cache(maxsize=64)
def _observer(number: int, used: tuple[str, ...], noise: float) -> dict[str, float]:
    """Observer of one axis by itself: what comes from its neighbours is unknown heat."""
    return by_scalar(design_controller(OBSERVER, used, noise, plant=plant(number)).parameters)


@lru_cache(maxsize=AXES)
def _lag(number: int) -> dict[str, float]:
    """Lag law of one axis by itself, fitted to the step response of its linear plant."""
    model = plant_model(plant(number))
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
