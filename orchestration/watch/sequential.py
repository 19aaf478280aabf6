"""The sequential test: sums that forget, one for each thing that may be wrong, against thresholds.

Each sum collects how far the innovations lean one way, over some ten ticks and up to a day of them: a score
test with windows that fade (M. Basseville and I. V. Nikiforov, Detection of Abrupt Changes, Prentice-Hall
1993). Its thresholds come from the sound part alone: blocks of it, and single ticks, are drawn anew into
many made-up days, so many, within bounds, as show the rate that is aimed at, a small share of the stated
one. What a short sound part does not tell counts against an alarm: every made-up machine has weights of the
blocks and a size of the noise of its own (D. B. Rubin, "The Bayesian bootstrap", Annals of Statistics 9,
1981).

A sum that passes its threshold is set back to it, so that how loud a fault was does not make its alarm last
(as the upper boundary of A. Gandy and F. D.-H. Lau, "Non-restarting cumulative sum charts and control of the
false discovery rate", Biometrika 100, 2013). Below the thresholds this changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array

MEMORIES = (10, 60, 360, 1440)
"""Ticks over which a sum forgets."""

SETTLED = 30
"""Ticks of a start, or after a gap, that are not judged: the filter does not know its states yet."""

FEWEST = 120
"""Ticks of a sound part below which nothing can be learnt."""

_SOUND_FOR_MEMORY = 3
"""Times a memory that the sound part has to last for it."""

_BLOCK = (20, 120)
"""Ticks in a block of the sound part, at least and at most."""

_BLOCKS, _FEW = 32, 16
"""Blocks that a sound part is cut into if they get long enough, and so few that it is said."""

_MACHINES, _TICKS = 192, (864_000, 6_480_000)
"""Made-up machines, and ticks that are made up, at least and at most, of all of them together."""

_SEEN, _FEWEST_SEEN = 20, 5
"""Alarms that are seen at the rate aimed at in the made-up days, and so few that it is extrapolated."""

_AIMED = 0.035
"""Share of the stated rate that is aimed at: of ten machines that are watched as long as the rate says for
one false alarm, at most one has one, in 19 of 20 cases."""

APART = 60
"""Quiet ticks after which an alarm is over, so that the next one counts as another."""

_LEAST_WEIGHT, _LEAST_SIZE = 1e-12, 1e-3


class Sums:
    """Sums of leaning that forget, of one run or of many at once.

    Parameters
    ----------
    memories : in ticks, shape (memories,)
    shape : of a tick's leaning, (..., things)
    """

    def __init__(self, memories: Sequence[int], shape: tuple[int, ...]) -> None:
        self._kept = np.exp(-1.0 / np.array(memories, dtype=float))[:, None]
        self.lean = np.zeros((*shape[:-1], len(memories), shape[-1]))
        self.weight = np.full_like(self.lean, _LEAST_WEIGHT)

    def add(self, lean: Array, weight: Array) -> Array:
        """Take a tick; give each sum in standard deviations of white innovations, (..., memories, things)."""
        self.lean *= self._kept
        self.lean += lean[..., None, :]
        self.weight *= self._kept**2
        self.weight += weight[..., None, :]
        return np.asarray(self.lean / np.sqrt(self.weight))


@dataclass(frozen=True)
class Limits:
    """Thresholds that were worked out.

    Attributes
    ----------
    memories : in ticks, of the sums that are judged
    sizes : that each sum by itself passes at the rate aimed at, shape (memories, things)
    threshold : multiple of them from which there is an alarm
    rate : of false alarms for which it was worked out, in 1/day
    blocks : of the sound part
    days : that were made up
    extrapolated : whether the rate is too small to have been seen in them
    """

    memories: tuple[int, ...]
    sizes: Array
    threshold: float
    rate: float
    blocks: int
    days: float
    extrapolated: bool

    def told(self) -> str:
        """What the thresholds rest on, in a sentence."""
        seen = "by the tail of the largest sums" if self.extrapolated else "as they were seen"
        short = ""
        if self.blocks < _FEW:
            short = f"; the sound part has only {self.blocks} blocks, so that alarms wait for more evidence"
        every = 1 / self.rate
        days = f"{self.days:.0f} made-up days{short}"
        return f"thresholds for one false alarm in {every:.3g} days, {seen} in {days}"


def worked_out(lean: Array, weight: Array, rate: float, day: float, seed: int = 1) -> Limits:
    """Thresholds for a rate of false alarms.

    Parameters
    ----------
    lean, weight : of each tick of the sound part, settled, shape (ticks, things)
    rate : of false alarms in 1/day, of all things and memories together
    day : ticks of a day
    seed : of the made-up days
    """
    ticks = len(lean)
    memories = tuple(m for m in MEMORIES if m * _SOUND_FOR_MEMORY <= ticks) or MEMORIES[:1]
    length = int(np.clip(ticks // _BLOCKS, *_BLOCK))
    blocks = max(ticks // length, 2)
    draw = np.random.default_rng(seed)
    aimed = _AIMED * rate / day
    per_machine = int(np.ceil(float(np.clip(_SEEN / aimed, *_TICKS)) / _MACHINES))
    # What makes a block louder than another, as a work that is seldom done, comes but once a block.
    factor = np.sqrt((blocks - 1) / draw.chisquare(blocks - 1, _MACHINES))[:, None]
    begin = 3 * memories[-1]  # until the sums have forgotten that they began at nothing
    per_machine += begin
    # Blocks keep how alike neighbours are; but a sum over less than a block takes no value that was not seen.
    # Single ticks do not, and their sums take all others.
    both = [
        _peaks(memories, lean, weight, _drawn(draw, ticks, each, blocks, per_machine), factor, begin)
        for each in (length, 1)
    ]
    made_up = len(both[0]) * APART
    expected = aimed * made_up
    rank = min(max(int(expected), _FEWEST_SEEN), min(map(len, both))) - 1
    sizes = np.maximum(np.max([-np.sort(-each, axis=0)[rank] for each in both], axis=0), _LEAST_SIZE)
    threshold = max(_level(np.max(each / sizes, axis=(1, 2)), expected) for each in both)
    return Limits(memories, sizes, threshold, rate, blocks, made_up / day, expected < _FEWEST_SEEN)


def _peaks(
    memories: Sequence[int], lean: Array, weight: Array, rows: NDArray[np.int64], factor: Array, begin: int
) -> Array:
    """Largest size of each sum in stretches of `APART` ticks, each of which is one alarm at most.

    Of shape (stretches, memories, things); the first ticks, in which sums begin, are left out.
    """
    sums, found = Sums(memories, (rows.shape[1], lean.shape[1])), list[Array]()
    for k, row in enumerate(rows):
        now = np.abs(sums.add(factor * lean[row], weight[row]))
        if k < begin:
            continue
        if (k - begin) % APART == 0:
            found.append(now)
        else:
            np.maximum(found[-1], now, out=found[-1])
    return np.concatenate(found)


def _level(peaks: Array, wanted: float) -> float:
    """Level that so many peaks pass, by a standard deviation of their number on the safe side."""
    order = np.sort(peaks)[::-1]
    if wanted < _FEWEST_SEEN:
        return _beyond(order, wanted)
    return float(order[int(np.clip(wanted - np.sqrt(wanted), 1, order.size)) - 1])


def _drawn(draw: np.random.Generator, ticks: int, length: int, blocks: int, steps: int) -> NDArray[np.int64]:
    """Rows of the sound part for each made-up machine, shape (steps, machines): blocks after one another."""
    share = draw.dirichlet(np.ones(blocks), _MACHINES)
    count = -(-steps // length)
    which = np.array([draw.choice(blocks, count, p=each) for each in share])
    begin = which * (ticks / blocks) + draw.uniform(0, ticks / blocks, which.shape)
    rows = (begin.astype(np.int64)[:, :, None] + np.arange(length)) % ticks
    return np.ascontiguousarray(rows.reshape(_MACHINES, -1)[:, :steps].T)


def _beyond(order: Array, wanted: float) -> float:
    """Level that is passed less often than was seen: peaks grow rarer with the square of their height."""
    low, high = order[min(60, order.size - 1)], order[min(10, order.size - 1)]
    fall = np.log(60 / 10) / max(high**2 - low**2, 1e-9)
    return float(np.sqrt(high**2 + np.log(10 / max(wanted, 1e-12)) / fall))


@dataclass
class Sequential:
    """The test at work.

    Parameters
    ----------
    limits : as worked out
    things : that may be wrong, whose number `limits.sizes` has
    """

    limits: Limits
    things: int
    settled: int = 0
    level: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        self.sums = Sums(self.limits.memories, (self.things,))
        self.level = np.zeros(self.things)

    def begin(self) -> None:
        """Wait until the filter has settled again, as after a gap; sums go on from where they were."""
        self.settled = 0
        self.level = np.zeros(self.things)

    def add(self, lean: Array, weight: Array) -> Array:
        """Take a tick; give each thing's largest sum as a share of its threshold, shape (things,).

        Sums above their thresholds are set back to them afterwards.
        """
        self.settled += 1
        if self.settled > SETTLED:
            now = np.abs(self.sums.add(lean, weight)) / self.limits.sizes / self.limits.threshold
            self.level = now.max(axis=0)
            self.sums.lean /= np.maximum(now, 1.0)
        return self.level
