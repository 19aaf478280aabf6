"""The bank of slow lags that a remainder weighs, of every run: losses, speed, surroundings and temperatures.

As the component `Remainder` has them (fmus/remainder/equations.py), from rest as there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.remainder.equations import TEMPERATURES
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.baselines import filtered
from warmlink.orchestration.diagnosis.ladder.signals import held_means

_SHARES_OF_A_RUN = (1 / 30, 1 / 8, 1 / 2)
"""Time constants as shares of the longest fitted run."""

_DRIVES = {"speed": "speed", "torque": "torque", "current": "current", "power": "pad_power"}
"""Inputs of the component, and the last part of the names of the inputs that they are."""

_REFERENCE = 295.15


@dataclass(frozen=True)
class Bank:
    """Lags of what may drive an error.

    Attributes
    ----------
    places : temperatures whose lags are weighted
    drives : input of the system by the component's input that it is
    ambient : input that is the temperature around, "" if there is none
    constants : time constants in s
    scale : size of each feature in SI, shape (FEATURES,)
    """

    places: tuple[str, ...]
    drives: Mapping[str, str]
    ambient: str
    constants: tuple[float, ...]
    scale: Array

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which lags have a feature that something feeds, shape (LAGS,)."""
        speed, torque, current, power = (name in self.drives for name in _DRIVES)
        drives = [speed, speed, speed and torque, torque, current, power, bool(self.ambient)]
        places = [i < len(self.places) for i in range(TEMPERATURES)]
        return np.array([*drives, *places] * len(self.constants))

    def lags(self, problem: Problem, readings: Sequence[Array]) -> list[Array]:
        """Lags of a model's features by run, shape (rows, LAGS) each."""
        return [self._of(problem, run, each) for run, each in enumerate(readings)]

    def _of(self, problem: Problem, run: int, readings: Array) -> Array:
        table = _features(problem, run, self.places, self.drives, readings) / self.scale
        return np.column_stack([filtered(problem.data[run].time, table, each) for each in self.constants])

    def own(self, problem: Problem, run: int, course: Array) -> Array:
        """A model's course of one channel in a run: the growth itself, a temperature above that around."""
        if not np.abs(course).max() > 1:  # metres are small
            return course
        measured = problem.experiment.runs[run]
        room = measured.inputs.get(self.ambient, np.full(measured.time.size, _REFERENCE))
        return course - room[measured.row_at(problem.data[run].time)]


def bank_of(problem: Problem, readings: Sequence[Array]) -> Bank | None:
    """The bank for an experiment's fitted rows and a model's readings; None if nothing may drive an error."""
    places, drives = _temperatures(problem), _drives(problem)
    if not places and not drives:
        return None
    longest = max(float(d.time[d.fitted][-1]) for d in problem.data if d.fitted.any())
    features = [
        _features(problem, run, places, drives, each)[problem.data[run].fitted]
        for run, each in enumerate(readings)
    ]
    sizes = np.sqrt(np.mean(np.concatenate(features) ** 2, axis=0))
    return Bank(
        tuple(places),
        drives,
        _ambient(problem),
        tuple(share * longest for share in _SHARES_OF_A_RUN),
        np.where(sizes > 1e-9, sizes, 1.0),
    )


def _temperatures(problem: Problem) -> list[str]:
    """Temperatures whose lags are weighted: those that are measured, then those that drive the machine.

    A weighted sum of outputs is none: the system that the remainder is put into has no output that is it.
    """
    rig, inputs = problem.experiment.rig, problem.experiment.runs[0].inputs
    measured = [n for n in problem.variables if rig.unit(n) == "K" and n not in rig.sums]
    driving = [
        n for n in inputs if rig.unit(n) == "K" and not n.endswith(("ambient_temperature", "pad_temperature"))
    ]
    return [*measured, *driving][:TEMPERATURES]


def _drives(problem: Problem) -> dict[str, str]:
    """Input of the system by the component's input that it is."""
    inputs = problem.experiment.runs[0].inputs
    found = {}
    for name, called in _DRIVES.items():
        of = next((each for each in inputs if each.rpartition(".")[2] == called), None)
        if of is not None:
            found[name] = of
    return found


def _ambient(problem: Problem) -> str:
    inputs = problem.experiment.runs[0].inputs
    return next((name for name in inputs if name.endswith("ambient_temperature")), "")


def _features(
    problem: Problem, run: int, places: Sequence[str], drives: Mapping[str, str], readings: Array
) -> Array:
    """What may drive an error, as the component has it, shape (rows, FEATURES)."""
    measured, at = problem.experiment.runs[run], problem.data[run].time
    rows = measured.time.size

    def signal(name: str, other: float) -> Array:
        values = measured.inputs.get(name, np.full(rows, other))
        return np.where(np.isfinite(values), values, other)

    speed, torque, current, power = (
        signal(drives.get(name, ""), 0.0) for name in ("speed", "torque", "current", "power")
    )
    logged = [np.abs(speed), speed**2, np.abs(speed * torque), torque**2, current**2, power]
    room = held_means(measured.time, signal(_ambient(problem), _REFERENCE)[:, None], at)[:, 0]
    rises = []
    for name in places:
        if name in problem.variables:
            now = readings[:, problem.variables.index(name)]
            rises.append((now + np.append(now[0], now[:-1])) / 2 - room)
        else:
            rises.append(held_means(measured.time, signal(name, _REFERENCE)[:, None], at)[:, 0] - room)
    idle = [np.zeros(at.size)] * (TEMPERATURES - len(places))
    means = held_means(measured.time, np.column_stack(logged), at)
    return np.column_stack([means, room - _REFERENCE, *rises, *idle])
