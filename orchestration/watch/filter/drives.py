"""What drives a machine, and slow lags of it: by these the model's own misfit is foreseen.

A model of other structure than the machine is off by something that its work repeats. In the sound part that
is learnt as a weighted sum of first-order lags of the logged inputs, their squares and their products. What
is left of it is largest where work differs from these lags.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.watch.ticks import Tick

LAGS = (1.0, 3.0, 10.0, 60.0, 240.0)
"""Time constants in ticks."""

_NONE = 1e-9
"""Usual size below which there is none."""

_MOST_STIRRED = 100.0
"""Square beyond which work is unlike any that was seen, whatever else it is."""


class Drives:
    """Lags of what drives a machine.

    Parameters
    ----------
    rig : the machine
    inputs : that are logged
    tick : s of the log in one tick
    """

    def __init__(self, rig: Rig, inputs: Sequence[str], tick: float) -> None:
        warm = [rig.unit(name) == "K" for name in inputs]
        at = [rig.externals.index(name) for name in inputs]
        self._room = [i for i, is_warm in zip(at, warm, strict=True) if is_warm]
        self._drives = [i for i, is_warm in zip(at, warm, strict=True) if not is_warm]
        self._usual = np.array([float(rig.variables[rig.externals[i]].start or 0.0) for i in self._room])
        self._pairs = list(combinations(range(len(self._drives)), 2))
        self._features = 2 * len(self._drives) + len(self._pairs) + len(self._room)
        self._work = self._features - len(self._room)
        self._constants = tick * np.repeat(LAGS, self._features)

    @property
    def size(self) -> int:
        """Number of lags."""
        return int(self._constants.size)

    def begin(self, tick: Tick) -> Array:
        """Lags at a start: the machine has stood for long, in the room that there is; shape (size,)."""
        now = self._of(tick)
        now[: self._work] = 0.0
        return np.tile(now, len(LAGS))

    def onward(self, lags: Array, tick: Tick) -> Array:
        """Lags at the end of a tick, shape (size,)."""
        gone = 1 - np.exp(-(tick.end - tick.start) / self._constants)
        return np.asarray(lags + gone * (np.tile(self._of(tick), len(LAGS)) - lags))

    def usual(self, ticks: Sequence[Tick]) -> Array:
        """Usual size of each drive, of its square and of the products, over some ticks, shape (drives,)."""
        return np.sqrt(np.mean([self._of(each)[: self._work] ** 2 for each in ticks], axis=0))

    def stirred(self, lags: Array, tick: Tick, usual: Array) -> Array:
        """How far work is from what it was of late, in usual sizes: a mean square by lag, shape (LAGS,)."""
        before = lags.reshape(len(LAGS), -1)[:, : self._work]
        away = (self._of(tick)[: self._work] - before) / np.maximum(usual, _NONE)
        return np.minimum(np.sum(away**2, axis=1) / max(self._work, 1), _MOST_STIRRED)

    def _of(self, tick: Tick) -> Array:
        """What drove the machine in a tick, on average: sizes, squares, products, and how warm it was."""
        levels = np.nan_to_num(tick.levels)
        sizes = np.abs(levels[:, self._drives])
        products = [sizes[:, i] * sizes[:, j] for i, j in self._pairs]
        room = levels[:, self._room] - self._usual
        return np.asarray(tick.shares @ np.column_stack([sizes, sizes**2, *products, room]))
