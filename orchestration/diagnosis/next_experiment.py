"""The next experiment: the feasible duty cycle that best tells apart what this one could not.

For each candidate duty cycle the best model's readings are predicted; the distance to the nearest
readings that a rival can give, its numbers refitted, is the separation expected in standard
deviations (T-optimal design: A. C. Atkinson and V. V. Fedorov, Biometrika 62 (1975) 57-70). The cycle
that separates best is repeated until that is enough, the new run being judged by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.experiment import Experiment
from warmlink.orchestration.diagnosis.fitting import Fit, Fitter, overridden
from warmlink.orchestration.diagnosis.gain import Scores
from warmlink.orchestration.diagnosis.lack_of_fit import _orthonormal
from warmlink.orchestration.diagnosis.measured import Run
from warmlink.orchestration.diagnosis.noise import NoiseModel, Whitener
from warmlink.orchestration.diagnosis.problem import Problem
from warmlink.orchestration.diagnosis.verdict import Assessment

Vector = NDArray[np.float64]

INTERVAL = 30.0
"""s over which the rows of the experiment proposed are averaged."""

ROOM = 295.15
MOST_RIVALS = 12
FURTHER = 30.0
"""Chi-square within which a model that these data rule out is still considered."""

NEVER = 0.5
"""Expected separation in standard deviations below which a duty cycle tells nothing apart."""

ENOUGH = 7.0
"""Separation at which a rival is left behind for good.

At 5 its chi-square, which then scatters about 25 by 10, is worse with 19 chances in 20 by more than the
level at which a set counts as told apart; an effect that was just noticed is likely to be smaller than it
seemed, by a third at worst.
"""

ROUNDS = (1, 2, 3, 4, 6, 8, 12, 16)
LONGEST = 86400.0
"""How often a duty cycle may be repeated, and s that all of it may take."""


@dataclass(frozen=True)
class Stage:
    """Part of a duty cycle: s, rad/s, N.m, and temperatures in K."""

    duration_s: float
    speed: float
    torque: float
    pad_temperature: float | None = None
    ambient_temperature: float = ROOM


@dataclass(frozen=True)
class Proposed:
    """What to do next, why, and the separation it should bring."""

    duty: tuple[Stage, ...]
    why: str
    expected_separation_sigma: float

    @property
    def cycle(self) -> tuple[tuple[Stage, ...], int]:
        """Shortest cycle that the duty repeats, and how often."""
        count = len(self.duty)
        for length in range(1, count):
            if count % length == 0 and self.duty == self.duty[:length] * (count // length):
                return self.duty[:length], count // length
        return self.duty, 1


_REST = Stage(900, 0.0, 0.0)
_FAST = Stage(1500, 4.5, 0.5)
_HEAVY = Stage(1500, 1.0, 5.0)
_STALL = Stage(1500, 0.0, 4.5)
_BOTH = Stage(1500, 3.43, 2.5)
_PAD = Stage(1500, 0.0, 0.0, ROOM + 35)
_LONG_REST = Stage(2700, 0.0, 0.0)
_HOT = Stage(2700, 0.0, 4.5, ROOM + 60)  # pad and winding together: the shaft 45 K warm, the winding 80 K
_HOT_FAST = Stage(2700, 4.5, 2.5, ROOM + 60)

DUTIES: tuple[tuple[Stage, ...], ...] = (
    (_REST, _BOTH, _LONG_REST, _FAST),
    (_FAST, _REST, _HEAVY, _REST, _PAD, _REST),
    (_PAD, _LONG_REST, _STALL, _REST),
    (_HEAVY, _FAST, _HEAVY, _FAST),
    (_PAD, _FAST, _PAD, _REST),
    (_LONG_REST, _STALL, _FAST, _REST),
    (_STALL, _BOTH, _REST, _PAD),
    (_HOT, _LONG_REST),
    (_HOT_FAST, _LONG_REST),
    (_HOT, _REST, _HOT_FAST, _LONG_REST),
    (_HOT, _FAST, _LONG_REST),
    tuple(
        replace(s, duration_s=600.0)
        for s in (_FAST, _REST, _HEAVY, _REST, _STALL, _REST, _PAD, _REST, _BOTH, _REST, _FAST, _REST)
    ),
    tuple(replace(s, duration_s=300.0) for s in (_BOTH, _REST, _PAD, _REST, _FAST, _REST, _HEAVY, _REST) * 3),
)
"""Feasible duty cycles of one to three hours."""


def next_experiment(assessment: Assessment, experiment: Experiment) -> Proposed | None:
    """Choose what tells the best model from its rivals; None where there is no rival."""
    fitter, best, rivals = assessment.fitter, assessment.best, assessment.rivals
    if not rivals:
        return None
    others = list(rivals[:MOST_RIVALS])
    if experiment.rig.name != "WarmupCell":
        return _another_run(fitter, best, others, experiment)
    # The new run is judged by itself, so that it must rule out as well what these data just could.
    known = {best.key, *(fit.key for fit in rivals)}
    further = [fit for fit in assessment.search.rivals(best, FURTHER) if fit.key not in known]
    further = further[: MOST_RIVALS - len(others)]
    table = np.array([_separations(fitter, best, [*others, *further], experiment, d) for d in DUTIES])
    separable = table.max(axis=0) > NEVER
    if not separable[: len(others)].any():
        names = " and ".join(sorted({item.name for fit in (best, *others) for item in fit.items}))
        check = next((i.cause.check for i in best.items if i.title not in others[0].key), "")
        return Proposed((), f"No duty cycle tells {names} apart. {check}", 0.0)
    apart = [fit for fit, s in zip(others, separable, strict=False) if s]
    against = [fit for fit, s in zip([*others, *further], separable, strict=True) if s]
    duty = DUTIES[int(np.argmax(table[:, separable].min(axis=1)))]
    length = sum(stage.duration_s for stage in duty)
    separation, rounds = 0.0, 1
    for rounds in (n for n in ROUNDS if n * length <= LONGEST):
        separation = min(_separations(fitter, best, against, experiment, duty * rounds))
        if separation > ENOUGH:
            break
    hours = rounds * length / 3600
    why = f"In {hours:.1f} hours it tells {_title(best)} from {', '.join(_title(f) for f in apart)}."
    never = [fit for fit, s in zip(others, separable, strict=False) if not s]
    if never:
        why += f" Nothing tells it from {', '.join(_title(f) for f in never)}."
    return Proposed(duty * rounds, why, separation)


def _title(fit: Fit) -> str:
    return " + ".join(sorted(fit.key))


def _separations(
    fitter: Fitter, best: Fit, rivals: Sequence[Fit], experiment: Experiment, duty: Sequence[Stage]
) -> list[float]:
    measured = experiment.runs[0]
    share = min(measured.fit_until / float(measured.time[-1]), 1.0)
    problem = Problem(replace(experiment, runs=(_run_of(duty, fitter.problem, share),)))
    spacing = float(np.median(np.diff(fitter.problem.data[0].time)))
    # The mean over an interval scatters less than a row does.
    noise = [replace(n, white=n.white * np.sqrt(min(spacing / INTERVAL, 1.0))) for n in fitter.noise]
    return _distances(noise, problem, best, rivals)


def _distances(
    noise: Sequence[NoiseModel], problem: Problem, best: Fit, rivals: Sequence[Fit], told: bool = False
) -> list[float]:
    """Separation of the best model from each rival on the last run of a problem.

    The run is judged by itself, the rival's numbers free, or `told` what the fitted runs say of both
    models' numbers.
    """
    run = len(problem.data) - 1
    whiten = [Whitener(n, problem.data[run].time) for n in noise]
    truth, own = _whitened(problem, best, run, whiten)
    result = []
    for rival in rivals:
        readings, columns = _whitened(problem, rival, run, whiten)
        apart = truth - readings
        if rival.key > best.key:  # it can do all that the best does, so the best must not follow it
            columns = own
        if told:
            free = np.column_stack([own @ _root(best.covariance()), columns @ _root(rival.covariance())])
            # (I + F F')^-1 by Woodbury's identity
            part = free.T @ apart
            rest = apart @ apart - part @ np.linalg.solve(np.eye(free.shape[1]) + free.T @ free, part)
            result.append(float(np.sqrt(np.maximum(rest, 0.0))))
        else:
            taken = _orthonormal(columns)
            result.append(float(np.linalg.norm(apart - taken @ (taken.T @ apart))))
    return result


def _whitened(problem: Problem, fit: Fit, run: int, whiten: Sequence[Whitener]) -> tuple[Vector, Vector]:
    freed, theta = Scores.carry(problem, fit)
    values, by_slot = problem.predict(run, problem.values(run, freed, theta))
    here = {(f.variable, f.group, f.calibrated): f for f in freed}
    columns = np.zeros((*values.shape, len(fit.freed)))
    for j, fitted in enumerate(fit.freed):
        f = here.get((fitted.variable, fitted.group, fitted.calibrated))
        if f is not None and run in f.runs and not (f.calibrated and overridden(f, freed, run)):
            columns[:, :, j] = by_slot[:, :, list(f.slots)].sum(axis=2)
    joined = np.concatenate([values[:, :, None], columns], axis=2)
    together = np.concatenate([w(joined[:, i]) for i, w in enumerate(whiten)])
    return together[:, 0], together[:, 1:]


def _root(covariance: Vector) -> Vector:
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def _run_of(duty: Sequence[Stage], problem: Problem, share: float) -> Run:
    """The share of a duty cycle that a diagnosis of it would fit, as a run."""
    ends = np.cumsum([stage.duration_s for stage in duty])
    time = np.arange(0.0, share * ends[-1] + INTERVAL / 2, INTERVAL)
    which = np.clip(np.searchsorted(ends, time, side="right"), 0, len(duty) - 1)
    stages = [duty[i] for i in which]
    pad = np.array([np.nan if s.pad_temperature is None else s.pad_temperature for s in stages])
    inputs = {
        "motor.speed": np.array([s.speed for s in stages]),
        "motor.torque": np.array([s.torque for s in stages]),
        "motor.ambient_temperature": np.array([s.ambient_temperature for s in stages]),
        "motor.pad_temperature": pad,
    }
    return Run("next", time, inputs, {v: np.zeros(time.size) for v in problem.variables})


def _another_run(fitter: Fitter, best: Fit, rivals: Sequence[Fit], experiment: Experiment) -> Proposed:
    """Propose a run with labels in a combination that was not fitted yet."""
    runs = [run for run in experiment.runs if not run.heldout]
    names = list(runs[0].labels)
    values = [list(dict.fromkeys(run.labels[n] for run in runs)) for n in names]
    tried = {tuple(run.labels[n] for n in names) for run in runs}
    combinations = [tuple(c) for c in _product(values) if tuple(c) not in tried]
    found: list[tuple[float, tuple[str, ...]]] = []
    for labels in combinations:
        like = replace(runs[0], name="next", labels=dict(zip(names, labels, strict=True)))
        problem = Problem(replace(experiment, runs=(*runs, like)))
        found.append((max(_distances(fitter.noise, problem, best, rivals, told=True)), labels))
    if not found or max(found)[0] < NEVER:
        return Proposed((), f"No further run of this kind tells {_title(best)} from its rivals.", 0.0)
    separation, labels = max(found)
    words = " and ".join(f"{n} = {v}" for n, v in zip(names, labels, strict=True))
    together = " and ".join(names)
    why = (
        f"In the fitted runs {together} change together, so their effects cannot be told apart; "
        f"a run with {words} would tell them apart."
    )
    return Proposed((), why, separation)


def _product(values: Sequence[Sequence[str]]) -> list[list[str]]:
    result: list[list[str]] = [[]]
    for each in values:
        result = [[*head, value] for head in result for value in each]
    return result
