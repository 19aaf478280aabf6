"""Parameter set of the linear observer, from runs of a machine, and what it will be worth.

Of four runs that drive the machine at random two make the model, one chooses what is free (the ridge, the
noise of the modes), and the last, with the duty cycle that the machine has to do, judges the law: how much of
the growth it takes out, and how honest its `correction_std` is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from warmlink.controllers.design.gains import sensor_stds
from warmlink.controllers.design.identified import LinearModel, identified
from warmlink.controllers.design.training import DrivenRun
from warmlink.controllers.linear_observer.model import MODES, SENSORS, features
from warmlink.controllers.matrices import upper
from warmlink.fmus.arguments import argument

Array = NDArray[np.float64]

NOISES = (0.003, 0.01, 0.03, 0.1)
"""Shares of the features by which the model may be off, of which one is chosen: white over `LASTING`."""

LASTING = 600.0
"""s"""

LEFT_WARM, EVEN = 1.0, 10.0
"""Before the first reading the machine may be as warm as the runs made it, and all of it by so many K."""

BEYOND = 1.25
"""By how much more than in the judged runs the law may be off in others."""

RATED = 1.5
"""Speeds and torques that are believed, as a multiple of the largest in the runs."""

ENOUGH = 0.9
"""Share of the growth below which it is said that thermometers do not show it."""

AROUND = 5
"""Place of the surroundings among the features."""

SEED = 1
"""Of the noise of the thermometers by which laws are judged."""


@dataclass(frozen=True)
class Worth:
    """Shares of the largest growth that are taken out of runs on which nothing was fitted, the worst run's.

    Attributes
    ----------
    observer : by the law
    duty : by its model without any thermometer
    line : by a straight line through the same readings, least squares of the runs that made the model
    left : largest error of the law in m
    """

    observer: float
    duty: float
    line: float
    left: float


@dataclass(frozen=True)
class LinearDesign:
    """A parameter set of the linear observer, its model, and what it is worth."""

    parameters: Mapping[str, float | list[float]]
    model: LinearModel
    worth: Worth

    def told(self) -> list[str]:
        """Say what it is made of and worth, and where it is not enough."""
        worth, rated = self.worth, (self.parameters["rated_speed"], self.parameters["rated_torque"])
        lines = [
            f"{self.model.order} modes, found from runs of the FMUs",
            f"takes out {worth.observer:.1%} of the largest growth in runs that it was not made from, and is "
            f"at most {1e6 * worth.left:.2g} µm off; by the duty alone {worth.duty:.1%}, by a line through "
            f"the thermometers {worth.line:.1%}",
            "believes speeds up to {:.3g} rad/s and torques up to {:.3g} N.m".format(*rated),
        ]
        if worth.line > worth.observer:
            lines.append(f"a line does better here: take {argument('law', 'regression')}")
        if worth.observer < ENOUGH:
            lines.append(
                "duty and thermometers do not show all of the growth: wire a thermometer nearer to what grows"
            )
        return lines


def design_linear(
    runs: Sequence[DrivenRun],
    judged: Sequence[DrivenRun],
    sensors: Sequence[str],
    sensor_std: float | Mapping[str, float] = 0.1,
    sample_time: float = 1.0,
) -> LinearDesign:
    """Work out the parameter set of `linear_observer`.

    Parameters
    ----------
    runs : three or more, of which the last chooses and the others make the model
    judged : runs that judge it
    sensors : names of the thermometers that the law goes by
    sensor_std : standard deviation in K of a reading, one for all or one by sensor
    sample_time : s between two corrections

    Raises
    ------
    InputError
        A sensor is unknown, or its standard deviation not positive.
    """
    stds = np.array(sensor_stds(sensors, sensor_std))
    *made_from, chooses = runs
    model = identified(made_from, chooses, np.flatnonzero(stds).tolist())
    filters = [Filter(model, stds, share, chooses.step) for share in NOISES]
    chosen = min(filters, key=lambda each: float(np.mean(each.errors(chooses) ** 2)))
    variance = float(model.C[-1] @ chosen.spread @ model.C[-1])
    errors = [chosen.errors(run) for run in judged]
    doubled = BEYOND * max(float(np.quantile(np.abs(each), 0.95)) for each in errors)
    largest = np.max([np.abs(run.duty[:, :2]).max(axis=0) for run in runs], axis=0)
    rated = np.where(largest > 0, RATED * largest, 1.0)
    parameters: dict[str, float | list[float]] = {
        "sample_time": sample_time,
        "rated_speed": float(rated[0]),
        "rated_torque": float(rated[1]),
        "sensor_std": stds.tolist(),
        **model_parameters(model),
        "start_spread": upper(start_spread(model)).tolist(),
        "noise": upper(chosen.noise).tolist(),
        "model_std": float(np.sqrt(max(0.25 * doubled**2 - variance, 0.0))),
    }
    return LinearDesign(parameters, model, _worth(model, made_from, judged, errors, stds))


def model_parameters(model: LinearModel) -> dict[str, float | list[float]]:
    """The law's parameters that describe the machine, by name."""
    return {
        "dynamics": model.A.ravel().tolist(),
        "gains": model.B.ravel().tolist(),
        "cooled": np.isin(np.arange(SENSORS), model.used).astype(float).tolist(),
        "sensor_rows": model.C[:-1].ravel().tolist(),
        "sensor_reference": model.start[:-1].tolist(),
        "growth_row": model.C[-1].tolist(),
        "growth_reference": float(model.start[-1]),
        "even_profile": (_in_the_end(model)[:, AROUND]).tolist(),
        "reference_temperature": model.around,
    }


class Filter:
    """The law on whole runs, with the gain that it has in the end."""

    def __init__(self, model: LinearModel, stds: Array, share: float, step: float) -> None:
        self._model, self._stds, self._used = model, stds, np.flatnonzero(stds)
        nothing = np.zeros((SENSORS + 1, model.size.size))
        discrete = signal.cont2discrete((model.A, model.B, model.C, nothing), step)
        self._transition, self._reach = discrete[:2]
        driven = model.B * (share * model.size)
        self.noise = LASTING * driven @ driven.T
        rows = model.C[self._used]
        self.spread, self._gain = np.zeros((MODES, MODES)), np.zeros((MODES, self._used.size))
        if self._used.size:
            seen = np.diag(stds[self._used] ** 2)
            # As much noise in each mode as rounding: where nothing drives a mode, the equation has no answer.
            least = 1e-12 * np.trace(self.noise) * np.eye(MODES)
            before = linalg.solve_discrete_are(self._transition.T, rows.T, step * (self.noise + least), seen)
            self._gain = np.linalg.solve(rows @ before @ rows.T + seen, rows @ before).T
            self.spread = before - self._gain @ rows @ before
        else:
            self.spread = linalg.solve_discrete_lyapunov(self._transition, step * self.noise)

    def errors(self, run: DrivenRun) -> Array:
        """Error of the growth in m with noisy readings, shape (n,)."""
        model, used = self._model, self._used
        cooled = (self._stds > 0).astype(float)
        rises = run.temperature - model.start[:-1]
        rises = (rises + self._stds * np.random.default_rng(SEED).standard_normal(rises.shape))[:, used]
        z, rows, found = np.zeros(MODES), model.C[used], np.empty(len(rises))
        for i, (speed, torque, ambient) in enumerate(run.duty.tolist()):
            z = z + self._gain @ (rises[i] - rows @ z)
            shown = model.C @ z + model.start
            found[i] = shown[-1]
            above = cooled * (shown[:-1] - ambient)
            f = features(speed, torque, ambient - model.around, above.tolist())
            z = self._transition @ z + self._reach @ np.array(f)
        return found - run.elongation


def start_spread(model: LinearModel) -> Array:
    """Covariance of the modes before the first reading, shape (MODES, MODES).

    The modes are as far from 0 as the runs' heats have them in the end, and as surroundings warmer by `EVEN`.
    """
    ends = _in_the_end(model)
    warm, even = ends * (LEFT_WARM * model.size), EVEN * ends[:, AROUND]
    return warm @ warm.T + np.outer(even, even)


def _in_the_end(model: LinearModel) -> Array:
    """Modes to which each feature leads, shape (MODES, features)."""
    return np.asarray(np.linalg.solve(-model.A, model.B))


def _worth(
    model: LinearModel,
    runs: Sequence[DrivenRun],
    judged: Sequence[DrivenRun],
    errors: Sequence[Array],
    stds: Array,
) -> Worth:
    used, random = np.flatnonzero(stds), np.random.default_rng(SEED)

    def read(run: DrivenRun) -> Array:
        noisy = run.temperature + stds * random.standard_normal(run.temperature.shape)
        return np.column_stack([noisy[:, used], np.ones(len(noisy))])

    readings, growth = np.vstack([read(run) for run in runs]), np.concatenate([r.elongation for r in runs])
    line = np.linalg.lstsq(readings, growth, rcond=None)[0]
    by_duty = [model.outputs(run)[:, -1] + model.start[-1] - run.elongation for run in judged]
    by_line = [read(run) @ line - run.elongation for run in judged]
    grown = [float(np.abs(run.elongation).max()) for run in judged]

    def least(found: Sequence[Array]) -> float:
        shares = (1.0 - float(np.abs(e).max()) / max(g, 1e-12) for e, g in zip(found, grown, strict=True))
        return min(shares)

    largest = max(float(np.abs(each).max()) for each in errors)
    return Worth(least(errors), least(by_duty), least(by_line), largest)
