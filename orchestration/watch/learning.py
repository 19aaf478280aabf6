"""What is learnt from the sound part: the model's values, and the sizes of what it does not say; then frozen.

The filter is run over the sound part once and again, and each time what is linear about it is kept: that
tells, within a moment, how likely the readings are with other noise, and how far each value must move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import row_noise
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.watch.combining import Scatter, leanings, scatter_of
from warmlink.orchestration.watch.filter.drives import LAGS, Drives
from warmlink.orchestration.watch.filter.likelihood import filtered, likeliest
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.filter.shadow import CLIPPED, LinearTick, Shadow
from warmlink.orchestration.watch.hypotheses import Hypothesis, WatchedMachine
from warmlink.orchestration.watch.ticks import Tick

_STRIDES = ((), (4.0,), (2.0, 1.5), (), ())
"""Factors by which each size of the noise is tried larger and smaller, in each pass of the filter."""

_MOST_TICKS = 1440
"""Ticks by which the noise is learnt: a day; values are calibrated on all."""

_MEMORIES = (1800.0, 7200.0, 28800.0)
"""Correlation times in s of the model's own misfit, of which the likeliest is taken."""

_UNIT = {"K": 1.0, "m": 1e-5}
"""What counts as much as 1 K, by unit."""

_LEAST, _FIRST = 0.01, 0.3
"""K below which no misfit is believed, and from which the search starts."""

_SIGNALS = {"room": 0.1, "heat": 1.0}
"""Sizes in K and W from which the search starts."""

_SWITCHING = 0.05
"""Share of a tick by which moments of switching are not known, from which the search starts."""

_STIRRED = 0.5
"""Share by which wander and misfit are stronger in unusual work, from which the search starts."""

_WEIGHT = 0.3
"""K by which the usual size of a lag may be off by, 1 sigma before anything is seen."""

_STILL = 1e-9
"""Usual size of a lag below which it says nothing."""

_PARTS = 8
"""Stretches of the sound part, each of which is judged with what the others taught."""

_INSIDE = 0.02
"""Share of the room between bounds that a calibrated value keeps from them."""


@dataclass(frozen=True)
class SoundPart:
    """What was learnt and is frozen.

    Attributes
    ----------
    noise : its sizes
    values : of the slots, shape (slots,)
    offsets : of the readings, shape (outputs,)
    weights : by which lags of what drives the machine add to the readings, shape (outputs, lags)
    moved : by which each hypothesis' value was calibrated, shape (hypotheses,)
    scatter : how leanings of all hypotheses scatter together
    lean, weight : of each tick of the sound part, shape (ticks, things)
    surprise : sum of squares of each tick's innovations less their number, in standard deviations, shape
        (ticks,)
    """

    noise: ShadowNoise
    values: Array
    offsets: Array
    weights: Array
    moved: Array
    scatter: Scatter
    lean: Array
    weight: Array
    surprise: Array


@dataclass(frozen=True)
class _Calibration:
    """How far values and weights are from those of the model: `moved` and `weights` as in `SoundPart`."""

    moved: Array
    weights: Array


def learn(machine: WatchedMachine, ticks: Sequence[Tick], progress: Progress = unseen) -> SoundPart:
    """Learn from the ticks of the sound part.

    Parameters
    ----------
    machine : what is watched
    ticks : of the sound part, in order
    progress : told of each pass
    """
    lags = Drives(machine.rig, machine.inputs, machine.tick).size
    noise, known = (
        _first(machine, ticks),
        _Calibration(np.zeros(len(machine.hypotheses)), np.zeros((len(machine.outputs), lags))),
    )
    unit = _units(machine)
    memories = [each for each in _MEMORIES if 4 * each <= ticks[-1].end - ticks[0].start] or _MEMORIES[:1]
    for k, strides in enumerate(_STRIDES):
        progress("calibrating on the sound part", k / (len(_STRIDES) + 1))
        passed = _pass(machine, noise, known, ticks)
        if strides:
            noise = likeliest(passed[:_MOST_TICKS], noise, memories, strides, _LEAST * unit)
            # A day holds too few beginnings to tell how much the model errs there.
            noise = likeliest(passed, noise, (), strides[-1:], _LEAST * unit, ("switching", "stirred"))
        known = _Fit(machine, noise, known, passed).best()
    progress("judging the sound part", len(_STRIDES) / (len(_STRIDES) + 1))
    fit = _Fit(machine, noise, known, _pass(machine, noise, known, ticks))
    values, offsets = applied(machine, known.moved)
    rows, watched = fit.held_out(), machine.watched
    parts = np.array_split(np.arange(len(rows)), _PARTS)
    judged = [_judged(rows, part, watched) for part in parts]
    lean, weight = (np.array(each) for each in zip(*(pair for part in judged for pair in part), strict=True))
    surprise = np.array([surprise_of(each[:, 0]) for each in rows])
    calibrated = noise, values, offsets, known.weights, known.moved
    return SoundPart(*calibrated, scatter_of(rows), lean, weight, surprise)


def _judged(
    rows: Sequence[Array], part: NDArray[np.intp], watched: NDArray[np.bool_]
) -> list[tuple[Array, Array]]:
    """Leanings of a stretch of the sound part, combined as the other stretches say."""
    combined = scatter_of([*rows[: part[0]], *rows[part[-1] + 1 :]]).combined(watched)
    return [leanings(rows[i], combined) for i in part]


def _units(machine: WatchedMachine) -> Array:
    """What counts as much as 1 K of each reading, in SI, shape (outputs,)."""
    return np.array([_UNIT.get(machine.rig.unit(each), 1.0) for each in machine.outputs])


def surprise_of(white: Array) -> float:
    """Sum of squares of whitened innovations less their number, in its standard deviations."""
    squares = np.minimum(white[np.isfinite(white)] ** 2, CLIPPED**2)
    return float((squares.sum() - squares.size) / np.sqrt(2 * max(squares.size, 1)))


def applied(machine: WatchedMachine, moved: Array) -> tuple[Array, Array]:
    """Values of the slots and offsets of the readings, with hypotheses' values moved."""
    reading = np.array([each.reading for each in machine.hypotheses]).T
    return machine.slots + machine.groups @ moved, reading @ moved


def _pass(
    machine: WatchedMachine, noise: ShadowNoise, known: _Calibration, ticks: Sequence[Tick]
) -> list[LinearTick]:
    shadow = Shadow(machine, noise, *applied(machine, known.moved), known.weights)
    return [shadow.step(tick)[1] for tick in ticks]


def _first(machine: WatchedMachine, ticks: Sequence[Tick]) -> ShadowNoise:
    """Noise to begin with: that of single readings by their scatter, and the rest guessed."""
    unit = _units(machine)
    scatter = np.array([each.scatter for each in ticks])
    with np.errstate(all="ignore"):
        white = np.array([np.nanmedian(s) if np.isfinite(s).any() else 0.0 for s in scatter.T])
    middles, means = np.array([each.end for each in ticks]), np.array([each.readings for each in ticks])
    rough = np.array([row_noise(middles, column) for column in means.T])
    steady = np.maximum(rough, _LEAST * unit) / 2
    signals = np.array([_SIGNALS[each] for each in machine.signals])
    usual = Drives(machine.rig, machine.inputs, machine.tick).usual(ticks)
    switching, stirred = np.array([_SWITCHING * machine.tick]), np.full((2, len(LAGS)), _STIRRED)
    return ShadowNoise(white, steady, signals, switching, _FIRST * unit, stirred, usual)


class _Fit:
    """Values, offsets and weights that fit a linear pass through the sound part best.

    Parameters
    ----------
    machine : what is watched
    noise : its sizes
    known : what the pass was made with
    passed : the pass
    """

    def __init__(
        self, machine: WatchedMachine, noise: ShadowNoise, known: _Calibration, passed: Sequence[LinearTick]
    ) -> None:
        self._known, hypotheses = known, machine.hypotheses
        driven = np.array([each.driven for each in passed])
        scale, first = np.sqrt(np.mean(driven**2, axis=0)), np.unique(driven, axis=1, return_index=True)[1]
        self._used = np.array([i for i in sorted(first.tolist()) if scale[i] > _STILL], dtype=np.intp)
        self._scale = scale[self._used]
        scaled = driven[:, self._used] / self._scale
        self._rows = filtered(passed, [noise], scaled).rows
        self._count = len(hypotheses)
        free = np.array([each.cause.usual or each.reading.any() for each in hypotheses])
        weights = np.repeat(_WEIGHT * _units(machine), self._used.size)
        self._free = np.append(free, np.ones(weights.size, dtype=bool))
        self._span = np.append([h.span for h, f in zip(hypotheses, free, strict=True) if f], weights)
        scaled_weights = (known.weights[:, self._used] * self._scale).ravel()
        self._now = np.append(known.moved[free], scaled_weights)
        self._bounds = _bounds([h for h, f in zip(hypotheses, free, strict=True) if f], known.moved[free])

        self._parts = np.array_split(np.arange(len(self._rows)), _PARTS)
        whitened = [np.concatenate([self._rows[i] for i in part]) for part in self._parts]
        tables = [each[:, 1:][:, self._free] * self._span for each in whitened]
        self._squares = [each.T @ each for each in tables]
        self._sides = [t.T @ w[:, 0] for t, w in zip(tables, whitened, strict=True)]

    def best(self) -> _Calibration:
        """Best values within their bounds."""
        found = self._found()
        moved, weights = self._known.moved.copy(), self._known.weights.copy()
        values = self._free[: self._count]
        moved[values] += found[: values.sum()]
        weights[:, self._used] += found[values.sum() :].reshape(len(weights), -1) / self._scale
        return _Calibration(moved, weights)

    def _found(self, without: int | None = None) -> Array:
        """By how much values and weights move that fit best within their bounds, without one of the parts."""
        from scipy.optimize import lsq_linear

        used = [k for k in range(len(self._parts)) if k != without]
        square = sum(self._squares[k] for k in used) + np.eye(self._span.size)
        side = sum(self._sides[k] for k in used) - self._now / self._span
        lower, upper = (
            np.append(each, np.full(self._span.size - each.size, sign * np.inf)) / self._span
            for each, sign in zip(self._bounds, (-1, 1), strict=True)
        )
        root = np.linalg.cholesky(square)
        return np.asarray(self._span * lsq_linear(root.T, np.linalg.solve(root, side), (lower, upper)).x)

    def held_out(self) -> list[Array]:
        """Whitened innovations of each tick, as if it had not been learnt from, before their directions.

        What is learnt from rows fits them better than those to come; so each stretch of the sound part is
        judged with values that differ from those of the pass by as much as it has moved them itself. Each
        array has the shape (readings, 1 + hypotheses).
        """
        held, whole = list[Array](), self._found()
        for k, part in enumerate(self._parts):
            found = self._found(k) - whole
            for rows in (self._rows[i] for i in part):
                white = np.clip(rows[:, 0] - rows[:, 1:][:, self._free] @ found, -CLIPPED, CLIPPED)
                held.append(np.column_stack([white, rows[:, 1 : 1 + self._count]]))
        return held


def _bounds(hypotheses: Sequence[Hypothesis], moved: Array) -> tuple[Array, Array]:
    """By how much values may still move down and up, with a share of the room kept."""
    lower, upper = (np.array([getattr(each, name) for each in hypotheses]) for name in ("lower", "upper"))
    start, room = np.array([each.start for each in hypotheses]), (upper - lower) * _INSIDE
    low = lower - start - moved + np.where(lower >= start, 0.0, room)  # 0: a term that begins at its bound
    return np.minimum(low, -1e-9), np.maximum(upper - start - moved - room, 1e-9)
