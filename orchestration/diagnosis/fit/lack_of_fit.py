"""Whether anything is left in the residuals that noise does not explain."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.fit import noise
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, by_number
from warmlink.orchestration.diagnosis.fit.problem import Problem

UNEXPLAINED = 0.001
"""Chance of residuals as slow as those that a model leaves, below which it does not explain the run."""

_FEWEST = 8
"""Readings of a channel in a run whose slow courses are worth a test."""


def lack_of_fit_p(fitter: Fitter, fit: Fit) -> float:
    """Chance level of the slow courses in a fit's residuals, all together and in each channel of each run.

    What is wrong with one sensor shows by itself, and is lost among many. The chance level is that of the
    less likely outcome of the two, counted with the number of tests (Bonferroni). The statistic is an
    F ratio, since the noise itself is estimated from what is not slow.
    """
    from scipy.linalg import block_diag
    from scipy.special import fdtrc

    residuals, courses, sensitivities, widths = [], [], [], []
    for run, channels in enumerate(fitter.whitened(fit.freed, fit.theta)):
        joined = np.concatenate(channels)
        residuals.append(joined[:, 0])
        sensitivities.append(by_number(joined[:, 1:], fit.freed, run, fit.freed))
        times = [fitter.problem.data[run].time[rows] for rows in fitter.rows[run]]
        tables = [noise.slow_courses(t) if t.size >= _FEWEST else np.zeros((t.size, 0)) for t in times]
        ends = np.cumsum([t.size for t in times])
        courses.append(np.concatenate(fitter.whiten(run, np.split(block_diag(*tables), ends[:-1]))))
        widths += [table.shape[1] for table in tables if table.shape[1]]
    residual = np.concatenate(residuals)
    basis = block_diag(*courses)
    taken = orthonormal(np.concatenate(sensitivities))
    residual = residual - taken @ (taken.T @ residual)
    basis = basis - taken @ (taken.T @ basis)
    slow = orthonormal(basis)
    rest = max(residual.size - slow.shape[1] - taken.shape[1], 1)

    def chance(courses: Array) -> float:
        chi2, degrees = float(np.sum((courses.T @ residual) ** 2)), max(courses.shape[1], 1)
        # Half of the rest's degrees of freedom: the noise's correlation was estimated too.
        return float(fdtrc(degrees, max(rest // 2, 4), chi2 / degrees))

    edges = np.cumsum([0, *widths])
    single = min(chance(orthonormal(basis[:, a:b])) for a, b in pairwise(edges))
    return min(1.0, 2 * min(chance(slow), len(widths) * single))


def estimated_noise(problem: Problem, fit: Fit | None, liked: float) -> list[noise.NoiseModel]:
    """Noise model of each channel from residuals without slow courses.

    Parameters
    ----------
    problem : the data
    fit : the model whose residuals serve; None before any model: then everything that a candidate may
        explain is taken out as well
    liked : see `estimate`
    """
    at = problem.values_by_run(fit.freed, fit.theta) if fit else problem.neutral
    predicted = [problem.predict(run, z) for run, z in enumerate(at)]
    spectra = []
    for channel, floor in enumerate(problem.floors.tolist()):
        samples, raw, least = [], [np.zeros(0)], floor
        for run, (data, (values, by_slot)) in enumerate(zip(problem.data, predicted, strict=True)):
            rows = np.flatnonzero(data.fitted & np.isfinite(data.readings[:, channel]))
            residual = data.readings[rows, channel] - values[rows, channel]
            raw.append(residual)
            if rows.size < noise.FEWEST:
                continue
            columns = by_slot[rows, channel]
            if fit is not None and fit.items:
                columns = by_number(columns, fit.freed, run, fit.freed)
            removed = orthonormal(np.column_stack([columns, noise.slow_courses(data.time[rows])]), 1e-3)
            residual = residual - removed @ (removed.T @ residual)
            samples += noise.undisturbed(noise.Sample(data.time[rows], residual, removed, data.averaging))
            least = max(least, float(data.quantum[channel]) / np.sqrt(12))
        together = np.concatenate(raw)
        unresolved = float(np.sqrt(together @ together / max(together.size, 1)))
        spectra.append(noise.Spectrum(samples, least, problem.averaging, unresolved))
    return noise.estimate(spectra, liked)
