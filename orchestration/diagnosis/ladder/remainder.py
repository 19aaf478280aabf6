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
from warmlink.orchestration.diagnosis.ladder.signals import growth_output

_RIDGES = (10.0, 1.0, 0.1, 0.01, 1e-3)
"""Strengths that are tried, strongest first: shares of the lags' own power that are added."""

_BLOCKS, _MANY = 5, 3
"""Blocks in time of each fitted run; runs from which each is a block of its own."""

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
    bank : the lags that are weighted
    weights : of the lags and of the model's own course, a constant, and the error in blocks, by variable
    """

    readings: tuple[Array, ...]
    values: Mapping[str, float]
    wires: Mapping[str, str]
    channels: Mapping[str, str]
    bank: Bank
    weights: Mapping[str, tuple[Array, float, float]]

    def corrected(self, problem: Problem, readings: Sequence[Array]) -> tuple[Array, ...]:
        """A model's readings with what was learnt, in the runs of any experiment on the same machine.

        Parameters
        ----------
        problem : the experiment
        readings : of the model by run in SI, shape (rows, channels) each
        """
        found = [each.copy() for each in readings]
        for run, (table, lags) in enumerate(zip(found, self.bank.lags(problem, readings), strict=True)):
            for variable, (weights, offset, _) in self.weights.items():
                channel = problem.variables.index(variable)
                own = self.bank.own(problem, run, readings[run][:, channel])
                table[:, channel] += lags @ weights[:-1] + weights[-1] * own + offset
        return tuple(found)

    def only(self, variables: Sequence[str], problem: Problem, readings: Sequence[Array]) -> Remainder:
        """The same for some of the variables alone; the experiment and the model as for `corrected`."""
        kept = {name: each for name, each in self.weights.items() if name in variables}
        gone = {
            key
            for name, each in self.weights.items()
            if name not in kept
            for key in _values_of(self.bank.places, name, *each)
        }
        values = {key: value for key, value in self.values.items() if key not in gone}
        found = replace(self, values=values, weights=kept)
        return replace(found, readings=found.corrected(problem, readings))


def leaves_out_runs(problem: Problem) -> bool:
    """Whether so many runs are fitted that each is left out in turn, as another duty cycle."""
    return len(problem.fitted_runs) >= _MANY


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
    growth = "" if growth in problem.experiment.rig.sums else growth  # which no output of a system is
    lags, weighted = bank.lags(problem, readings), {}
    values = {f"time_constant[{k}]": constant for k, constant in enumerate(bank.constants, 1)}
    values |= {f"scale[{j}]": float(each) for j, each in enumerate(bank.scale, 1)}
    fitted = np.concatenate([table[d.fitted] for table, d in zip(lags, problem.data, strict=True)])
    values |= _ends(fitted, bank.used)
    for channel, variable in enumerate(problem.variables):
        own = [bank.own(problem, run, each[:, channel]) for run, each in enumerate(readings)]
        taken = variable in (*bank.places, growth)
        measured = sum(name in problem.variables for name in bank.places)
        known = _channel(problem, channel, lags, readings, own, measured) if taken else None
        if known is not None:
            weighted[variable] = known
            values |= _values_of(bank.places, variable, *known)
    if not weighted:
        return None
    wires = {f"temperature[{i}]": name for i, name in enumerate(bank.places, 1)}
    wires |= {"ambient_temperature": bank.ambient} if bank.ambient else {}
    wires |= dict(bank.drives) | ({"elongation": growth} if growth else {})
    channels = {name: f"corrected_temperature[{i}]" for i, name in enumerate(bank.places, 1)}
    channels |= {growth: "corrected_elongation"} if growth else {}
    found = Remainder(tuple(readings), values, wires, channels, bank, weighted)
    return replace(found, readings=found.corrected(problem, readings))


def _ends(lags: Array, used: NDArray[np.bool_]) -> dict[str, float]:
    """The band in which the used lags were fitted; the others have none, as nothing is learnt of them."""
    least, largest = lags.min(axis=0).tolist(), lags.max(axis=0).tolist()
    return {
        f"{name}[{j + 1}]": ends[j]
        for j in np.flatnonzero(used).tolist()
        for name, ends in (("least", least), ("largest", largest))
    }


class _Moments:
    """Sums of products of columns and what they explain, by block of rows: of lags, the target, and 1.

    Whatever blocks and columns are left out, a regression needs no more than these.
    """

    def __init__(self, x: Array, y: Array, block: NDArray[np.int64]) -> None:
        self._zero = np.append(x.mean(axis=0), y.mean())
        table = np.column_stack([np.column_stack([x, y]) - self._zero, np.ones(y.size)])
        parts = (table[block == b] for b in np.unique(block))
        self._by_block = np.array([part.T @ part for part in parts])
        self._whole = self._by_block.sum(axis=0)

    def fitted(self, form: _Form) -> tuple[Array, float]:
        """Weight of each lag, 0 for those that are not used, and a constant."""
        told = -form.left(self._whole)
        weights = told[:-2]
        return weights, float(told[-1] + self._zero[-1] - self._zero[:-1] @ weights)

    def squares(self, form: _Form | None) -> Array:
        """Squared error of each block of rows by what the others teach, or by nothing, shape (blocks,)."""
        if form is None:
            added = self._zero[-1]  # what is left counts from 0
            return np.asarray(
                self._by_block[:, -2, -2]
                + 2 * added * self._by_block[:, -2, -1]
                + added**2 * self._by_block[:, -1, -1]
            )
        left = form.left(self._whole - self._by_block)
        return np.asarray(np.einsum("bi,bij,bj->b", left, self._by_block, left))


@dataclass(frozen=True)
class _Form:
    """Which lags are weighted, and how strongly the ridge holds them back."""

    lags: NDArray[np.bool_]
    share: float

    def left(self, moments: Array) -> Array:
        """What is left of the target, as weights of lags, target and 1, shape (..., lags + 2)."""
        used = np.flatnonzero(self.lags)
        count = moments[..., -1, -1]
        mean = moments[..., -1, :-1] / count[..., None]
        spread = moments[..., :-1, :-1] / count[..., None, None] - mean[..., :, None] * mean[..., None, :]
        power = np.diagonal(spread, axis1=-2, axis2=-1)[..., used]
        least = 1e-12 * np.diagonal(moments, axis1=-2, axis2=-1)[..., used] / count[..., None]
        size = np.where(power > least, np.sqrt(np.maximum(power, 1e-300)), np.inf)
        gram = spread[..., used[:, None], used] / size[..., :, None] / size[..., None, :]
        target = spread[..., used, -1] / size
        weights = np.linalg.solve(gram + self.share * np.eye(used.size), target[..., None])[..., 0] / size
        result = np.zeros(moments.shape[:-1])
        result[..., used], result[..., -2] = -weights, 1.0
        result[..., -1] = np.sum(mean[..., used] * weights, axis=-1) - mean[..., -1]
        return result


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
        parts = 1 if leaves_out_runs(problem) else _BLOCKS
        blocks.append(parts * run + parts * np.arange(there.size) // max(there.size, 1))
    x, y, block = np.concatenate(rows), np.concatenate(targets), np.concatenate(blocks)
    forms = _forms(x, measured) if y.size >= _FEWEST else []
    if not forms:
        return None
    moments = _Moments(x, y, block)
    tried = [(form, moments.squares(form)) for form in forms]
    least = min((squares for _, squares in tried), key=lambda squares: float(squares.sum()))
    if not _clearly(moments.squares(None), least):
        return None
    form, squares = next(each for each in tried if not _clearly(each[1], least))
    return *moments.fitted(form), float(np.sqrt(squares.sum() / y.size))


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
