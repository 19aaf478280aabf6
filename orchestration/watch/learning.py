"""What is learnt from the sound part: the model's values, and the sizes of what it does not say; then frozen.

The filter is run over the sound part once and again, and each time what is linear about it is kept: that
tells, within a moment, how likely the readings are with other noise, and how far each value must move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.signals import row_noise
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.watch.hypotheses import WatchedMachine
from warmlink.orchestration.watch.shadow import (
    CLIPPED,
    Innovation,
    LinearTick,
    Shadow,
    ShadowNoise,
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

_ROUNDS = 2
"""Times that each stride is tried."""

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
    rows = np.concatenate(_filtered(passed, [noise], directed=True).rows)
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


class _Filtered(NamedTuple):
    """A linear pass with other noises: twice the log-likelihood of each, and rows by which values move."""

    likelihood: Array
    rows: list[Array]


def _filtered(
    passed: Sequence[LinearTick], noises: Sequence[ShadowNoise], directed: bool = False
) -> _Filtered:
    """Go through a linear pass with several noises at once.

    Parameters
    ----------
    passed : ticks as a pass of the filter has left them
    noises : that are tried
    directed : whether rows are wanted: whitened innovations, and their directions by hypothesis, with the
        first noise
    """
    plant = passed[0].onward.shape[0] - noises[0].slow.size
    n, total = passed[0].onward.shape[0], np.zeros(len(noises))
    slow, at_start = np.arange(plant, n), np.array([each.at_start(plant) for each in noises])
    apart, P, directions, rows = np.zeros((len(noises), n)), at_start, np.zeros((n, 0)), list[Array]()
    single, steady = (np.array([getattr(e, name) for e in noises]) ** 2 for name in ("white", "steady"))
    held = dict[float, tuple[Array, Array]]()
    for tick in passed:
        if tick.anew:
            apart, P = np.zeros_like(apart), at_start
            directions = np.zeros_like(tick.pushed)
        if tick.lasting not in held:
            added = np.array([each.process(plant, tick.lasting) for each in noises])
            held[tick.lasting] = np.array([each.kept(tick.lasting) for each in noises]), added
        kept, process = held[tick.lasting]
        there = np.flatnonzero(np.isfinite(tick.error))
        H, variances = tick.seen[there], single[:, there] / tick.counts[there] + steady[:, there]
        spread = P @ H.T
        lower = np.linalg.cholesky(H @ spread + variances[:, :, None] * np.eye(there.size))
        whiten = np.linalg.inv(lower)
        white = np.einsum("kij,kj->ki", whiten, tick.error[there] - apart @ H.T)
        counted, gained = np.clip(white, -CLIPPED, CLIPPED), whiten @ spread.transpose(0, 2, 1)
        total -= 2 * np.log(np.diagonal(lower, axis1=1, axis2=2)).sum(axis=1) + (counted**2).sum(axis=1)
        onward = np.repeat(tick.onward[None], len(noises), axis=0)
        onward[:, slow, slow] = kept
        # What the pass itself left of its slow processes was kept by its own memory.
        moved = apart + np.einsum("kij,ki->kj", gained, counted) - tick.correction
        apart = np.einsum("kij,kj->ki", onward, moved)
        if directed:
            leaning = whiten[0] @ (tick.direct[there] + H @ directions)
            rows.append(np.column_stack([counted[0], leaning]))
            directions = onward[0] @ (directions - gained[0].T @ leaning) + tick.pushed
        P = onward @ (P - gained.transpose(0, 2, 1) @ gained) @ onward.transpose(0, 2, 1)
        P[:, np.arange(n), np.arange(n)] += process
    return _Filtered(total, rows)


def _likeliest(
    passed: Sequence[LinearTick],
    noise: ShadowNoise,
    memories: Sequence[float],
    strides: Sequence[float],
    machine: WatchedMachine,
) -> ShadowNoise:
    """Sizes of the noise of the largest likelihood: each alone larger and smaller, then the best of them."""
    unit = np.array([_UNIT.get(machine.rig.unit(each), 1.0) for each in machine.outputs])
    noise = _best(passed, [noise, *(replace(noise, misfit_memory=each) for each in memories)])[0]
    for stride in (each for each in strides for _ in range(_ROUNDS)):
        moves = [
            (name, i, factor)
            for name in ("misfit", "steady", "wander")
            for i in range(getattr(noise, name).size)
            for factor in (stride, 1 / stride)
        ]
        alone = [_scaled(noise, [each], unit) for each in moves]
        said = _filtered(passed, [noise, *alone]).likelihood
        gains = said[1:] - said[0]
        better = [moves[k] for k in np.argsort(-gains, kind="stable") if gains[k] > 0]
        if not better:
            continue
        noise = _best(passed, [_scaled(noise, better[: k + 1], unit) for k in range(len(better))])[0]
    return noise


def _best(passed: Sequence[LinearTick], noises: Sequence[ShadowNoise]) -> tuple[ShadowNoise, float]:
    said = _filtered(passed, noises).likelihood
    return noises[int(np.argmax(said))], float(said.max())


def _scaled(noise: ShadowNoise, moves: Sequence[tuple[str, int, float]], unit: Array) -> ShadowNoise:
    """The noise with some of its sizes multiplied; of two moves of one size the first counts."""
    sizes = {name: getattr(noise, name).copy() for name in ("misfit", "steady", "wander")}
    for name, i, factor in reversed(moves):
        sizes[name][i] = getattr(noise, name)[i] * factor
    sizes["misfit"] = np.maximum(sizes["misfit"], _LEAST * unit)
    return replace(noise, **sizes)
