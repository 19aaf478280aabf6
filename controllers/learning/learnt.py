"""The regression law learnt from logs of a machine, without any model of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.regression import MEMORY_TIME, second_moments
from warmlink.controllers.design.structure import ALONG
from warmlink.controllers.design.training import TrainingRun
from warmlink.controllers.interface import SENSED, SQUARE_MICROMETRE
from warmlink.controllers.learning.line import GrowthLine, Held, Learner, doubt
from warmlink.controllers.learning.logs import WINDOW, Examples, Log, examples_of
from warmlink.controllers.matrices import upper
from warmlink.controllers.start_values import Values
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

OWN_WAY = 2.0
"""K; standard deviation that each thermometer is given beside what it has in common with the others."""

WORTH_IT = 0.05
"""Share of the error that a thermometer off the link must save if it is to be used."""

_LEAST_NOISE = 0.02
"""K; least noise of a thermometer: rounded readings seem to have less."""

_READ = 0.8
"""Share of the readings of the growth at which a thermometer was read too, at least, if it is to be used."""


@dataclass(frozen=True)
class LearntMap:
    """What a log taught.

    Attributes
    ----------
    line : the growth by the temperatures of the thermometers `used`, indices into `SENSED`
    ridge : in K2
    held : predictions of what was held out
    near : standard deviation of a held-out prediction in m
    far : variance in m2 that is added for each unit of leverage, the distance from what was learnt
    noise : of each thermometer in K, shape (len(SENSED),)
    examples : rows that were learnt from
    model : the run of a plant's model that the line was drawn towards, if there was one
    logs : what was learnt from
    """

    line: GrowthLine
    used: tuple[int, ...]
    ridge: float
    held: Held
    near: float
    far: float
    noise: Array
    examples: Examples
    model: TrainingRun | None = None
    logs: tuple[Log, ...] = ()

    @cached_property
    def coefficients(self) -> Array:
        """Growth in m/K by each thermometer, shape (len(SENSED),); 0 for those that are not used."""
        found = np.zeros(len(SENSED))
        found[list(self.used)] = np.maximum(self.line.coefficients, 0.0)
        return found

    @cached_property
    def sensor_std(self) -> Array:
        """Noise in K of each thermometer; 0 for those whose coefficient is 0, which the law does not use."""
        return np.where(self.coefficients > 0, self.noise, 0.0)

    @cached_property
    def rises(self) -> Array:
        """Temperatures of the examples above `ROOM_TEMPERATURE` in K; 0 if one was not measured."""
        found = self.examples.temperature - ROOM_TEMPERATURE
        return np.where(np.isfinite(found).all(axis=0), found, 0.0)

    @cached_property
    def mean_rise(self) -> Array:
        """Mean of `rises` in K, shape (len(SENSED),)."""
        return self.rises.mean(axis=0)

    @cached_property
    def growth_noise(self) -> float:
        """Noise in m of the readings of the growth, by their second differences."""
        rows = self.examples
        return _noise_of(rows.growth[rows.log == i] for i in np.unique(rows.log))

    @property
    def intercept(self) -> float:
        """Growth in m with every thermometer at `ROOM_TEMPERATURE`."""
        return float(self.line.intercept - self.coefficients @ self.mean_rise)

    @cached_property
    def coefficient_spread(self) -> list[float]:
        """Covariance of the coefficients in (um/K)^2, packed."""
        spread = np.zeros((len(SENSED),) * 2)
        kept = np.flatnonzero(self.coefficients > 0)
        inside = [self.used.index(i) for i in kept]
        spread[np.ix_(kept, kept)] = self.far * self.line.inverse[np.ix_(inside, inside)] / SQUARE_MICROMETRE
        return upper(spread).tolist()

    @property
    def values(self) -> Values:
        """Parameter set of the regression law."""
        moments = second_moments(self.rises - self.mean_rise)
        return {
            "reference_temperature": ROOM_TEMPERATURE,
            "sensor_std": self.sensor_std.tolist(),
            "intercept": self.intercept,
            "coefficients": self.coefficients.tolist(),
            "mean_rise": self.mean_rise.tolist(),
            "moments": upper(moments + OWN_WAY**2 * np.eye(len(SENSED))).tolist(),
            "coefficient_spread": self.coefficient_spread,
            "memory_time": MEMORY_TIME,
            "residual_std": self.near,
        }


def learn(
    logs: Sequence[Log],
    sensors: Sequence[str] | None = None,
    model: TrainingRun | None = None,
    sensor_std: float | None = None,
) -> LearntMap:
    """Learn the growth from logs.

    Parameters
    ----------
    logs : of one machine
    sensors : names in `SENSED` that the law is to use; by default those on the link that were measured in
        every log, and others that are worth it
    model : a run of a plant's model, towards which the fit leans where data are few; None if there is none
    sensor_std : noise of a thermometer in K; by default that which the logs show

    Raises
    ------
    InputError
        A thermometer that was named was not measured, none is left, or there are too few readings; the growth
        never changes; or `sensor_std` is not positive.
    """
    if sensor_std is not None and not sensor_std > 0:
        raise InputError(f"sensor_std={sensor_std}: noise of 0 K or less; give a value above 0 K, or none")
    rows = examples_of(logs)
    where = logs[0].name if len(logs) == 1 else f"{logs[0].name} and {len(logs) - 1} more"
    read = np.mean(np.isfinite(rows.temperature), axis=0)
    measured = [i for i in range(len(SENSED)) if read[i] >= _READ]
    used = measured if sensors is None else [SENSED.index(name) for name in dict.fromkeys(sensors)]
    if absent := [i for i in used if i not in measured]:
        told = (
            f"was read at {100 * read[absent[0]]:.2g} % of the growth's readings"
            if read[absent[0]]
            else "was not measured"
        )
        raise InputError(f"{where}: {SENSED[absent[0]]} {told}; add its column, or leave it out")
    if not used:
        raise InputError(f"{where}: no temperature was measured; add a column 'base_temperature [degC]'")
    rows = rows.part(np.flatnonzero(np.isfinite(rows.temperature[:, measured]).all(axis=1)))
    if sensors is None:
        used = _worth_it(rows, used, model)
    if (least := _readings_for(used)) > rows.growth.size:
        told = f"{rows.growth.size} readings of the growth, of {WINDOW:g} s each, are too few"
        raise InputError(f"{where}: {told} for {len(used)} thermometers; measure at least {least}")
    if np.ptp(rows.growth) == 0:
        told = f"the growth is {1e6 * rows.growth[0]:g} um in every row, as by an instrument that is stuck"
        raise InputError(f"{where}: {told}; give a log in which it was measured")
    learner = Learner(used, model)
    ridge, held = learner.best(rows)
    near, far = doubt(held)
    noise = np.array(
        [
            sensor_std or max(_noise_of(log.temperature[:, i] for log in logs), _LEAST_NOISE)
            for i in range(len(SENSED))
        ]
    )
    line = learner.line(rows, ridge)
    return LearntMap(line, tuple(used), ridge, held, near, far, noise, rows, model, tuple(logs))


def _worth_it(rows: Examples, measured: Sequence[int], model: TrainingRun | None) -> list[int]:
    """The thermometers on the link, and of the others those that make the law better by enough."""
    used = [i for i in measured if SENSED[i] in ALONG]
    enough = rows.growth.size >= _readings_for([*used, 0])
    error = Learner(used, model).best(rows)[1].rms if used and enough else np.inf
    while enough and (others := [i for i in measured if i not in used]):
        tried = {i: Learner(sorted([*used, i]), model).best(rows)[1].rms for i in others}
        best = min(tried, key=tried.__getitem__)
        if tried[best] > (1 - WORTH_IT) * error:
            break
        used, error = sorted([*used, best]), tried[best]
        enough = rows.growth.size >= _readings_for([*used, 0])
    return used or list(measured)


def _readings_for(used: Sequence[int]) -> int:
    """Least number of readings of the growth that so many thermometers need."""
    return 2 * (len(used) + 3)


def _noise_of(signals: Iterable[Array]) -> float:
    """Noise, 1 sigma, by second differences, of which a slow signal has next to none.

    White noise of variance s^2 makes their mean square 6 s^2; changes beyond four sigma are left out.
    """
    sizes = []
    for signal in signals:
        read = signal[np.isfinite(signal)]
        if read.size > 10:
            change = np.diff(read, 2)
            most = 4 * np.sqrt(np.mean(change**2))
            sizes.append(np.mean(change[np.abs(change) <= most] ** 2) / 6)
    return float(np.sqrt(np.mean(sizes))) if sizes else 0.0
