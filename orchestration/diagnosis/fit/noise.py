"""Measurement noise: white and correlated parts estimated from the data, and residuals made white.

The model of a channel's noise is white noise plus a first-order process correlated over about a minute.
Its strength is estimated from what no slow effect can explain: residuals from which every candidate and
every slow course has been taken out. Whittle's likelihood: P. Whittle, "Estimation and information in
stationary time series", Arkiv för Matematik 2 (1953) 423-434.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.thinning import ROW, Averaging

SLOW = 900.0
"""s; courses of a longer period are taken for the model's fault, never for noise."""

LASTING = 1200.0
"""s; correlation time of an error that lasts."""

_MEMORIES = (20.0, 40.0, 60.0, 90.0, 130.0, 180.0)
"""Candidate correlation times in s."""

_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 0.95)
"""Candidate shares of the variance that are correlated."""

_WORTH = 8.0
"""Gain in twice the log-likelihood that a correlated part must bring."""

_APART = 14.0
"""Gain in twice the log-likelihood from which a channel has another form of noise than the others."""

LIKED, TOLERATED = 4.0, 14.0
"""Loss of twice the log-likelihood within which a form of the noise is likely, and just credible."""

FEWEST = 16
"""Readings, or frequencies, that say something about noise."""

_BLOCK, _STRETCH, _FEWEST_STRETCHES = 6, 60, 5
"""Readings in a mean, readings in a stretch of means, and the fewest stretches that can be compared."""

_LOUD, _LOUDER = 15.0, 4.0
"""Multiple of the median power that noise does not reach in a stretch; the same beside such a stretch."""

_KEPT = 0.4
"""Share of a frequency's power that must be left after what was taken out."""


@dataclass(frozen=True)
class NoiseModel:
    """Noise of one channel in SI: standard deviations of its parts, and correlation time in s.

    `lasting` is an error that stays the same for long, as that of a coarse converter which rests on one
    step. It does not show in the scatter from row to row; only a larger stated noise tells of it.
    """

    white: float
    slow: float = 0.0
    memory: float = 60.0
    lasting: float = 0.0

    @property
    def sigma(self) -> float:
        """Standard deviation of a reading."""
        return float(np.sqrt(self.white**2 + self.slow**2 + self.lasting**2))

    def averaged(self, here: Averaging, known: Averaging) -> NoiseModel:
        """Noise after another averaging than the one for which it is known.

        A stated figure, recognised by `lasting`, applies to every reading.
        """
        if here == known or self.lasting:
            return self
        white = self.white * np.sqrt(known.rows / here.rows)
        slow = self.slow * np.sqrt(here.kept(self.memory) / known.kept(self.memory))
        return replace(self, white=float(white), slow=float(slow))

    def covariance(self, times: Array) -> Array:
        """Covariance of readings at times in s, shape (times, times)."""
        apart = np.abs(times[:, None] - times[None, :])
        result: Array = self.slow**2 * np.exp(-apart / self.memory)
        result += self.lasting**2 * np.exp(-apart / LASTING)
        result[np.diag_indices(times.size)] += self.white**2
        return result


class Whitener:
    """Turns residuals of one channel in one run into independent numbers of unit variance."""

    def __init__(self, model: NoiseModel, times: Array) -> None:
        self._scale = 1 / model.white
        self._transposed: Array | None = None
        if max(model.slow, model.lasting) > 0.05 * model.white and times.size:
            slow, lasting = (round(self._scale * each, 9) for each in (model.slow, model.lasting))
            self._transposed = _root(NoiseModel(1.0, slow, model.memory, lasting), times.tobytes())

    def __call__(self, columns: Array) -> Array:
        """Whiten columns, shape (times, columns)."""
        if self._transposed is None:
            return self._scale * columns
        from scipy.linalg.blas import dtrmm  # the half that is zero is left out

        return np.asarray(dtrmm(self._scale, self._transposed, columns.T, side=1).T)


@lru_cache(maxsize=12)
def _root(model: NoiseModel, times: bytes) -> Array:
    """Inverse of the lower root of the covariance at times, transposed: channels of a run often share it."""
    from scipy.linalg import cholesky, solve_triangular

    at = np.frombuffer(times)
    lower = solve_triangular(cholesky(model.covariance(at), lower=True), np.eye(at.size), lower=True)
    return np.asfortranarray(lower.T)


def slow_courses(times: Array) -> Array:
    """Cosines of a period longer than `SLOW`, the constant included, shape (times, courses).

    There are no more of them than times: faster ones look the same at rows as far apart.
    """
    span = float(times[-1] - times[0]) if times.size > 1 else 0.0
    count = min(int(2 * span / SLOW) + 1, times.size)
    phase = np.pi * (times - times[0]) / max(span, 1e-9)
    return np.cos(np.outer(phase, np.arange(count)))


@dataclass(frozen=True)
class NoiseSample:
    """Residuals of a channel in a run, and what was taken out of them.

    Attributes
    ----------
    times : s, shape (n,)
    values : residuals, orthogonal to `removed`, shape (n,)
    removed : orthonormal columns, shape (n, columns)
    averaging : rows and time over which each value was averaged
    """

    times: Array
    values: Array
    removed: Array
    averaging: Averaging = ROW

    def part(self, rows: slice) -> NoiseSample:
        """Some of the rows."""
        return replace(self, times=self.times[rows], values=self.values[rows], removed=self.removed[rows])


def undisturbed(sample: NoiseSample) -> list[NoiseSample]:
    """Parts of a sample without the stretches that stand out in their courses.

    Noise is the same throughout a run. A stretch that is much louder is a fault of the model, for example a
    jump or a stuck sensor, and would be mistaken for correlated noise.
    """
    windows = sample.times.size // _STRETCH
    if windows < _FEWEST_STRETCHES:
        return [sample]
    blocks = sample.values[: windows * _STRETCH].reshape(windows, -1, _BLOCK).mean(axis=2)
    power = np.mean(blocks**2, axis=1) / np.median(np.mean(blocks**2, axis=1))
    beside = np.convolve(power > _LOUD, [1, 1, 1], "same") > 0
    loud = beside & (power > _LOUDER)
    if not loud.any() or loud.mean() > 0.5:
        return [sample]
    edges = np.flatnonzero(np.diff(np.concatenate([[1], loud.astype(int), [1]]))) * _STRETCH
    edges[edges == windows * _STRETCH] = sample.times.size
    return [sample.part(slice(first, last)) for first, last in edges.reshape(-1, 2).tolist()]


class Spectrum:
    """Periodogram of a channel's residuals, corrected for what was taken out of them.

    Parameters
    ----------
    samples : residuals by run
    least : least standard deviation that the channel may have
    known : the averaging for which the noise is requested
    unresolved : standard deviation where there are too few frequencies to tell
    """

    def __init__(
        self, samples: Sequence[NoiseSample], least: float, known: Averaging = ROW, unresolved: float = 0.0
    ) -> None:
        from scipy.fft import dct

        self._known, self.least, self.unresolved = known, least, unresolved
        self._averagings: list[Averaging] = []
        found = [np.zeros((5, 0))]
        for sample in (each for each in samples if each.times.size >= FEWEST):
            size, place = sample.times.size, len(self._averagings)
            self._averagings.append(sample.averaging)
            first = int(np.ceil(2 * float(np.ptp(sample.times)) / SLOW)) + 1
            kept = 1 - np.sum(dct(sample.removed, axis=0, norm="ortho") ** 2, axis=1)
            modes = np.arange(size)
            modes = modes[(modes >= first) & (kept > _KEPT)]
            power = dct(sample.values, norm="ortho")[modes] ** 2 / kept[modes]
            same = np.repeat([[np.median(np.diff(sample.times))], [place]], modes.size, axis=1)
            found.append(np.vstack([power, np.pi * modes / size, kept[modes], same]))
        self.power, self.phase, self.weight, self.steps, of_sample = np.concatenate(found, axis=1)
        self._of_sample = of_sample.astype(int)

    def total(self, memory: float, share: float) -> float:
        """Variance for a share of it correlated over a memory in s."""
        return max(_robust_mean(self.power / self._shape(memory, share)), self.least**2)

    def misfit(self, memory: float, share: float) -> float:
        """Minus twice Whittle's log-likelihood, at the best variance."""
        shape = self._shape(memory, share)
        spectrum = self.total(memory, share) * shape
        return float(np.sum(self.weight * (np.log(spectrum) + np.minimum(self.power / spectrum, 25))))

    def _shape(self, memory: float, share: float) -> Array:
        decay = np.exp(-self.steps / memory)
        correlated = (1 - decay**2) / (1 - 2 * decay * np.cos(self.phase) + decay**2)
        # Variance of white and of correlated noise in each sample, as a multiple of the known one.
        unit = NoiseModel(1.0, 1.0, memory)
        here = [unit.averaged(averaging, self._known) for averaging in self._averagings]
        sizes = np.array([(each.white**2, each.slow**2) for each in here]).reshape(-1, 2)
        white, slow = sizes[self._of_sample].T
        return (1 - share) * white + share * slow * correlated


def estimate(spectra: Sequence[Spectrum], liked: float = LIKED) -> list[NoiseModel]:
    """Noise model of each channel: of the forms within a loss of log-likelihood the slowest.

    The correlated share and its duration are the same in all channels unless one clearly differs: an hour of
    a single channel is too short to estimate them.
    """
    models = [NoiseModel(max(spectrum.least, spectrum.unresolved)) for spectrum in spectra]
    known = [i for i, spectrum in enumerate(spectra) if spectrum.power.size >= FEWEST]
    if not known:
        return models
    step = min(float(np.median(spectra[i].steps)) for i in known)
    forms = [(60.0, 0.0), *((m, s) for m in _MEMORIES if m > 0.7 * step for s in _SHARES)]
    table = np.array([[spectra[i].misfit(*form) for form in forms] for i in known])
    together = table.sum(axis=0)
    common = 0
    if together.min() <= together[0] - _WORTH:
        # Of forms that the data like about equally the one with the most noise in slow courses: what
        # is only noise must not be called a finding.
        likely = np.flatnonzero(together < together.min() + liked)
        common = int(max(likely, key=lambda i: _long_run(*forms[i], step)))
    for row, i in zip(table, known, strict=True):
        own = int(np.argmin(row))
        memory, share = forms[own if row[own] < row[common] - _APART else common]
        variance = spectra[i].total(memory, share)
        white = max(float(np.sqrt(variance * (1 - share))), spectra[i].least)
        models[i] = NoiseModel(white, float(np.sqrt(variance * share)), memory)
    return models


def _long_run(memory: float, share: float, step: float) -> float:
    """Variance of slow courses as a multiple of the readings' variance."""
    decay = float(np.exp(-step / memory))
    return (1 - share) + share * (1 + decay) / (1 - decay)


def _robust_mean(power: Array) -> float:
    """Mean of squares with the few largest ones limited, so that a missed spike does not dominate."""
    mean = float(np.mean(power))
    for _ in range(3):
        mean = float(np.mean(np.minimum(power, 25 * mean)))
    return mean
