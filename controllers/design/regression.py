"""Fit of the regression law to a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.gains import sensor_stds
from warmlink.controllers.design.plant import Plant
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import upper
from warmlink.controllers.regression.law import LENGTH
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.instance import Instance
from warmlink.fmus.packaging.quantities import ROOM_TEMPERATURE
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

Array = NDArray[np.float64]

MEMORY_TIME = 600.0
"""s; shorter than any mode that matters, so that the law goes by the readings rather than by its memory."""


@dataclass(frozen=True)
class TrainingRun:
    """Temperatures in K at the sensors in `SENSED`'s order, shape (n, 5), and growth in m, shape (n,)."""

    temperature: Array
    elongation: Array


def fit_regression(
    run: TrainingRun,
    sensors: Sequence[str] = ("base_temperature", "tip_temperature"),
    sensor_std: float | Mapping[str, float] = 0.1,
    reference_temperature: float = ROOM_TEMPERATURE,
) -> dict[str, float | list[float]]:
    """Parameter set of the regression law from a run.

    Parameters
    ----------
    run : measured or simulated, from cold
    sensors : which of the cell's temperatures the law goes by
    sensor_std : standard deviation in K of a reading, one for all or one by sensor
    reference_temperature : temperature in K of no growth

    Raises
    ------
    InputError
        A sensor is unknown, the run is too short or holds a value that is not finite.
    """
    rows = np.column_stack([run.temperature - reference_temperature, run.elongation / LENGTH])
    if rows.shape[0] < 2 * rows.shape[1]:
        raise InputError(f"run: {rows.shape[0]} rows are too few for a regression; give {2 * rows.shape[1]}")
    if not np.isfinite(rows).all():
        raise InputError("run: a temperature or the elongation is not finite; leave such rows out")
    moments = rows.T @ rows / rows.shape[0]
    stds = sensor_stds(sensors, sensor_std)
    return {
        "reference_temperature": reference_temperature,
        "sensor_std": stds,
        "moments": [float(value) for value in upper(moments)],
        "memory_time": MEMORY_TIME,
        "residual_std": _residual(rows, np.array(stds)),
    }


def training_run(plant: Plant | None = None, step: float = 10.0) -> TrainingRun:
    """Warm-up at 100 % duty for two hours and cooling at rest for one, from cold, by the components."""
    plant = plant or Plant()
    motor, link = Instance(MOTOR, "motor"), Instance(LINK, "link")
    motor.set(plant.motor)
    link.set(plant.link)
    for instance in (motor, link):
        instance.initialize()
    temperature, elongation = [_sensed(motor, link)], [link.get("elongation")]
    for k in range(round(3 * 3600 / step)):
        working = k * step < 2 * 3600
        motor.set({"speed": 3.43 if working else 0.0, "torque": 2.5 if working else 0.0})
        link.set({"speed": 3.43 if working else 0.0, "heat_flow": motor.get("heat_flow")})
        motor.set({"link_base_temperature": link.get("base_temperature")})
        motor.step(k * step, step)
        link.step(k * step, step)
        temperature.append(_sensed(motor, link))
        elongation.append(link.get("elongation"))
    return TrainingRun(np.array(temperature), np.array(elongation))


def _sensed(motor: Instance, link: Instance) -> list[float]:
    places = {
        "shaft_temperature": motor.get("shaft_temperature"),
        "winding_temperature": motor.get("winding_temperature"),
        "base_temperature": link.get("base_temperature"),
        "middle_temperature": link.get("sensor_temperature[2]"),
        "tip_temperature": link.get("tip_temperature"),
    }
    return [places[name] for name in SENSED]


def _residual(rows: Array, stds: Array) -> float:
    """Rms in m that the regression on the sensors in use leaves of the run, their noise aside."""
    used = np.flatnonzero(stds > 0)
    if used.size == 0:
        return float(LENGTH * np.sqrt(np.mean(rows[:, -1] ** 2)))
    temperature, growth = rows[:, used], rows[:, -1]
    ridge = np.diag(stds[used] ** 2)
    count = rows.shape[0]
    moments = temperature.T @ temperature / count + ridge
    coefficients = np.linalg.solve(moments, temperature.T @ growth / count)
    return float(LENGTH * np.sqrt(np.mean((growth - temperature @ coefficients) ** 2)))
