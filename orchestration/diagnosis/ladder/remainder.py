"""The learnt remainder: what a model leaves on fitted rows as weighted slow lags, where blocks ask for it.

Ridge on the lags that the component `Remainder` has (fmus/remainder/equations.py), from rest as there. For
each channel the strength of the ridge is chosen by leaving out blocks in time one after another; where these
are not foretold better with it than without it, by more than a standard error, the channel has no remainder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.remainder.equations import FEATURES, LAGS, TEMPERATURES, TIME_CONSTANTS
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.baselines import filtered
from warmlink.orchestration.diagnosis.ladder.least_squares import regressed
from warmlink.orchestration.diagnosis.ladder.signals import growth_output, held_means

_SHARES_OF_A_RUN = (1 / 30, 1 / 8, 1 / 2)
"""Time constants as shares of the longest fitted run."""

_RIDGES = (10.0, 1.0, 0.1, 0.01, 1e-3)
"""Strengths that are tried, strongest first: shares of the lags' own power that are added."""

_BLOCKS = 5
"""Blocks in time of each fitted run."""

_FEWEST = 60
"""Fitted readings of a channel, at least."""

_DRIVES = {"speed": "speed", "torque": "torque", "current": "current", "power": "pad_power"}
"""Inputs of the component, and the last part of the names of the inputs that they are."""

_REFERENCE = 295.15


@dataclass(frozen=True)
class Remainder:
    """A remainder that was learnt.

    Attributes
    ----------
    readings : those of the model with it by run in SI, shape (rows, channels)
    values : parameters of the component in SI
    wires : input of the component by the variable of the system that it takes; an input of the system stands
        for what feeds it
    channels : output of the component by variable
    left : error in blocks, mean over the channels of its logarithm
    """

    readings: tuple[Array, ...]
    values: Mapping[str, float]
    wires: Mapping[str, str]
    channels: Mapping[str, str]
    left: float


def remainder(problem: Problem, readings: Sequence[Array]) -> Remainder | None:
    """Learn what a model leaves on the fitted rows of a whole experiment; None if nothing can be learnt.

    Parameters
    ----------
    problem : the whole experiment
    readings : of the model by run in SI, shape (rows, channels)
    """
    places, growth = _temperatures(problem), growth_output(problem)
    measured = sum(name in problem.variables for name in places)
    drives = _drives(problem)
    if not places and not drives:
        return None
    spans = [float(d.time[d.fitted][-1]) for d in problem.data if d.fitted.any()]
    constants = [share * max(spans) for share in _SHARES_OF_A_RUN]
    features = [_features(problem, run, places, drives, each) for run, each in enumerate(readings)]
    fitted = [data.fitted for data in problem.data]
    sizes = np.sqrt(
        np.mean(np.concatenate([f[r] for f, r in zip(features, fitted, strict=True)]) ** 2, axis=0)
    )
    scale = np.where(sizes > 1e-9, sizes, 1.0)
    lags = [
        np.column_stack([filtered(data.time, table / scale, constant) for constant in constants])
        for data, table in zip(problem.data, features, strict=True)
    ]
    corrected = [each.copy() for each in readings]
    values = {f"time_constant[{k}]": constant for k, constant in enumerate(constants, 1)}
    values |= {f"scale[{j}]": float(each) for j, each in enumerate(scale, 1)}
    inside = np.concatenate([table[rows] for table, rows in zip(lags, fitted, strict=True)])
    ends = zip(inside.min(axis=0).tolist(), inside.max(axis=0).tolist(), strict=True)
    for j, (least, largest) in enumerate(ends, 1):
        values |= {f"least[{j}]": least, f"largest[{j}]": largest}
    learnt, lefts = False, []
    for channel, variable in enumerate(problem.variables):
        own = [_own(problem, run, each[:, channel]) for run, each in enumerate(readings)]
        taken = variable in (*places, growth)
        known = _channel(problem, channel, lags, readings, own, measured) if taken else None
        if known is None:
            lefts.append(_rms(problem, channel, readings))
            continue
        learnt = True
        lefts.append(known[2])
        weights, offset, left = known
        for table, run, course in zip(corrected, lags, own, strict=True):
            table[:, channel] += run @ weights[:-1] + weights[-1] * course + offset
        values |= _values_of(places, variable, weights, offset, left)
    if not learnt:
        return None
    wires = {f"temperature[{i}]": name for i, name in enumerate(places, 1)}
    wires |= {"ambient_temperature": _ambient(problem)} if _ambient(problem) else {}
    wires |= drives | ({"elongation": growth} if growth else {})
    channels = {name: f"corrected_temperature[{i}]" for i, name in enumerate(places, 1)}
    channels |= {growth: "corrected_elongation"} if growth else {}
    left = float(np.mean(np.log(np.maximum(lefts, 1e-15))))
    return Remainder(tuple(corrected), values, wires, channels, left)


def _rms(problem: Problem, channel: int, readings: Sequence[Array]) -> float:
    """Error of a channel on fitted rows."""
    runs = zip(problem.data, readings, strict=True)
    errors = np.concatenate([(d.readings - r)[d.fitted, channel] for d, r in runs])
    read = np.isfinite(errors)
    return float(np.sqrt(np.mean(errors[read] ** 2))) if read.any() else 1.0


def _temperatures(problem: Problem) -> list[str]:
    """Temperatures whose lags are weighted: those that are measured, then those that drive the machine."""
    rig, inputs = problem.experiment.rig, problem.experiment.runs[0].inputs
    measured = [name for name in problem.variables if rig.unit(name) == "K"]
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
    idle = [_REFERENCE - room] * (TEMPERATURES - len(places))
    means = held_means(measured.time, np.column_stack(logged), at)
    return np.column_stack([means, room - _REFERENCE, *rises, *[0.0 * each for each in idle]])


@dataclass(frozen=True)
class _Form:
    """Which lags are weighted, and how strongly the ridge holds them back."""

    lags: NDArray[np.bool_]
    share: float

    def fitted(self, x: Array, y: Array) -> tuple[Array, float]:
        """Weight of each lag, 0 for those that are not used, and a constant."""
        weights, zero = regressed(x[:, self.lags], y[:, None], self.share)
        whole = np.zeros(self.lags.size)
        whole[self.lags] = weights[:, 0]
        return whole, float(zero[0])

    def squares(self, x: Array, y: Array, block: NDArray[np.int64]) -> Array:
        """Squared error of each block of rows by what the others teach, shape (blocks,)."""
        found = []
        for b in np.unique(block):
            weights, zero = self.fitted(x[block != b], y[block != b])
            found.append(np.sum((y - x @ weights - zero)[block == b] ** 2))
        return np.array(found)


def _forms(x: Array, measured: int) -> list[_Form]:
    """Forms that are tried, the simplest first: without the model's own temperatures, with one time constant.

    Of the temperatures the first ones are `measured`, and so the model's.
    """
    alive, place = np.ptp(x, axis=0) > 1e-9 * np.abs(x).max(axis=0), np.arange(x.shape[1])
    drive, constant, own = place % FEATURES, place // FEATURES, place >= LAGS
    given = (drive < FEATURES - TEMPERATURES) | (drive >= FEATURES - TEMPERATURES + measured)
    whole = np.ones(place.size, dtype=bool)
    each = [*(constant == k for k in range(TIME_CONSTANTS)), whole]
    groups = (alive & (own | (group & some)) for group in (given, whole) for some in each)
    return [_Form(lags, share) for lags in groups if lags.any() for share in _RIDGES]


def _own(problem: Problem, run: int, course: Array) -> Array:
    """A model's course of one channel in a run: the growth itself, a temperature above that around."""
    measured, name = problem.experiment.runs[run], _ambient(problem)
    if not np.abs(course).max() > 1:  # metres are small
        return course
    room = measured.inputs.get(name, np.full(measured.time.size, _REFERENCE))
    return course - room[measured.row_at(problem.data[run].time)]


def _channel(
    problem: Problem,
    channel: int,
    lags: Sequence[Array],
    readings: Sequence[Array],
    own: Sequence[Array],
    measured: int,
) -> tuple[Array, float, float] | None:
    """Weights of the lags and of the model's own course, a constant, and the error left in blocks.

    None where blocks do not ask for it.
    """
    rows, targets, blocks = [], [], []
    for run, (data, table) in enumerate(zip(problem.data, lags, strict=True)):
        left = data.readings[:, channel] - readings[run][:, channel]
        there = np.flatnonzero(data.fitted & np.isfinite(left))
        rows.append(np.column_stack([table, own[run]])[there])
        targets.append(left[there])
        blocks.append(_BLOCKS * run + _BLOCKS * np.arange(there.size) // max(there.size, 1))
    x, y, block = np.concatenate(rows), np.concatenate(targets), np.concatenate(blocks)
    forms = _forms(x, measured) if y.size >= _FEWEST else []
    if not forms:
        return None
    tried = [(form, form.squares(x, y, block)) for form in forms]
    least = min((squares for _, squares in tried), key=lambda squares: float(squares.sum()))
    if not _clearly(np.array([np.sum(y[block == b] ** 2) for b in np.unique(block)]), least):
        return None
    form, squares = next(each for each in tried if not _clearly(each[1], least))
    return *form.fitted(x, y), float(np.sqrt(squares.sum() / y.size))


def _clearly(more: Array, less: Array) -> bool:
    """Whether blocks are foretold better by more than a standard error."""
    gained = more - less
    return bool(gained.sum() > np.sqrt(gained.size) * gained.std(ddof=1))


def _values_of(
    places: Sequence[str], variable: str, weights: Array, offset: float, left: float
) -> dict[str, float]:
    """Parameters of one channel."""
    if variable not in places:
        found = {f"elongation_weight[{j}]": float(each) for j, each in enumerate(weights[:-1], 1)}
        return {
            **found,
            "elongation_gain": float(weights[-1]),
            "elongation_offset": offset,
            "elongation_error": left,
        }
    i = places.index(variable)
    found = {f"temperature_weight[{i * LAGS + j}]": float(each) for j, each in enumerate(weights[:-1], 1)}
    found[f"temperature_gain[{i + 1}]"] = float(weights[-1])
    return {**found, f"temperature_offset[{i + 1}]": offset, f"temperature_error[{i + 1}]": left}
