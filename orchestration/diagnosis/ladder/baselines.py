"""The plainest fits that anybody would try: a first-order lag, ARX simulated freely, and ridge.

Each channel's form is chosen on the last part of the fitted rows and then fitted to all of them; held-out
rows are used by none. A ridge goes by temperatures alone: how heat comes in differs between duty cycles, what
temperatures mean does not. Regularised least squares as in A. E. Hoerl and R. W. Kennard, Technometrics 12
(1970) 55-67; ARX as in L. Ljung, System Identification, 2nd edition (1999), section 4.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.ladder.arx import arx
from warmlink.orchestration.diagnosis.ladder.least_squares import FEWEST, Fitted, Form, Linear, regressed
from warmlink.orchestration.diagnosis.ladder.signals import Signals
from warmlink.orchestration.diagnosis.model.recursions import recursion

Question = Literal["simulation", "virtual measurement"]
"""From inputs alone, or from the other thermometers."""

_RIDGES = (1e-6, 1e-3, 1e-1)
"""Share of the columns' own power that is added, for columns of unit variance."""

_TIME_CONSTANTS = 10
"""Time constants of lags that are tried, from a few rows to the whole of a run."""

_FINE = 20.0
"""Steps in a time constant of a lag, where it is used."""

_LATER = 0.7
"""Share of the fitted time of a run on which forms are fitted that are then judged on the rest."""

_CLEARLY = 0.5
"""Share of the error by channels alone, below which a ridge goes by temperatures among the inputs too.

They hardly change in most logs, so that such a log's end tells little of what they do in another.
"""


@dataclass(frozen=True)
class Baseline:
    """What a plain fit says of every run: readings in SI, shape (rows, channels) each; NaN if it has none.

    `linear` is how, by number of the channel.
    """

    name: str
    question: Question
    readings: tuple[Array, ...]
    linear: Mapping[int, Linear]


def baselines(runs: Sequence[Signals], temperatures: Sequence[bool]) -> tuple[Baseline, ...]:
    """Fit every baseline to the fitted rows.

    Parameters
    ----------
    runs : all runs, with the rows that may be fitted
    temperatures : whether each channel is a temperature, which other channels may be measured by
    """
    thermometers = np.array(temperatures, dtype=bool)
    found = []
    for name, forms in (("first-order lag", list(_lags(runs))), ("ARX", list(arx(runs)))):
        if any(run.ambient.any() for run in runs):
            forms += [_above_ambient(form, thermometers) for form in forms]
        found.append(Baseline(name, "simulation", *_best(runs, [forms])))
    if thermometers.sum() > 0 and thermometers.size > 1:
        kinds = [[_ridge(driving, share, thermometers) for share in _RIDGES] for driving in (False, True)]
        found.append(Baseline("ridge", "virtual measurement", *_best(runs, kinds)))
    return tuple(each for each in found if any(np.isfinite(table).any() for table in each.readings))


def _best(
    runs: Sequence[Signals], kinds: Sequence[Sequence[Form]]
) -> tuple[tuple[Array, ...], dict[int, Linear]]:
    """For each channel what the best form says, and how.

    Parameters
    ----------
    runs : all runs, with the rows that may be fitted
    kinds : forms of each kind; of a later kind one is taken if it is clearly better than those before
    """
    early, channels = _earlier(runs), runs[0].readings.shape[1]
    least, chosen = np.full(channels, np.inf), [kinds[0][0]] * channels
    for number, kind in enumerate(kinds):
        squares = np.array([_mean_squares(runs, early, form) for form in kind])
        best, share = np.argmin(squares, axis=0), _CLEARLY**2 if number else 1.0
        for channel, i in enumerate(best):
            if squares[i, channel] < share * least[channel]:
                least[channel], chosen[channel] = squares[i, channel], kind[i]
    told = np.isfinite(least)
    whole = {form: form(runs) for form in {form for form, one in zip(chosen, told, strict=True) if one}}
    said, linear = [np.full(run.readings.shape, np.nan) for run in runs], {}
    for channel in np.flatnonzero(told).tolist():
        fitted = whole[chosen[channel]]
        for table, readings in zip(said, fitted.readings, strict=True):
            table[:, channel] = readings[:, channel]
        if channel in fitted.linear:
            linear[channel] = fitted.linear[channel]
    return tuple(said), linear


def _mean_squares(runs: Sequence[Signals], early: Sequence[Signals], form: Form) -> Array:
    """Mean squared error of each channel in the later part of the fitted rows, by a fit to the others.

    Infinite where a reading is not told, and where there is none.
    """
    channels = runs[0].readings.shape[1]
    squares, count = np.zeros(channels), np.zeros(channels)
    for run, part, readings in zip(runs, early, form(early).readings, strict=True):
        error = (run.readings - readings)[run.fitted & ~part.fitted]
        read = np.isfinite(run.readings)[run.fitted & ~part.fitted]
        squares += np.where(read, np.where(np.isfinite(error), error, np.inf) ** 2, 0.0).sum(axis=0)
        count += read.sum(axis=0)
    return np.where(count > 0, squares / np.maximum(count, 1), np.inf)


def _earlier(runs: Sequence[Signals]) -> list[Signals]:
    """The same runs with less to fit: without the last of several fitted ones, or the end of one."""
    fitted = [i for i, run in enumerate(runs) if run.fitted.any()]
    if len(fitted) > 1:
        last = fitted[-1]
        return [replace(r, fitted=r.fitted & (i != last)) for i, r in enumerate(runs)]
    ends = [float(run.time[run.fitted][-1]) if run.fitted.any() else 0.0 for run in runs]
    return [replace(r, fitted=r.fitted & (r.time < _LATER * e)) for r, e in zip(runs, ends, strict=True)]


def _above_ambient(form: Form, thermometers: NDArray[np.bool_]) -> Form:
    """The same for temperatures above ambient, of which no temperature is a cause."""

    def risen(run: Signals) -> Signals:
        return replace(
            run,
            readings=run.readings - np.outer(run.ambient, thermometers),
            start=run.start - run.ambient[0] * thermometers,
            inputs=run.inputs[:, ~run.relative],
            names=tuple(n for n, warm in zip(run.names, run.relative, strict=True) if not warm),
            relative=np.zeros(int(np.sum(~run.relative)), dtype=bool),
        )

    def above(runs: Sequence[Signals]) -> Fitted:
        tables, linear = form([risen(run) for run in runs])
        room = (runs[0].room,)
        return Fitted(
            [table + np.outer(run.ambient, thermometers) for run, table in zip(runs, tables, strict=True)],
            {
                c: replace(
                    each,
                    above=thermometers[list(each.channels)],
                    direct={**each.direct, room: 1.0} if thermometers[c] else each.direct,
                )
                for c, each in linear.items()
            },
        )

    return above


def _lags(runs: Sequence[Signals]) -> Iterator[Form]:
    span = max(float(run.time[-1]) for run in runs)
    spacing = float(np.median(np.diff(runs[0].time)))
    for constant in np.geomspace(max(3 * spacing, 1e-3 * span), span, _TIME_CONSTANTS).tolist():
        for rich, share in product((False, True), _RIDGES):
            yield _lag(constant, rich, share)


def _lag(constant: float, rich: bool, share: float) -> Form:
    """Each channel follows a linear function of the inputs with one time constant in s."""
    step = constant / _FINE

    def form(runs: Sequence[Signals]) -> Fitted:
        left = [np.exp(-run.time / constant) for run in runs]
        columns = [
            np.column_stack([filtered(run.time, run.columns(rich), constant), 1 - decay])
            for run, decay in zip(runs, left, strict=True)
        ]
        gone = [np.outer(decay, run.start) for run, decay in zip(runs, left, strict=True)]
        driven = [replace(run, readings=run.readings - of) for run, of in zip(runs, gone, strict=True)]
        result, linear = [np.full(run.readings.shape, np.nan) for run in runs], {}
        kept = float(np.exp(-step / constant))
        for channel in range(runs[0].readings.shape[1]):
            found = _weights(columns, driven, channel, share)
            if found is None:
                continue
            weights, offset = found
            # What is fitted beside the two constants from rest is taken for a start that is a little off.
            for table, column, of in zip(result, columns, gone, strict=True):
                table[:, channel] = column @ weights + offset + of[:, channel]
            by_feature = zip(runs[0].features(rich), weights[:-1].tolist(), strict=True)
            linear[channel] = Linear(
                step,
                np.full((1, 1, 1), kept),
                {feature: np.array([(1 - kept) * each]) for feature, each in by_feature},
                np.array([(1 - kept) * float(weights[-1])]),
                (channel,),
                offset=offset,
                above=np.zeros(1, dtype=bool),
            )
        return Fitted(result, linear)

    return form


def filtered(time: Array, columns: Array, constant: float) -> Array:
    """First-order lags of signals, from rest."""
    keep = np.exp(-np.diff(time, prepend=0.0) / constant)
    return recursion((1 - keep[:, None]) * columns, np.append(keep[1:], 0.0)[None])


def _weights(
    columns: Sequence[Array], runs: Sequence[Signals], channel: int, share: float
) -> tuple[Array, float] | None:
    """Weights of columns and a constant, fitted to a channel's fitted rows; None if they are too few."""
    rows = [
        r.fitted & np.isfinite(r.readings[:, channel]) & np.isfinite(c).all(axis=1)
        for r, c in zip(runs, columns, strict=True)
    ]
    x = np.concatenate([c[row] for c, row in zip(columns, rows, strict=True)])
    y = np.concatenate([r.readings[row, channel] for r, row in zip(runs, rows, strict=True)])
    if y.size < FEWEST:
        return None
    weights, constant = regressed(x, y[:, None], share)
    return weights[:, 0], float(constant[0])


def _ridge(driving: bool, share: float, thermometers: Array) -> Form:
    """Each channel from the other thermometers now, and from temperatures among the inputs if asked for."""

    def form(runs: Sequence[Signals]) -> Fitted:
        filled = [np.column_stack([_filled(run.time, c) for c in run.readings.T]) for run in runs]
        result, linear = [np.full(run.readings.shape, np.nan) for run in runs], {}
        for channel in range(runs[0].readings.shape[1]):
            others = thermometers & (np.arange(thermometers.size) != channel)
            if not others.any():
                continue
            warm = runs[0].relative & driving
            columns = [
                np.column_stack([f[:, others], r.inputs[:, warm]]) for f, r in zip(filled, runs, strict=True)
            ]
            found = _weights(columns, runs, channel, share)
            if found is None:
                continue
            weights, offset = found
            for table, column in zip(result, columns, strict=True):
                table[:, channel] = column @ weights + offset
            read = [(name,) for name, other in zip(runs[0].channels, others, strict=True) if other]
            features = [*read, *((n,) for n, one in zip(runs[0].names, warm, strict=True) if one)]
            linear[channel] = Linear(direct=dict(zip(features, weights.tolist(), strict=True)), offset=offset)
        return Fitted(result, linear)

    return form


def _filled(time: Array, values: Array) -> Array:
    """Readings with gaps bridged; NaN where the channel was not read at all."""
    read = np.isfinite(values)
    return np.interp(time, time[read], values[read]) if read.any() else values
