"""A linear model of any machine, found from runs of it.

The outputs (rises of the thermometers, growth) are weighted sums of first-order lags of what drives the
machine, the features of `controllers/linear_observer/model.py`: a model that is linear in its weights and
always stable, whatever is inside. Heat goes with |speed| and torque^2, so that derivatives at one point say
nothing of it: at rest that by speed is 0. A ridge keeps the weights from fitting what is not linear, and is
the one that predicts another run best. The many lags are then reduced by balanced truncation to the few modes
that both the features move and the outputs show.

P. S. C. Heuberger, P. M. J. Van den Hof and B. Wahlberg, Modelling and Identification with Rational
Orthogonal Basis Functions, Springer 2005. B. C. Moore, "Principal component analysis in linear systems", IEEE
Transactions on Automatic Control 26 (1981) 17-32.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.training import DrivenRun, over_a_step
from warmlink.controllers.linear_observer.model import MODES, SENSORS, features

Array = NDArray[np.float64]

LAGS = 10
"""Lags of each feature, at equal ratios from `SHORTEST` steps of a run to its whole length."""

SHORTEST = 3.0

RIDGES = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Shares of the features' mean square, of which one is chosen."""

LEAST_HANKEL = 1e-6
"""Share of the largest Hankel singular value below which a mode is rounding."""


@dataclass(frozen=True)
class LinearModel:
    """dz/dt = A z + B f, outputs = C z + start, where f are the features in SI.

    Attributes
    ----------
    A, B : shape (MODES, MODES) and (MODES, features); modes that are not needed are 0 and fade
    C : thermometers in K, then the growth in m, shape (SENSORS + 1, MODES)
    start : temperatures in K and growth in m while all modes are 0, shape (SENSORS + 1,)
    around : temperature of the surroundings in K from which it counts
    used : thermometers that it shows, places in `SENSED`
    size : root mean square of each feature in the runs, shape (features,)
    hankel : Hankel singular values of all lags, largest first
    """

    A: Array
    B: Array
    C: Array
    start: Array
    around: float
    used: tuple[int, ...]
    size: Array
    hankel: Array

    @property
    def order(self) -> int:
        """Number of modes that are needed."""
        return int(np.count_nonzero(np.any(self.B, axis=1)))

    def outputs(self, run: DrivenRun) -> Array:
        """Temperatures and growth by the duty alone, less their start, shape (n, SENSORS + 1).

        The cooling by motion goes by the temperatures that the model itself makes.
        """
        transition, reach = over_a_step(self.A, self.B, run.step)
        cooled = np.isin(np.arange(SENSORS), self.used)
        z, found = np.zeros(MODES), np.empty((len(run.duty), SENSORS + 1))
        for i, (speed, torque, ambient) in enumerate(run.duty.tolist()):
            found[i] = self.C @ z
            above = cooled * (found[i, :-1] + self.start[:-1] - ambient)
            f = features(speed, torque, ambient - self.around, above.tolist())
            z = transition @ z + reach @ np.array(f)
        return found


def features_of(run: DrivenRun, around: float, used: Sequence[int]) -> Array:
    """Features of a run in SI, shape (n, features), with the temperatures that were measured."""
    speed, torque, ambient = run.duty.T
    none = np.zeros_like(speed)
    above = [run.temperature[:, i] - ambient if i in used else none for i in range(SENSORS)]
    return np.column_stack(features(speed, torque, ambient - around, above))


def lagged(driven: Array, step: float, times: Array) -> Array:
    """First-order lags of signals that are held over a step, shape (n, times * signals)."""
    from scipy.signal import lfilter  # to import it takes half a second, which only a design needs

    kept = np.exp(-step / times)
    each = [lfilter([0.0, 1.0 - a], [1.0, -a], driven, axis=0) for a in kept.tolist()]
    return np.concatenate(each, axis=1)


def identified(runs: Sequence[DrivenRun], held_out: DrivenRun, used: Sequence[int]) -> LinearModel:
    """Find the model of a machine.

    Parameters
    ----------
    runs : from the same start; the modes are 0 where the first begins
    held_out : by which the ridge is chosen
    used : thermometers, places in `SENSED`; a model without any knows the growth by the duty alone
    """
    around, step = float(runs[0].duty[0, 2]), runs[0].step
    start = np.append(runs[0].temperature[0], runs[0].elongation[0])
    times = np.geomspace(SHORTEST * step, step * len(runs[0].duty), LAGS)
    driven = [features_of(run, around, used) for run in runs]
    size = np.sqrt(np.mean(np.vstack(driven) ** 2, axis=0))
    scale = np.where(size > 0, size, 1.0)
    shown = [*used, SENSORS]
    lags = np.vstack([lagged(each / scale, step, times) for each in driven])
    rises = np.vstack([_rises(run, start)[:, shown] for run in runs])
    spread = np.maximum(rises.std(axis=0), 1e-12)
    squares, products = lags.T @ lags / len(lags), lags.T @ (rises / spread) / len(lags)
    load = np.trace(squares) / len(squares) * np.eye(len(squares))
    wanted = _rises(held_out, start)

    def reduced(ridge: float) -> LinearModel:
        weights = linalg.solve(squares + ridge * load, products, assume_a="pos")
        A, B, C, hankel = _balanced(weights, times, scale.size)
        rows = np.zeros((SENSORS + 1, MODES))
        rows[shown] = spread[:, None] * C
        return LinearModel(A, B / scale, rows, start, around, tuple(used), size, hankel)

    found = [reduced(ridge) for ridge in RIDGES]
    off = [np.mean((model.outputs(held_out)[:, -1] - wanted[:, -1]) ** 2) for model in found]
    return found[int(np.nanargmin(np.where(np.isfinite(off), off, np.inf)))]


def _rises(run: DrivenRun, start: Array) -> Array:
    return np.column_stack([run.temperature, run.elongation]) - start


def _balanced(weights: Array, times: Array, count: int) -> tuple[Array, Array, Array, Array]:
    """Balanced truncation of weighted lags to `MODES` modes: A, B, C and all Hankel singular values."""
    rates = np.repeat(1.0 / times, count)
    A, C = -np.diag(rates), weights.T
    B = np.tile(np.eye(count), (times.size, 1)) * rates[:, None]
    # Gramians of a diagonal A are quotients: X_ij = (B B^T)_ij / (r_i + r_j).
    sums = rates[:, None] + rates
    reached, shown = (_root(each / sums) for each in (B @ B.T, C.T @ C))
    left, hankel, right = linalg.svd(shown.T @ reached)
    kept = min(MODES, int(np.count_nonzero(hankel > LEAST_HANKEL * hankel[0])))
    root = hankel[:kept] ** -0.5
    into, back = reached @ right[:kept].T * root, root[:, None] * (left[:, :kept].T @ shown.T)
    sign = np.where(C[-1] @ into < 0, -1.0, 1.0)  # each mode as it makes the machine longer
    into, back = into * sign, back * sign[:, None]
    small_A, small_B = -np.diag(np.full(MODES, rates.max())), np.zeros((MODES, count))
    small_C = np.zeros((len(C), MODES))
    small_A[:kept, :kept], small_B[:kept], small_C[:, :kept] = back @ A @ into, back @ B, C @ into
    return small_A, small_B, small_C, hankel


def _root(square: Array) -> Array:
    """R of R R^T for a matrix that is positive semidefinite but for rounding."""
    values, vectors = linalg.eigh((square + square.T) / 2)
    return vectors * np.sqrt(np.maximum(values, 0.0))
