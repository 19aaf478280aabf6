"""Measurement noise: white and correlated parts estimated from the data, and residuals made white.

The model of a channel's noise is white noise plus a first-order process correlated over about a minute.
Its strength is estimated from what no slow effect can explain: residuals from which every candidate and
every slow course has been taken out. Whittle's likelihood: P. Whittle, "Estimation and information in
stationary time series", Arkiv för Matematik 2 (1953) 423-434.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

SLOW = 900.0
"""s; courses of a longer period are taken for the model's fault, never for noise."""

LASTING = 1200.0
"""s; correlation time of an error that lasts."""

_MEMORIES = (20.0, 40.0, 60.0, 90.0, 130.0, 180.0)
"""Candidate correlation times in s."""

_WORTH = 8.0
"""Gain in twice the log-likelihood that a correlated part must bring."""


@dataclass(frozen=True)
class NoiseModel:
    """Noise of one channel in SI: standard deviations of its parts, and correlation time in s.

    `lasting` is an error that stays for long, as of a coarse converter that rests on one step: it cannot
    be seen in the scatter from row to row, and is known only from a stated noise that is larger.
    """

    white: float
    slow: float = 0.0
    memory: float = 60.0
    lasting: float = 0.0

    @property
    def sigma(self) -> float:
        """Standard deviation of a reading."""
        return float(np.sqrt(self.white**2 + self.slow**2 + self.lasting**2))

    def covariance(self, times: Vector) -> Vector:
        """Covariance of readings at times in s, shape (times, times)."""
        apart = np.abs(times[:, None] - times[None, :])
        result: Vector = self.slow**2 * np.exp(-apart / self.memory)
        result += self.lasting**2 * np.exp(-apart / LASTING)
        result[np.diag_indices(times.size)] += self.white**2
        return result


class Whitener:
    """Turns residuals of one channel in one run into independent numbers of unit variance."""

    def __init__(self, model: NoiseModel, times: Vector) -> None:
        self._scale = 1 / model.white
        self._matrix: Vector | None = None
        if max(model.slow, model.lasting) > 0.05 * model.white and times.size:
            from scipy.linalg import cholesky, solve_triangular

            factor = cholesky(model.covariance(times), lower=True)
            self._matrix = solve_triangular(factor, np.eye(times.size), lower=True)

    def __call__(self, columns: Vector) -> Vector:
        """Whiten columns, shape (times, ...)."""
        return self._scale * columns if self._matrix is None else self._matrix @ columns


def slow_courses(times: Vector, period: float = SLOW) -> Vector:
    """Cosines of a period longer than given, the constant included, shape (times, courses)."""
    span = float(times[-1] - times[0]) if times.size > 1 else 0.0
    count = int(2 * span / period) + 1
    phase = np.pi * (times - times[0]) / max(span, 1e-9)
    return np.cos(np.outer(phase, np.arange(count)))


def estimate(residuals: list[tuple[Vector, Vector]], quantum: float, floor: float) -> NoiseModel:
    """Noise model of a channel.

    Parameters
    ----------
    residuals : for each run times in s and residuals without slow courses, shape (n,) each
    quantum : step to which readings are rounded
    floor : least standard deviation, against data without any noise
    """
    from scipy.fft import dct

    power, angle = [], []
    for times, values in residuals:
        if times.size < 16:
            continue
        step = float(np.median(np.diff(times)))
        removed = 2 * float(times[-1] - times[0]) / SLOW
        first = int(np.ceil(removed)) + 1
        k = np.arange(first, times.size)
        power.append(dct(values, norm="ortho")[first:] ** 2)
        angle.append((np.pi * k / times.size, np.full(k.size, step)))
    if not power:
        return NoiseModel(max(floor, quantum / np.sqrt(12)))
    found = np.concatenate(power)
    phase = np.concatenate([a for a, _ in angle])
    steps = np.concatenate([s for _, s in angle])
    least = max(floor, quantum / np.sqrt(12))
    white = max(float(np.sqrt(_robust_mean(found))), least)
    best, gain = NoiseModel(white), _WORTH
    base = _whittle(found, np.full(found.size, white**2))
    for memory in _MEMORIES:
        if memory < 0.7 * float(np.median(steps)):
            continue
        decay = np.exp(-steps / memory)
        shape = (1 - decay**2) / (1 - 2 * decay * np.cos(phase) + decay**2)
        for share in (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 0.95):
            spectrum = (1 - share) + share * shape
            total = _robust_mean(found / spectrum)
            better = base - _whittle(found, total * spectrum)
            if better > gain:
                gain = better
                sigma = np.sqrt(total)
                best = NoiseModel(
                    max(sigma * np.sqrt(1 - share), least), float(sigma * np.sqrt(share)), memory
                )
    return best


def _robust_mean(power: Vector) -> float:
    """Mean of squares, the few largest of which are limited: a spike that was missed must not rule."""
    mean = float(np.mean(power))
    for _ in range(3):
        mean = float(np.mean(np.minimum(power, 25 * mean)))
    return mean


def _whittle(power: Vector, spectrum: Vector) -> float:
    return float(np.sum(np.log(spectrum) + np.minimum(power / spectrum, 25)))
