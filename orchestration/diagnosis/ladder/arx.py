"""ARX models that go by their own readings: each channel by itself, or all together.

L. Ljung, System Identification, 2nd edition (1999), section 4.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.ladder.least_squares import FEWEST, Fitted, Form, Linear, regressed
from warmlink.orchestration.diagnosis.ladder.signals import Signals, interpolated
from warmlink.orchestration.diagnosis.model.recursions import recursion

_STEPS = (100, 1000)
"""Steps of the longest run on which a model is fitted, at most, and none shorter than the time between rows.

More of them than rows are kept of a run: in steps as long as the time between rows each reading is
interpolated alike, in others it is now a row's own and now a mean of two.
"""


def arx(runs: Sequence[Signals]) -> Iterator[Form]:
    """Every form of an ARX model that is tried on these runs."""
    spacing = max(float(np.median(np.diff(run.time))) for run in runs)
    span = max(float(run.time[-1]) for run in runs)
    steps = sorted({max(spacing, span / count) for count in _STEPS})
    for step, rich, order, coupled, share in product(
        steps, (False, True), (1, 2), (False, True), (1e-7, 1e-3)
    ):
        yield _autoregressive(step, rich, order, coupled, share)


def _autoregressive(step: float, rich: bool, order: int, coupled: bool, share: float) -> Form:
    """Readings from the last ones and the inputs, in steps in s; after the start it uses its own."""

    def form(runs: Sequence[Signals]) -> Fitted:
        grids = [_on_grid(run, step, rich) for run in runs]
        channels = runs[0].readings.shape[1]
        groups = [list(range(channels))] if coupled else [[c] for c in range(channels)]
        result = [np.full(run.readings.shape, np.nan) for run in runs]
        linear: dict[int, Linear] = {}
        for group in groups:
            found = _one_step(grids, group, order, share)
            if found is None:
                continue
            ahead, driven, constant = found
            for run, grid, table in zip(runs, grids, result, strict=True):
                free = _free(grid, run.start[group], ahead, driven, constant)
                for k, channel in enumerate(group):
                    table[:, channel] = np.interp(run.time, grid.time, free[:, k])
            by_feature = dict(zip(runs[0].features(rich), driven.T, strict=True))
            whole = Linear(
                step, ahead, by_feature, constant, tuple(group), above=np.zeros(len(group), dtype=bool)
            )
            linear |= {channel: replace(whole, place=k) for k, channel in enumerate(group)}
        return Fitted(result, linear)

    return form


@dataclass(frozen=True)
class _Grid:
    """A run in even steps: times, interpolated readings, inputs, and which steps may be fitted."""

    time: Array
    readings: Array
    inputs: Array
    fitted: NDArray[np.bool_]


def _on_grid(run: Signals, step: float, rich: bool) -> _Grid:
    time = float(step) * np.arange(int(np.ceil(run.time[-1] / step)) + 1, dtype=np.float64)
    readings = np.full((time.size, run.readings.shape[1]), np.nan)
    for i, column in enumerate(run.readings.T):
        read = np.isfinite(column)
        if read.any():
            readings[:, i] = np.interp(time, run.time[read], column[read], right=np.nan)
    columns = run.columns(rich)
    columns = np.vstack([columns, columns[-1:]])  # goes on to the end of the last step
    at = np.concatenate([[0.0], run.time, [max(time[-1], run.time[-1])]])
    total = np.cumsum(columns * np.diff(at)[:, None], axis=0)
    ends = interpolated(time, at, np.vstack([0.0 * total[:1], total]))
    last = float(run.time[run.fitted][-1]) if run.fitted.any() else -1.0
    first = float(run.time[run.fitted][0]) if run.fitted.any() else 0.0
    inside = (time[1:] <= last) & (time[:-1] >= first - step)
    return _Grid(time, readings, np.diff(ends, axis=0) / step, inside)


def _one_step(
    grids: Sequence[_Grid], group: Sequence[int], order: int, share: float
) -> tuple[Array, Array, Array] | None:
    """Weights of past readings, (order, n, n), and of inputs, (n, inputs), and a constant, (n,)."""
    rows, targets, n = [], [], len(group)
    for grid in grids:
        y = grid.readings[:, group]
        past = [y[order - 1 - k : len(y) - 1 - k] for k in range(order)]
        x, target = np.column_stack([*past, grid.inputs[order - 1 :]]), y[order:]
        good = grid.fitted[order - 1 :] & np.isfinite(x).all(axis=1) & np.isfinite(target).all(axis=1)
        rows.append(x[good])
        targets.append(target[good])
    x, y = np.concatenate(rows), np.concatenate(targets)
    if len(y) < FEWEST + x.shape[1]:
        return None
    weights, constant = regressed(x, y, share)
    ahead = np.array([weights[k * n : (k + 1) * n].T for k in range(order)])
    return ahead, weights[order * n :].T, constant


def _free(grid: _Grid, start: Array, ahead: Array, driven: Array, constant: Array) -> Array:
    """Readings at the grid's times that begin at `start` and go on by themselves, NaN if they run away."""
    count, n = len(grid.time), start.size
    given = np.vstack([start, grid.inputs @ driven.T + constant])
    by_last = np.zeros(((len(ahead) + 1) * n - 1, count * n))
    for i, weights in enumerate(ahead):
        given[1 : 1 + i] += weights @ start  # as if it had been so before
        for (to, source), weight in np.ndenumerate(weights):
            by_last[(i + 1) * n + to - source - 1, source : (count - 1 - i) * n : n] = weight
    result = recursion(given.reshape(-1, 1), by_last).reshape(count, n)
    limit = 1e3 * (1.0 + np.abs(start).max())
    return result if np.all(np.abs(result[1:]) < limit) else np.full(result.shape, np.nan)
