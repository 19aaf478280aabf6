"""Runs from which laws are fitted: of the linear plant here, and of any FMUs by whoever can run them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from warmlink.controllers.design.plant import INPUTS, Plant, cell_plant, plant_model
from warmlink.controllers.observer.model import TrustedDuty
from warmlink.fmus.component import limits
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.motor_heat_source.equations import copper_loss, friction_loss, idle_loss, iron_loss

Array = NDArray[np.float64]


class Stage(NamedTuple):
    """Constant demands: duration in s, speed in rad/s, torque in N.m, and surroundings in K."""

    duration: float
    speed: float
    torque: float
    ambient_temperature: float = ROOM_TEMPERATURE


WARM_UP = (Stage(7200.0, 3.43, 2.5), Stage(3600.0, 0.0, 0.0))
"""A warm-up and cooling at rest."""

STAGES, AT_REST, ROOM = 30, 0.3, 3.0
"""Stages of an excitation, share of them at rest, and how far the surroundings leap from the room's, in K."""

RUNS, MAKE = 4, 2
"""Runs from which a model is found; of so many it is made, then one chooses and one judges."""

LONGEST_TO_SHORTEST = 12.0
"""Duration of the longest stage as a multiple of the shortest."""


@dataclass(frozen=True)
class TrainingRun:
    """Temperatures in K, in the order of `SENSED`, shape (n, 5), and growth in m, shape (n,), of n rows."""

    temperature: Array
    elongation: Array


@dataclass(frozen=True)
class DrivenRun(TrainingRun):
    """A training run with what drove it.

    Attributes
    ----------
    step : s between two rows
    duty : speed, torque and surroundings, held to the next row, shape (n, 3)
    told : which of them the controller is told
    """

    step: float
    duty: Array
    told: tuple[bool, bool, bool] = (True, True, True)


def excitation(
    seed: int, speed: float, torque: float, length: float, room: float = ROOM
) -> tuple[Stage, ...]:
    """Stages that tell what a machine does: at rest, then at random up to a speed and a torque.

    Parameters
    ----------
    speed, torque : largest, in the units of `Stage`
    length : s of all stages, each of which is rounded up to 10 s
    room : how far the surroundings leap at most; no law follows that, so that none is judged by it
    """
    random = np.random.default_rng(seed)
    lasts = LONGEST_TO_SHORTEST ** random.uniform(size=STAGES)
    works = random.uniform(size=STAGES) > AT_REST
    fast, hard = works * random.uniform(0.1, 1.0, STAGES), works * random.uniform(size=STAGES)
    around = ROOM_TEMPERATURE + room * random.uniform(-1.0, 1.0, STAGES)
    lasts = 10.0 * np.ceil(length * lasts / lasts.sum() / 10.0)
    rows = np.column_stack([lasts, speed * fast, torque * hard, around])
    # Whatever heats a machine that does nothing is seen before anything else does.
    return (Stage(10.0 * round(length / 100.0), 0.0, 0.0), *(Stage(*row) for row in rows.tolist()))


def excitations(speed: float, torque: float, length: float) -> list[tuple[Stage, ...]]:
    """Stages of `RUNS` runs, as for `excitation`; the surroundings of those that choose and judge stay."""
    rooms = [ROOM] * MAKE + [0.0] * (RUNS - MAKE)
    return [excitation(seed, speed, torque, length, room) for seed, room in enumerate(rooms)]


def training_run(
    plant: Plant | None = None, stages: Sequence[Stage] = WARM_UP, step: float = 10.0
) -> DrivenRun:
    """Run of the linear plant, from room temperature.

    A plant of None is that of the warm-up cell. The solution is exact for heat that is held over a step in s;
    the heat is the losses by the motor's own equations.
    """
    plant = plant or cell_plant()
    model = plant_model(plant)
    p = MOTOR.p.read(limits.checked(MOTOR, "motor", plant.motor)[0])
    state = np.zeros(model.heat_capacity.size)
    temperature, elongation, told = [], [], []
    for duration, speed, torque, around in stages:
        transition, reach = over_a_step(*model.at(speed), step)
        duty = TrustedDuty(speed, torque, 0.0)
        for _ in range(round(duration / step)):
            seen = model.C @ state
            temperature.append(seen[:-1] + ROOM_TEMPERATURE)
            elongation.append(seen[-1])
            told.append((speed, torque, around))
            shaft, winding = temperature[-1][:2]
            heat = np.zeros(len(INPUTS))
            heat[0] = copper_loss(winding, duty, p) + iron_loss(duty, p)
            heat[1] = friction_loss(shaft, duty, p) + idle_loss(duty, p)
            heat[3] = around - ROOM_TEMPERATURE
            state = transition @ state + reach @ heat
    return DrivenRun(np.array(temperature), np.array(elongation), step, np.array(told))


def over_a_step(rates: Array, by_inputs: Array, step: float) -> tuple[Array, Array]:
    """Transition of a linear system's states over a step in s, and the reach of inputs that are held over it.

    The rates of states are `rates @ states + by_inputs @ inputs`.
    """
    states, inputs = by_inputs.shape
    whole = np.zeros((states + inputs, states + inputs))
    whole[:states] = np.hstack([rates, by_inputs])
    solved = expm(step * whole)
    return solved[:states, :states], solved[:states, states:]
