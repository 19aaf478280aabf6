"""Parameter set of the linear observer, from runs of a machine, and what it will be worth.

Of four runs that drive the machine at random two make the model, one chooses what is free (the ridge, the
noise of the modes), and the last, with the duty cycle that the machine has to do, judges the law: how much of
the growth it takes out, and how honest its `correction_std` is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.gains import sensor_stds
from warmlink.controllers.design.identified import LinearModel, identified
from warmlink.controllers.design.training import DrivenRun
from warmlink.controllers.interface import SENSED, SIGMAS
from warmlink.controllers.linear_observer.component import COMPONENT
from warmlink.controllers.linear_observer.model import SENSORS
from warmlink.controllers.matrices import upper
from warmlink.controllers.replay import ReplayedOutputs, replay
from warmlink.controllers.start_values import Values, with_values
from warmlink.fmus.arguments import argument

Array = NDArray[np.float64]

NOISES = (0.003, 0.01, 0.03, 0.1)
"""Shares of the features by which the model may be off, of which one is chosen."""

LASTING = 600.0
"""s over which a feature is off, or one that the law is not told lasts."""

LEFT_WARM, EVEN = 1.0, 10.0
"""Before the first reading the machine may be as warm as the runs made it, and all of it by so many K."""

BEYOND = 1.25
"""By how much more than in the judged runs the law may be off in others."""

RATED = 1.5
"""Speeds and torques that are believed, as a multiple of the largest in the runs."""

ENOUGH = 0.9
"""Share of the growth below which it is said that thermometers do not show it."""

TOLD = ("speed", "torque", "ambient_temperature")

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
    found = identified(made_from, chooses, np.flatnonzero(stds).tolist())
    told = told_features(chooses.told)
    model = replace(found, B=found.B * told)
    largest = np.max([np.abs(run.duty[:, :2]).max(axis=0) for run in runs], axis=0)
    rated = np.where(largest > 0, RATED * largest, 1.0)
    fixed: dict[str, float | list[float]] = {
        "sample_time": sample_time,
        "rated_speed": float(rated[0]),
        "rated_torque": float(rated[1]),
        "sensor_std": stds.tolist(),
        **model_parameters(model),
        "start_spread": upper(start_spread(found)).tolist(),
        "model_std": 0.0,
    }
    tried = [{**fixed, "noise": upper(noise_of(found, share, told)).tolist()} for share in NOISES]
    off = [np.mean((replayed(each, chooses, stds).correction - chooses.elongation) ** 2) for each in tried]
    chosen = tried[int(np.argmin(off))]
    said = [replayed(chosen, run, stds) for run in judged]
    errors = [each.correction - run.elongation for each, run in zip(said, judged, strict=True)]
    missing = [
        float(np.quantile((BEYOND * error / SIGMAS) ** 2 - each.correction_std**2, 0.95))
        for error, each in zip(errors, said, strict=True)
    ]
    parameters = {**chosen, "model_std": max(0.0, *missing) ** 0.5}
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


def noise_of(model: LinearModel, share: float, told: Array) -> Array:
    """Covariance per second of the modes: a share of what drives them, all of what is not told."""
    driven = model.B * model.size * np.where(told, share, 1.0)
    return LASTING * driven @ driven.T


def told_features(told: Sequence[bool]) -> Array:
    """Which features a law knows that is told of speed, torque and surroundings or not, shape (features,)."""
    speed, torque, around = told
    heats = [True, speed, speed, speed and torque, torque]
    return np.array([*heats, around, *[speed and around] * SENSORS])


def replayed(parameters: Values, run: DrivenRun, stds: Array) -> ReplayedOutputs:
    """What the law itself says in a run, with noisy readings."""
    own = {**parameters, "sample_time": run.step}
    law = replace(COMPONENT, parameters=with_values(COMPONENT.parameters, own))
    rows = np.full((len(run.duty), law.u.size), np.nan)
    noise = stds * np.random.default_rng(SEED).standard_normal(run.temperature.shape)
    rows[:, [law.u.index[name] for name in SENSED]] = np.where(stds > 0, run.temperature + noise, np.nan)
    untold = [0.0, 0.0, float(parameters["reference_temperature"])]  # type: ignore[arg-type]
    rows[:, [law.u.index[name] for name in TOLD]] = np.where(run.told, run.duty, untold)
    return replay(law, rows)


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
