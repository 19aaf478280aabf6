"""What is learnt from the sound part: the model's values, and the sizes of what it does not say; then frozen.

The filter is run over the sound part once and again, and each time what is linear about it is kept: that
tells, within a moment, how likely the readings are with other noise, and how far each value must move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import row_noise
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.watch.hypotheses import WatchedMachine
from warmlink.orchestration.watch.shadow import (
    CLIPPED,
    Corrected,
    Innovation,
    LinearTick,
    Shadow,
    ShadowNoise,
    corrected,
)
from warmlink.orchestration.watch.ticks import Tick

_STRIDES = ((), (4.0,), (2.0, 1.5))
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
    moved : by which each hypothesis' value was calibrated, shape (hypotheses,)
    lean, weight : of each tick of the sound part, shape (ticks, hypotheses)
    surprise : sum of squares of each tick's innovations less their number, in standard deviations, shape
        (ticks,)
    """

    noise: ShadowNoise
    values: Array
    offsets: Array
    moved: Array
    lean: Array
    weight: Array
    surprise: Array


def learn(machine: WatchedMachine, ticks: Sequence[Tick], progress: Progress = unseen) -> SoundPart:
    """Learn from the ticks of the sound part.

    Parameters
    ----------
    machine : what is watched
    ticks : of the sound part, in order
    progress : told of each pass
    """
    noise, moved = _first(machine, ticks), np.zeros(len(machine.hypotheses))
    memories = [each for each in _MEMORIES if 4 * each <= ticks[-1].end - ticks[0].start] or _MEMORIES[:1]
    for k, strides in enumerate(_STRIDES):
        progress("calibrating on the sound part", k / (len(_STRIDES) + 1))
        passed = _pass(machine, noise, moved, ticks)[1]
        if strides:
            noise = _likeliest(passed[:_MOST_TICKS], noise, memories, strides, machine)
        moved = moved + _calibration(machine, passed, noise, moved)
    progress("judging the sound part", len(_STRIDES) / (len(_STRIDES) + 1))
    said, _ = _pass(machine, noise, moved, ticks)
    values, offsets = applied(machine, moved)
    lean, weight = (np.array([getattr(each, name) for each in said]) for name in ("lean", "weight"))
    surprise = np.array([surprise_of(each.white) for each in said])
    return SoundPart(noise, values, offsets, moved, lean, weight, surprise)


def surprise_of(white: Array) -> float:
    """Sum of squares of whitened innovations less their number, in its standard deviations."""
    squares = np.minimum(white[np.isfinite(white)] ** 2, CLIPPED**2)
    return float((squares.sum() - squares.size) / np.sqrt(2 * max(squares.size, 1)))


def applied(machine: WatchedMachine, moved: Array) -> tuple[Array, Array]:
    """Values of the slots and offsets of the readings, with hypotheses' values moved."""
    reading = np.array([each.reading for each in machine.hypotheses]).T
    return machine.slots + machine.groups @ moved, reading @ moved


def _pass(
    machine: WatchedMachine, noise: ShadowNoise, moved: Array, ticks: Sequence[Tick]
) -> tuple[list[Innovation], list[LinearTick]]:
    shadow = Shadow(machine, noise, *applied(machine, moved))
    both = [shadow.step(tick) for tick in ticks]
    return [said for said, _ in both], [linear for _, linear in both]


def _first(machine: WatchedMachine, ticks: Sequence[Tick]) -> ShadowNoise:
    """Noise to begin with: that of single readings by their scatter, and the rest guessed."""
    unit = np.array([_UNIT.get(machine.rig.unit(each), 1.0) for each in machine.outputs])
    scatter = np.array([each.scatter for each in ticks])
    with np.errstate(all="ignore"):
        white = np.array([np.nanmedian(s) if np.isfinite(s).any() else 0.0 for s in scatter.T])
    middles, means = np.array([each.end for each in ticks]), np.array([each.readings for each in ticks])
    rough = np.array([row_noise(middles, column) for column in means.T])
    steady = np.maximum(rough, _LEAST * unit) / 2
    signals = np.array([_SIGNALS[each] for each in machine.signals])
    return ShadowNoise(white, steady, signals, _FIRST * unit)


def _calibration(
    machine: WatchedMachine, passed: Sequence[LinearTick], noise: ShadowNoise, moved: Array
) -> Array:
    """By how much the value of each hypothesis of a usual calibration moves, within its bounds."""
    from scipy.optimize import lsq_linear

    free = np.array([each.cause.usual or each.reading.any() for each in machine.hypotheses])
    rows = np.concatenate([said.rows for said in _filtered(passed, noise, free)[1]])
    rows = rows[:, np.append(True, free)]
    found = np.zeros(moved.size)
    hypotheses = [h for h, f in zip(machine.hypotheses, free, strict=True) if f]
    span = np.array([each.span for each in hypotheses])
    room = np.array([(each.upper - each.lower) * _INSIDE for each in hypotheses])
    lower = np.array([each.lower - each.start for each in hypotheses]) - moved[free]
    upper = np.array([each.upper - each.start for each in hypotheses]) - moved[free]
    prior = np.column_stack([-moved[free] / span, np.eye(span.size)])  # in spans
    table = np.vstack([np.column_stack([rows[:, 0], rows[:, 1:] * span]), prior])
    at_zero = np.array([each.lower >= each.start for each in hypotheses])  # a term that begins at its bound
    low = np.where(at_zero, lower, lower + room) / span
    high = (upper - room) / span
    low, high = np.minimum(low, -1e-9), np.maximum(high, 1e-9)
    q, r = np.linalg.qr(table[:, 1:])
    found[free] = span * lsq_linear(r, q.T @ table[:, 0], (low, high)).x
    return found


def _filtered(
    passed: Sequence[LinearTick], noise: ShadowNoise, free: Array | None = None
) -> tuple[float, list[Corrected]]:
    """Twice the log-likelihood of a linear pass with other noise, and what each tick says."""
    plant = passed[0].onward.shape[0] - noise.slow.size
    columns = slice(0, 0) if free is None else slice(None)
    n, total = passed[0].onward.shape[0], 0.0
    said = list[Corrected]()
    apart, P, directions = np.zeros(n), np.zeros((n, n)), np.zeros((n, 0))
    for tick in passed:
        if tick.anew:
            apart, P = np.zeros(n), noise.at_start(plant)
            directions = np.zeros_like(tick.pushed[:, columns])
        leaning = tick.direct[:, columns] + tick.seen @ directions
        error = tick.error - tick.seen @ apart
        found, correction, gain = corrected(error, tick.seen, P, noise.variances(tick.counts), leaning)
        onward = tick.onward.copy()
        slow = np.arange(plant, n)
        onward[slow, slow] = noise.kept(tick.lasting)
        # What the pass itself left of its slow processes was kept by its own memory.
        apart = onward @ (apart + correction - tick.correction)
        directions = onward @ (directions - gain @ found.leaning) + tick.pushed[:, columns]
        P = onward @ found.covariance @ onward.T + np.diag(noise.process(plant, tick.lasting))
        total += found.likelihood
        said.append(found)
    return total, said


def _likeliest(
    passed: Sequence[LinearTick],
    noise: ShadowNoise,
    memories: Sequence[float],
    strides: Sequence[float],
    machine: WatchedMachine,
) -> ShadowNoise:
    """Sizes of the noise of the largest likelihood, each tried larger and smaller in turn."""
    unit = np.array([_UNIT.get(machine.rig.unit(each), 1.0) for each in machine.outputs])
    best = _filtered(passed, noise)[0]
    for memory in memories:
        tried = replace(noise, misfit_memory=memory)
        if (log := _filtered(passed, tried)[0]) > best:
            best, noise = log, tried
    for stride in strides:
        for name in ("misfit", "steady", "wander"):
            for i in range(getattr(noise, name).size):
                for factor in (stride, 1 / stride):
                    sizes = getattr(noise, name).copy()
                    sizes[i] *= factor
                    if name == "misfit":
                        sizes[i] = max(sizes[i], _LEAST * unit[i])
                    tried = replace(noise, **{name: sizes})
                    if (log := _filtered(passed, tried)[0]) > best:
                        best, noise = log, tried
                        break
    return noise
