"""Fit of the regression law to a run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from warmlink.controllers.design.gains import sensor_stds
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, Plant, cell_plant, plant_model
from warmlink.controllers.design.structure import ALONG, structure_spread
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import upper
from warmlink.controllers.observer.model import TrustedDuty
from warmlink.fmus.component import limits
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.motor_heat_source.equations import copper_loss, friction_loss, iron_loss

Array = NDArray[np.float64]

PHASES = ((3.43, 2.5, 7200.0), (0.0, 0.0, 3600.0))
"""Speed in rad/s, torque in N.m and duration in s of what the shipped regression is taught by."""

SENSORS = ("base_temperature", "tip_temperature")
"""Thermometers that a law uses by default."""

MEMORY_TIME = 600.0
"""s; shorter than any mode that matters, so that the law goes by the readings rather than by its memory."""


@dataclass(frozen=True)
class TrainingRun:
    """Temperatures in K at the sensors in `SENSED`'s order, shape (n, 5), and growth in m, shape (n,)."""

    temperature: Array
    elongation: Array


def fit_regression(
    run: TrainingRun,
    sensors: Sequence[str] = SENSORS,
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
    rises, growth = run.temperature - reference_temperature, run.elongation
    if growth.size < 2 * (rises.shape[1] + 1):
        least = 2 * (rises.shape[1] + 1)
        raise InputError(f"run: {growth.size} rows are too few for a regression; give {least}")
    if not (np.isfinite(rises).all() and np.isfinite(growth).all()):
        raise InputError("run: a temperature or the elongation is not finite; leave such rows out")
    stds = sensor_stds(sensors, sensor_std)
    moments, used = second_moments(rises), np.flatnonzero(stds)
    coefficients = np.zeros(len(stds))
    # The filter ridges by the sensors' noise: its temperatures are nearer to the run's than readings are.
    coefficients[used] = np.linalg.lstsq(rises[:, used], growth, rcond=None)[0]
    return {
        "reference_temperature": reference_temperature,
        "sensor_std": stds,
        "coefficients": coefficients.tolist(),
        "moments": upper(moments).tolist(),
        "coefficient_spread": structure_spread(coefficients, stds, _per_kelvin(rises, growth)),
        "memory_time": MEMORY_TIME,
        "residual_std": _residual(rises[:, used], growth, np.array(stds)[used]),
    }


def _per_kelvin(rises: Array, growth: Array) -> float:
    """Growth in m/K of an evenly warm link, by thermometers on it, or by all if a run has none of them."""
    varied = np.ptp(rises, axis=0) > 0
    along = varied & np.isin(SENSED, list(ALONG))
    chosen = along if along.any() else varied
    return float(np.linalg.lstsq(rises[:, chosen], growth, rcond=None)[0].sum())


def second_moments(rises: Array) -> Array:
    """Second moments in K2 of rises in K, shape (n, 5); 1 K2 for a temperature that was not read."""
    still = np.ptp(rises, axis=0) == 0.0
    rises = np.where(still, 0.0, rises)
    moments = rises.T @ rises / rises.shape[0]
    moments[still, still] = 1.0
    return np.asarray(moments)


def cold_in(run: TrainingRun, sensors: Sequence[str]) -> float:
    """Temperature in K of no growth: where a run begins with none, the mean of what sensors read there."""
    used = np.array(sensor_stds(sensors, 1.0)) > 0
    begins_cold = abs(run.elongation[0]) <= 1e-6 * np.ptp(run.elongation)
    return float(np.mean(run.temperature[0, used])) if begins_cold else ROOM_TEMPERATURE


def training_run(plant: Plant | None = None, step: float = 10.0) -> TrainingRun:
    """Warm-up at 100 % duty for two hours and cooling at rest for one, from cold.

    The linear plant, exact for inputs held over a step in s; the losses are the motor's own.
    """
    plant = plant or cell_plant()
    model = plant_model(plant)
    p = MOTOR.p.read(limits.checked(MOTOR, "motor", plant.motor)[0])
    state = np.zeros(model.heat_capacity.size)
    temperature, elongation = [], []
    for speed, torque, duration in PHASES:
        unused = np.zeros((len(OUTPUTS), len(INPUTS)))
        transition, reach, *_ = signal.cont2discrete((*model.at(speed), model.C, unused), step)
        duty = TrustedDuty(speed, torque, 0.0)
        for _ in range(round(duration / step)):
            seen = model.C @ state
            temperature.append(seen[:-1] + ROOM_TEMPERATURE)
            elongation.append(seen[-1])
            shaft, winding = temperature[-1][:2]
            heat = np.zeros(len(INPUTS))
            heat[0] = copper_loss(winding, duty, p) + iron_loss(duty, p)
            heat[1] = friction_loss(shaft, duty, p) + p.standby_power
            state = transition @ state + reach @ heat
    return TrainingRun(np.array(temperature), np.array(elongation))


def _residual(rises: Array, growth: Array, stds: Array) -> float:
    """Rms in m that the ridged regression on the sensors in use leaves of the run, their noise aside."""
    ridged = rises.T @ rises / growth.size + np.diag(stds**2)
    left = growth - rises @ np.linalg.solve(ridged, rises.T @ growth / growth.size)
    return float(np.sqrt(np.mean(left**2)))
