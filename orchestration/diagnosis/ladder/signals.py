"""What plain fits are made of: the inputs of a run as means between its rows, and its readings there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.start import at_start
from warmlink.orchestration.diagnosis.fit.problem import Problem

_MOST_PRODUCTS = 6
"""Inputs that are no temperatures, of more of which squares and products are not tried."""


Feature = tuple[str, ...]
"""What a plain fit goes by: a signal's name, or the names of two whose product's size it is.

A name is empty where it is no signal, but whether there is one.
"""


@dataclass(frozen=True)
class Signals:
    """One run as plain fits see it, in SI.

    Attributes
    ----------
    time : s, rising, shape (rows,)
    readings : NaN where there is none, shape (rows, channels)
    start : reading of each channel at 0 s, the first one there is if none is early, shape (channels,)
    inputs : means since the row before, shape (rows, inputs)
    relative : which of the inputs are temperatures, shape (inputs,)
    products : squares and products of the inputs that are no temperatures, shape (rows, products)
    fitted : rows that fitting may use, shape (rows,)
    ambient : K, above which temperatures rise, shape (rows,); 0 where none was logged
    names : of the inputs, shape (inputs,); empty for whether there is one
    pairs : names of the inputs whose products these are, shape (products,)
    channels : names of the channels
    room : name of the ambient temperature
    """

    time: Array
    readings: Array
    start: Array
    inputs: Array
    relative: NDArray[np.bool_]
    products: Array
    fitted: NDArray[np.bool_]
    ambient: Array
    names: tuple[str, ...]
    pairs: tuple[Feature, ...]
    channels: tuple[str, ...]
    room: str

    def columns(self, rich: bool) -> Array:
        """Inputs, with squares and products if these are asked for, shape (rows, columns)."""
        return np.column_stack([self.inputs, self.products]) if rich else self.inputs

    def features(self, rich: bool) -> list[Feature]:
        """What each of these columns is."""
        return [*((name,) for name in self.names), *(self.pairs if rich else ())]


def signals_of(problem: Problem) -> tuple[Signals, ...]:
    """Every run of an experiment, with the same inputs in each."""
    rig, runs = problem.experiment.rig, problem.experiment.runs
    names = sorted({name for run in runs for name in (*run.inputs, *run.covariates)})
    tables = [_table(run, names) for run in runs]
    # What never changes in any run tells nothing.
    changes = np.ptp(np.concatenate(tables), axis=0) > 0
    unit = {name: rig.unit(name) if name in rig.variables else "K" for name in names}
    warm = np.array([unit[name] == "K" for name in names for _ in range(2)], dtype=bool)
    warm[1::2] = False  # whether there is a value at all
    result = []
    for run, data, table in zip(runs, problem.data, tables, strict=True):
        means = held_means(run.time, table[:, changes], data.time)
        relative = warm[changes]
        starts = [_start(data.time, column) for column in data.readings.T]
        called = [each for name in names for each in (name, "")]
        shown = [name for name, changing in zip(called, changes, strict=True) if changing]
        rest = [name for name, is_warm in zip(shown, relative, strict=True) if not is_warm]
        pairs = _pairs(len(rest))
        result.append(
            Signals(
                data.time,
                data.readings,
                np.array(starts),
                means,
                relative,
                _products(run.time, table[:, changes][:, ~relative], data.time, pairs),
                data.fitted,
                np.zeros(data.time.size)
                if run.ambient is None
                else np.interp(data.time, run.time, run.ambient),
                tuple(shown),
                tuple((rest[i], rest[j]) for i, j in pairs),
                tuple(problem.variables),
                next((name for name in run.inputs if name.endswith("ambient_temperature")), ""),
            )
        )
    return tuple(result)


def _table(run: Run, names: Sequence[str]) -> Array:
    """Inputs at a run's own rows, each with whether it has a value, shape (rows, 2 * names)."""
    columns = []
    for name in names:
        values = {**run.covariates, **run.inputs}.get(name, np.zeros(run.time.size))
        there = np.isfinite(values)
        idle = float(np.mean(values[there])) if there.any() else 0.0
        columns += [np.where(there, values, idle), there.astype(float)]
    return np.column_stack(columns) if columns else np.zeros((run.time.size, 0))


def held_means(time: Array, table: Array, at: Array) -> Array:
    """Means of held signals from each time to the next, that before the first one at the first."""
    total = np.vstack([np.zeros(table.shape[1]), np.cumsum(table[:-1] * np.diff(time)[:, None], axis=0)])
    there = interpolated(at, time, total)
    spacing = np.diff(at)
    first = table[np.clip(np.searchsorted(time, at[:1], side="right") - 1, 0, None)]
    return np.vstack([first, np.diff(there, axis=0) / np.where(spacing > 0, spacing, 1.0)[:, None]])


def _pairs(count: int) -> list[tuple[int, int]]:
    """Pairs of inputs whose products are tried, each with itself as well; none of many inputs."""
    if count > _MOST_PRODUCTS:
        return []
    return [(i, i) for i in range(count)] + list(combinations(range(count), 2))


def _products(time: Array, table: Array, at: Array, pairs: Sequence[tuple[int, int]]) -> Array:
    """Means of squares and products of held signals."""
    products = [np.abs(table[:, i] * table[:, j]) for i, j in pairs]
    return held_means(time, np.column_stack(products), at) if products else np.zeros((at.size, 0))


def _start(time: Array, values: Array) -> float:
    found = at_start(time, values)
    if found is not None:
        return found
    read = values[np.isfinite(values)]
    return float(read[0]) if read.size else 0.0


def interpolated(at: Array, time: Array, table: Array) -> Array:
    """Columns of a table at other times, shape (times, columns), of which there may be none."""
    columns = [np.interp(at, time, column) for column in table.T]
    return np.column_stack(columns) if columns else np.zeros((at.size, 0))


def growth_output(problem: Problem) -> str:
    """Output that is the growth: as the machine says, else a length; "" if none was measured."""
    unit = problem.experiment.rig.unit
    stated = [name for name in problem.experiment.rig.machine.growth if name in problem.variables]
    return next(iter([*stated, *(name for name in problem.variables if unit(name) == "m")]), "")
