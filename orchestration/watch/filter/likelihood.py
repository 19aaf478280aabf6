"""How likely the readings of a linear pass are with other noise, and the likeliest sizes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.filter.shadow import CLIPPED, LinearTick

SIZES = ("misfit", "steady", "wander", "switching", "stirred")
"""What is tried larger and smaller."""

_ROUNDS = 2
"""Times that each stride is tried."""


class Filtered(NamedTuple):
    """A linear pass with other noises: twice the log-likelihood of each, and rows by which values move."""

    likelihood: Array
    rows: list[Array]


def filtered(
    passed: Sequence[LinearTick], noises: Sequence[ShadowNoise], driven: Array | None = None
) -> Filtered:
    """Go through a linear pass with several noises at once.

    Parameters
    ----------
    passed : ticks as a pass of the filter has left them
    noises : that are tried
    driven : scaled lags of each tick, shape (ticks, lags), if rows are wanted: whitened innovations, and
        their directions by hypothesis and by each output's weights of the lags, with the first noise
    """
    plant = passed[0].onward.shape[0] - noises[0].slow.size
    n, total = passed[0].onward.shape[0], np.zeros(len(noises))
    slow, at_start = np.arange(plant, n), np.array([each.at_start(plant) for each in noises])
    apart, P, directions, rows = np.zeros((len(noises), n)), at_start, np.zeros((n, 0)), list[Array]()
    single, steady = (np.array([getattr(e, name) for e in noises]) ** 2 for name in ("white", "steady"))
    held = dict[float, tuple[Array, Array]]()
    stirs = np.array([each.stirs**2 for each in noises])
    count = 0 if driven is None else driven.shape[1] * passed[0].error.size
    for k, tick in enumerate(passed):
        if tick.anew:
            apart, P = np.zeros_like(apart), at_start
            directions = np.zeros((n, tick.pushed.shape[1] + count))
        if tick.lasting not in held:
            still = np.zeros(stirs.shape[-1])
            added = np.array([each.process(plant, tick.lasting, still) for each in noises])
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
        if driven is not None:
            direct = np.column_stack([tick.direct, np.kron(np.eye(tick.error.size), driven[k])])
            leaning = whiten[0] @ (direct[there] + H @ directions)
            rows.append(np.column_stack([counted[0], leaning]))
            directions = onward[0] @ (directions - gained[0].T @ leaning)
            directions[:, : tick.pushed.shape[1]] += tick.pushed
        P = onward @ (P - gained.transpose(0, 2, 1) @ gained) @ onward.transpose(0, 2, 1)
        P[:, np.arange(n), np.arange(n)] += process
        P[:, slow, slow] += process[:, slow] * (stirs @ tick.stirred)
    return Filtered(total, rows)


def likeliest(
    passed: Sequence[LinearTick],
    noise: ShadowNoise,
    memories: Sequence[float],
    strides: Sequence[float],
    least: Array,
    names: Sequence[str] = SIZES,
) -> ShadowNoise:
    """Sizes of the noise of the largest likelihood: each alone larger and smaller, then the best of them.

    Parameters
    ----------
    passed : ticks as a pass of the filter has left them
    noise : to begin with
    memories : correlation times in s of the model's own misfit that are tried
    strides : factors by which each size is tried larger and smaller
    least : sizes in SI below which no misfit is believed, shape (outputs,)
    names : of the sizes that are tried
    """
    if memories:
        noise = _best(passed, [noise, *(replace(noise, misfit_memory=each) for each in memories)])[0]
    for stride in (each for each in strides for _ in range(_ROUNDS)):
        moves = [
            (name, i, factor)
            for name in names
            for i in range(getattr(noise, name).size)
            for factor in (stride, 1 / stride)
        ]
        alone = [_scaled(noise, [each], least) for each in moves]
        said = filtered(passed, [noise, *alone]).likelihood
        gains = said[1:] - said[0]
        better = [moves[k] for k in np.argsort(-gains, kind="stable") if gains[k] > 0]
        if not better:
            continue
        noise = _best(passed, [_scaled(noise, better[: k + 1], least) for k in range(len(better))])[0]
    return noise


def _best(passed: Sequence[LinearTick], noises: Sequence[ShadowNoise]) -> tuple[ShadowNoise, float]:
    said = filtered(passed, noises).likelihood
    return noises[int(np.argmax(said))], float(said.max())


def _scaled(noise: ShadowNoise, moves: Sequence[tuple[str, int, float]], least: Array) -> ShadowNoise:
    """The noise with some of its sizes multiplied; of two moves of one size the first counts."""
    sizes = {name: getattr(noise, name).copy() for name in SIZES}
    for name, i, factor in reversed(moves):
        sizes[name].flat[i] = getattr(noise, name).flat[i] * factor
    sizes["misfit"] = np.maximum(sizes["misfit"], least)
    return replace(noise, **sizes)
