"""The learnt remainder: what a model leaves on fitted rows as weighted slow lags, where blocks ask for it.

Ridge on the lags that the component `Remainder` has (fmus/remainder/equations.py), from rest as there. For
each channel the strength of the ridge is chosen by leaving out blocks in time one after another; where these
are not foretold better with it than without it, by more than a standard error, the channel has no remainder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.remainder.equations import FEATURES, LAGS, TEMPERATURES, TIME_CONSTANTS
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.bank import Bank, bank_of
from warmlink.orchestration.diagnosis.ladder.least_squares import regressed
from warmlink.orchestration.diagnosis.ladder.signals import growth_output

_RIDGES = (10.0, 1.0, 0.1, 0.01, 1e-3)
"""Strengths that are tried, strongest first: shares of the lags' own power that are added."""

_BLOCKS = 5
"""Blocks in time of each fitted run."""

_FEWEST = 60
"""Fitted readings of a channel, at least."""


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
    bank : the lags that are weighted
    weights : of the lags and of the model's own course, and a constant, by variable
    """

    readings: tuple[Array, ...]
    values: Mapping[str, float]
    wires: Mapping[str, str]
    channels: Mapping[str, str]
    left: float
    bank: Bank
    weights: Mapping[str, tuple[Array, float]]

    def corrected(self, problem: Problem, readings: Sequence[Array]) -> tuple[Array, ...]:
        """A model's readings with what was learnt, in the runs of any experiment on the same machine.

        Parameters
        ----------
        problem : the experiment
        readings : of the model by run in SI, shape (rows, channels) each
        """
        found = [each.copy() for each in readings]
        for run, (table, lags) in enumerate(zip(found, self.bank.lags(problem, readings), strict=True)):
            for variable, (weights, offset) in self.weights.items():
                channel = problem.variables.index(variable)
                own = self.bank.own(problem, run, readings[run][:, channel])
                table[:, channel] += lags @ weights[:-1] + weights[-1] * own + offset
        return tuple(found)


def remainder(problem: Problem, readings: Sequence[Array]) -> Remainder | None:
    """Learn what a model leaves on the fitted rows of a whole experiment; None if nothing can be learnt.

    Parameters
    ----------
    problem : the whole experiment
    readings : of the model by run in SI, shape (rows, channels)
    """
    bank, growth = bank_of(problem, readings), growth_output(problem)
    if bank is None:
        return None
    lags, weighted, lefts = bank.lags(problem, readings), {}, []
    values = {f"time_constant[{k}]": constant for k, constant in enumerate(bank.constants, 1)}
    values |= {f"scale[{j}]": float(each) for j, each in enumerate(bank.scale, 1)}
    values |= _ends(np.concatenate([table[d.fitted] for table, d in zip(lags, problem.data, strict=True)]))
    for channel, variable in enumerate(problem.variables):
        own = [bank.own(problem, run, each[:, channel]) for run, each in enumerate(readings)]
        taken = variable in (*bank.places, growth)
        measured = sum(name in problem.variables for name in bank.places)
        known = _channel(problem, channel, lags, readings, own, measured) if taken else None
        if known is None:
            lefts.append(_rms(problem, channel, readings))
            continue
        lefts.append(known[2])
        weighted[variable] = known[:2]
        values |= _values_of(bank.places, variable, *known)
    if not weighted:
        return None
    wires = {f"temperature[{i}]": name for i, name in enumerate(bank.places, 1)}
    wires |= {"ambient_temperature": bank.ambient} if bank.ambient else {}
    wires |= dict(bank.drives) | ({"elongation": growth} if growth else {})
    channels = {name: f"corrected_temperature[{i}]" for i, name in enumerate(bank.places, 1)}
    channels |= {growth: "corrected_elongation"} if growth else {}
    left = float(np.mean(np.log(np.maximum(lefts, 1e-15))))
    found = Remainder(tuple(readings), values, wires, channels, left, bank, weighted)
    return replace(found, readings=found.corrected(problem, readings))


def _ends(lags: Array) -> dict[str, float]:
    """The band in which the lags were fitted."""
    ends = enumerate(zip(lags.min(axis=0).tolist(), lags.max(axis=0).tolist(), strict=True), 1)
    return {
        f"{name}[{j}]": each
        for j, both in ends
        for name, each in zip(("least", "largest"), both, strict=True)
    }


def _rms(problem: Problem, channel: int, readings: Sequence[Array]) -> float:
    """Error of a channel on fitted rows."""
    runs = zip(problem.data, readings, strict=True)
    errors = np.concatenate([(d.readings - r)[d.fitted, channel] for d, r in runs])
    read = np.isfinite(errors)
    return float(np.sqrt(np.mean(errors[read] ** 2))) if read.any() else 1.0


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
