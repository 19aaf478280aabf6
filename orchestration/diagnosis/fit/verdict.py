"""The verdict: nothing wrong, causes named, causes that cannot be told apart, or none that explains it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal
from warmlink.orchestration.diagnosis.fit.calibrated import (
    AsItStands,
    as_it_stands,
    calibrated,
    moved,
    refine,
    refined,
)
from warmlink.orchestration.diagnosis.fit.fitted import UNEXPLAINED, lack_of_fit_p
from warmlink.orchestration.diagnosis.fit.fitting import Fit, Fitter, by_number
from warmlink.orchestration.diagnosis.fit.likeliest import likeliest
from warmlink.orchestration.diagnosis.fit.noise import (
    FEWEST,
    LIKED,
    TOLERATED,
    NoiseModel,
    NoiseSample,
    Spectrum,
    estimate,
    slow_courses,
    undisturbed,
)
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.search import HOPELESS, IMPATIENT, PATIENT, Search
from warmlink.orchestration.diagnosis.fit.sensible import refuse_too_short
from warmlink.orchestration.diagnosis.model.instruments import CLOCK
from warmlink.orchestration.progress import Progress, stretch, unseen

Word = Literal["adequate", "named", "ambiguous", "empirical", "unknown"]
"""A verdict; `empirical` is one on held-out rows alone."""

_SEEDS = 4
"""Models that a second search begins from."""

_GRID = 100.0
"""Chi-square that the grid's error at the values of another set may cost a set."""

_AS_IT_STANDS, _CALIBRATED, _SEARCHED = 0.05, 0.3, 0.7
"""Shares of the work that are usually done after the first simulation, the calibration, the first search."""

_MOST_CALIBRATED = 3
"""Times that the noise is estimated anew after a calibration, which it may move."""

_LIKE_STATED = 0.7
"""Ratio of the scatter to the stated noise above which the stated figure adds nothing."""


@dataclass(frozen=True)
class Assessment:
    """What the search found.

    Attributes
    ----------
    word : the verdict
    problem, fitter, search : what it was found with, on the fitted data alone
    begun : the uncorrected model
    best : the chosen model; the uncorrected one for `adequate`
    rivals : models that fit as well, best first
    artefact : error of the simulation's own steps and cells, in standard deviations of all readings
    """

    word: Word
    problem: Problem
    fitter: Fitter
    search: Search
    begun: AsItStands
    best: Fit
    rivals: tuple[Fit, ...]
    artefact: float

    @property
    def null(self) -> Fit:
        """The uncorrected model, calibrated."""
        return self.begun.fit

    @property
    def noise(self) -> tuple[NoiseModel, ...]:
        """Noise by channel."""
        return self.fitter.noise


def assess(experiment: Experiment, progress: Progress = unseen) -> Assessment:
    """Search for what is wrong, on the fitted rows alone.

    Raises
    ------
    InputError
        A run is too short to tell anything from noise.
    """
    problem = Problem(fitted_part(experiment))
    refuse_too_short(problem)
    progress("simulating as it stands", 0.0)
    begun = problem.values_by_run(problem.calibrated, [f.start for f in problem.calibrated])
    problem.refine(begun)
    progress("estimating the noise", _AS_IT_STANDS / 3)
    noise = _noise(problem, None)
    progress("simulating with smaller steps and cells", _AS_IT_STANDS / 2)
    # An artefact of the simulation looks like an effect, so it is ruled out before any physics is blamed.
    artefact = problem.artefact(begun, noise)
    before: dict[frozenset[str], Fit] = {}
    if problem.calibrated:
        for k in range(_MOST_CALIBRATED):
            share = _AS_IT_STANDS + (_CALIBRATED - _AS_IT_STANDS) * np.array([k, k + 1]) / _MOST_CALIBRATED
            fit = calibrated(Fitter(problem, noise), stretch(progress, *share.tolist()))
            refine(problem, fit)
            noise = _noise(problem, fit)
            before, last = {fit.key: fit}, before.get(fit.key)
            if problem.ended_early or (last is not None and not moved(last, fit)):
                break
    first = stretch(progress, _CALIBRATED, _SEARCHED)
    first("causes: what noise and wandering explain")
    search = uncorrected = _search(problem, noise, (), first, before)
    if problem.calibrated and search.items:
        uncorrected = _search(problem, noise, (), unseen, before, alone=True)
    best, lasting = search.run(), any(n.lasting for n in noise)
    progress = stretch(progress, _SEARCHED, 1.0)
    if lasting and search.lack_of_fit_p(best) < UNEXPLAINED:
        # A stated noise may be too small by a factor of two, which an error that lasts does not betray.
        search, best = _searched_again(search, best, progress, inflation=2.0)
    elif best.items:
        search, best = _searched_again(search, best, progress)
        if fewer := _with_fewer(search, best):
            search, best = _searched_again(search, fewer, progress)
    unexplained = search.lack_of_fit_p(best) < UNEXPLAINED
    if unexplained and not lasting and any(n.slow for n in search.fitter.noise):
        # What noise correlated as strongly as is just credible would explain is not called unknown.
        tolerant = Fitter(problem, _noise(problem, best, liked=TOLERATED))
        if lack_of_fit_p(tolerant, best) >= UNEXPLAINED:
            search, best = _searched_again(search, best, progress, liked=TOLERATED)
    word, rivals = _judge(search, best)
    stands = as_it_stands(uncorrected.fitter, uncorrected.null)
    best = refined(search.fitter, best)
    return Assessment(word, problem, search.fitter, search, stands, best, rivals, artefact)


def _search(
    problem: Problem,
    noise: Sequence[NoiseModel],
    known: Sequence[Fit],
    progress: Progress,
    before: Mapping[frozenset[str], Fit] = MappingProxyType({}),
    alone: bool = False,
) -> Search:
    """A search with what wanders beside its log, judged from nothing and from known models.

    It has no causes to think of where the uncorrected model stands `alone`.
    """
    still = Search(Fitter(problem, noise), progress, before, alone)
    if any(each.lasting for each in noise):
        return still  # an error that lasts wanders already
    wander, responses = likeliest(still, (still.null, *known))
    return (
        still if wander.still else Search(Fitter(problem, noise, wander, responses), progress, before, alone)
    )


def _searched_again(
    search: Search,
    best: Fit,
    progress: Progress,
    inflation: float = 1.0,
    liked: float = LIKED,
) -> tuple[Search, Fit]:
    """Search again from the best models so far, where the grid's error and the noise are better known."""
    problem = search.fitter.problem
    doing = "looking again from " + (" + ".join(sorted(best.key)) or "the start")
    progress(doing, 0.0)
    refine(problem, best)
    sought = (fit for fit in search.rivals(best) if not any(item.cause.twin_of for item in fit.items))
    known = [best, *sought] if best.items else []
    fresh = _search(problem, _noise(problem, best, inflation, liked), known[:1], progress, search.fits)
    for k, seed in enumerate(seeds := known[:_SEEDS]):
        progress(f"{doing}: fit {k + 1} of {len(seeds)}", 0.0)
        fresh.add(fresh.fitter.fit(seed.items, seed.values))
    hopeless = max(search.lack_of_fit_p(best), fresh.lack_of_fit_p(fresh.best)) < HOPELESS
    return fresh, fresh.run(patience=IMPATIENT if hopeless else PATIENT)


def _with_fewer(search: Search, best: Fit) -> Fit | None:
    """The best set less one cause, if it is better once the grid's error is that at its own values.

    The search takes the error, and what leaps of the inputs do, at one set's values for all of them, and a
    further cause may fit what that leaves of another set's. A clock moves the leaps themselves, so that a set
    without it may be far from its own chi-square.
    """
    near, own = best.chi2 + search.penalty(best.items) + _GRID, []
    for item in best.items:
        kept = tuple(each for each in best.items if each is not item)
        known = search.fits.get(frozenset(each.title for each in kept)) if kept else None
        if item.cause.kind == "record" or (known is not None and search.score(known) < near):
            own.append(search.fitter.fit(kept, best.values))
    own = [_anew(search, fit) for fit in (best, *own)] if own else []
    first = min(own, key=search.score, default=best)
    return None if first.key == best.key else first


def _anew(search: Search, fit: Fit) -> Fit:
    """A fit again, with the grid's error and what leaps do as they are at its own values."""
    refine(search.fitter.problem, fit)
    return search.fitter.anew().fit(fit.items, fit.values)


def _noise(
    problem: Problem, fit: Fit | None, inflation: float = 1.0, liked: float = LIKED
) -> list[NoiseModel]:
    """Estimated noise of each channel, with an error that lasts where a stated figure tells of one.

    A stated noise of about the size of the scatter from row to row, or smaller, adds nothing. One
    that is clearly larger means an error that lasts; `inflation` allows for a figure that is too small.
    """
    models = _without_slow_courses(problem, fit, liked)
    for i, (variable, model) in enumerate(zip(problem.variables, models, strict=True)):
        stated = problem.experiment.noise.get(variable, 0.0)
        scatter = max(float(data.scatter[i]) for data in problem.data)
        if max(model.sigma, scatter) <= _LIKE_STATED * stated:
            # As much white as stated keeps a fit from trusting the fast course, which the inputs blur.
            models[i] = replace(model, white=stated, lasting=inflation * stated)
    return models


def _without_slow_courses(problem: Problem, fit: Fit | None, liked: float) -> list[NoiseModel]:
    """Noise model of each channel from residuals without slow courses, as `_noise` is asked for it.

    Before any model everything that a candidate may explain is taken out as well.
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
            if rows.size < FEWEST:
                continue
            columns = by_slot[rows, channel]
            if fit is not None and fit.items:
                columns = by_number(columns, fit.freed, run, fit.freed)
            leaps = problem.leaping[run][rows, channel]
            leaps = leaps[:, np.linalg.norm(leaps, axis=0) > max(data.scatter[channel], floor)]
            removed = orthonormal(np.column_stack([columns, leaps, slow_courses(data.time[rows])]), 1e-3)
            residual = residual - removed @ (removed.T @ residual)
            samples += undisturbed(NoiseSample(data.time[rows], residual, removed, data.averaging))
            least = max(least, float(data.quantum[channel]) / np.sqrt(12))
        together = np.concatenate(raw)
        unresolved = float(np.sqrt(together @ together / max(together.size, 1)))
        spectra.append(Spectrum(samples, least, problem.averaging, unresolved))
    return estimate(spectra, liked)


def _judge(search: Search, best: Fit) -> tuple[Word, tuple[Fit, ...]]:
    if search.lack_of_fit_p(best) < UNEXPLAINED:
        return "unknown", tuple(search.rivals(best)) if best.items else ()
    if not best.items:
        return "adequate", ()
    rivals = tuple(search.rivals(best))
    if best.resting:
        rivals += _off_bounds(search, best, {fit.key for fit in rivals})
        if all(fit.resting for fit in rivals):
            return "unknown", rivals  # nothing explains the data within the bounds
    rivals = (*rivals, *search.extended(best))
    known = {best.key, *(fit.key for fit in rivals)}
    cancelling = (found for fit in (best, *rivals) for found in search.cancelling(fit))
    rivals += tuple({fit.key: fit for fit in cancelling if fit.key not in known}.values())
    return ("ambiguous" if rivals else "named"), rivals


def _off_bounds(search: Search, best: Fit, known: set[frozenset[str]]) -> tuple[Fit, ...]:
    """The best sets that rest on no bound: a best set that does is doubtful, so these are kept as rivals."""
    size = len(best.items)
    free = [f for f in search.fits.values() if len(f.items) == size and f.admissible and not f.resting]
    if not free:
        return ()
    first = min(free, key=search.score)
    if search.lack_of_fit_p(first) < UNEXPLAINED:
        return ()
    beside = (first, *search.rivals(first))
    return tuple(f for f in beside if not f.resting and f.key not in known and f.key != best.key)


def fitted_part(experiment: Experiment) -> Experiment:
    """Give the experiment without any reading that is held out.

    Its inputs go on for as long as a clock may be early: what is stamped early shows what they do then.
    """
    early = max((-cause.lower for cause in experiment.catalogue if CLOCK in cause.frees), default=0.0)
    runs = (run for run in experiment.runs if not run.heldout)
    return replace(experiment, runs=tuple(_fitted_part(run, early) for run in runs))


def _fitted_part(run: Run, early: float) -> Run:
    part = run.part(run.time < run.fit_until + early)
    return replace(part, readings={n: np.where(part.fitted, v, np.nan) for n, v in part.readings.items()})
