"""Parameter set of the regression law from a simulated run (from a log: controllers/learning)."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.gains import sensor_stds
from warmlink.controllers.design.structure import ALONG, structure_spread
from warmlink.controllers.design.training import TrainingRun
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import upper
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

SENSORS = ("base_temperature", "tip_temperature")
"""Thermometers that a law uses by default."""

MEMORY_TIME = 600.0
"""s; shorter than the time constants of the link, so that new readings count for more than old ones."""


def fit_regression(
    run: TrainingRun,
    sensors: Sequence[str] = SENSORS,
    sensor_std: float | Mapping[str, float] = 0.1,
    reference_temperature: float = ROOM_TEMPERATURE,
) -> dict[str, float | list[float]]:
    """Parameter set of the regression law from a simulated run.

    Parameters
    ----------
    run : simulated, without noise, beginning at reference_temperature; a temperature that nothing reads is
        constant
    sensors : names of the thermometers that the law goes by
    sensor_std : standard deviation in K of a reading, one for all or one by sensor
    reference_temperature : temperature in K at which there is no growth

    Raises
    ------
    InputError
        A sensor is unknown or its standard deviation not above 0, the run is too short, or it holds a value
        that is not finite.
    """
    rises, growth = run.temperature - reference_temperature, run.elongation
    if growth.size < 2 * (rises.shape[1] + 1):
        least = 2 * (rises.shape[1] + 1)
        raise InputError(f"run: {growth.size} rows are too few for a regression; give at least {least}")
    if not (np.isfinite(rises).all() and np.isfinite(growth).all()):
        raise InputError("run: a temperature or the elongation is not finite; leave such rows out")
    stds = sensor_stds(sensors, sensor_std)
    moments, used = second_moments(rises), np.flatnonzero(stds)
    coefficients = np.zeros(len(stds))
    # Plain least squares, not ridged by the sensors' noise: the law multiplies filtered temperatures, which
    # are nearer to the true ones than readings are.
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
    """Growth in m/K of an evenly warm link: the sum of the coefficients of the thermometers on the link.

    Of all thermometers, if those on the link do not vary in the run.
    """
    varied = np.ptp(rises, axis=0) > 0
    along = varied & np.isin(SENSED, list(ALONG))
    chosen = along if along.any() else varied
    return float(np.linalg.lstsq(rises[:, chosen], growth, rcond=None)[0].sum())


def second_moments(rises: Array) -> Array:
    """Second moments in K2, shape (5, 5), of rises in K, shape (n, 5).

    A temperature that does not vary was not read: it counts as 1 K2, uncorrelated with the others.
    """
    constant = np.ptp(rises, axis=0) == 0.0
    rises = np.where(constant, 0.0, rises)
    moments = rises.T @ rises / rises.shape[0]
    moments[constant, constant] = 1.0
    return np.asarray(moments)


def reference_temperature_of(run: TrainingRun, sensors: Sequence[str]) -> float:
    """Temperature in K at which there is no growth: the mean of some sensors at the beginning of a run.

    Room temperature if the run begins with growth, since it does not tell then.
    """
    used = np.array(sensor_stds(sensors, 1.0)) > 0
    begins_without = abs(run.elongation[0]) <= 1e-6 * np.ptp(run.elongation)
    return float(np.mean(run.temperature[0, used])) if begins_without else ROOM_TEMPERATURE


def _residual(rises: Array, growth: Array, stds: Array) -> float:
    """Rms in m of the growth that a regression ridged by the sensors' noise does not explain, without noise.

    `rises` and `stds` are of the sensors in use, in K.
    """
    ridged = rises.T @ rises / growth.size + np.diag(stds**2)
    left = growth - rises @ np.linalg.solve(ridged, rises.T @ growth / growth.size)
    return float(np.sqrt(np.mean(left**2)))
