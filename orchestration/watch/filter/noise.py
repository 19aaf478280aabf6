"""Noise of the filter in shadow: of readings, of what nobody logged, and of what the model is off by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.arrays import Array

_START, _SHARED = 3.0, 0.7
"""K by which the states at the start are not known, and how alike their errors are."""

_ROUGH = 1e-3
"""K of process noise of each state in a minute, so that the filter never grows sure of itself."""

_MINUTE = 60.0
"""s in a minute."""


@dataclass(frozen=True)
class ShadowNoise:
    """What was learnt from the sound part: 1 sigma in SI, and correlation times in s.

    Attributes
    ----------
    white : of one reading by itself, beside `steady`, shape (outputs,)
    steady : of a tick's mean that more readings do not make smaller, shape (outputs,)
    wander, wander_memory : of the room and of heat, shape (signals,)
    switching : s by which the moment is not known at which what drives the machine changes, shape (1,)
    misfit, misfit_memory : by which the model is off at each reading, shape (outputs,)
    stirred : by how much wander and misfit are stronger while work differs from what it was of late, by lag
        of it, in their own sizes, shape (2, lags)
    usual : size of what drives the machine, in which work differs, shape (drives,)
    """

    white: Array
    steady: Array
    wander: Array
    switching: Array
    misfit: Array
    stirred: Array
    usual: Array
    wander_memory: float = 1800.0
    misfit_memory: float = 7200.0

    def variances(self, counts: Array) -> Array:
        """Variance of the noise of means of so many readings, shape (outputs,)."""
        return self.white**2 / np.maximum(counts, 1) + self.steady**2

    @property
    def slow(self) -> Array:
        """Standard deviations of what is beside the plant's states, shape (signals + 1 + outputs,)."""
        return np.concatenate([self.wander, self.switching, self.misfit])

    @property
    def stirs(self) -> Array:
        """Factors of `stirred` for each of these, shape (signals + 1 + outputs, lags)."""
        wander, misfit = self.stirred
        each = wander, np.zeros_like(wander), misfit
        return np.repeat(each, [self.wander.size, self.switching.size, self.misfit.size], axis=0)

    def kept(self, lasting: float) -> Array:
        """What is left of each after a time in s, shape (signals + 1 + outputs,); of a switch nothing."""
        wander, misfit = np.exp(-lasting / np.array([self.wander_memory, self.misfit_memory]))
        return np.repeat([wander, 0.0, misfit], [self.wander.size, self.switching.size, self.misfit.size])

    def process(self, plant: int, lasting: float, stirred: Array) -> Array:
        """Variances that a tick adds to so many states of the plant and to the slow ones, shape (n,)."""
        slow = self.slow**2 * (1 + self.stirs**2 @ stirred) * (1 - self.kept(lasting) ** 2)
        return np.append(np.full(plant, _ROUGH**2 * lasting / _MINUTE), slow)

    def at_start(self, plant: int) -> Array:
        """Covariance of the states when hardly anything is known, shape (n, n)."""
        found = np.diag(np.append(np.zeros(plant), self.slow**2))
        found[:plant, :plant] = _START**2 * (_SHARED + (1 - _SHARED) * np.eye(plant))
        return found
