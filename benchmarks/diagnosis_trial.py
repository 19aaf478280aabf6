"""One trial of the diagnosis: a fresh run with hidden effects, and what was said of it."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.hidden_effects import (
    KINDS,
    KNOWN,
    TWINS,
    Kind,
    drawn,
    drawn_duty,
    expected_gain,
    over_a_decade,
    weakened,
    with_gaps,
)
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.data.experiment import Experiment
    from warmlink.orchestration.diagnosis.fit.verdict import Assessment

_VARIED = 7200.0
"""s that a drawn duty cycle lasts, or a little longer."""

_TRACE = 1.0
"""Expected gain in chi-square below which an effect leaves no trace in a run."""


@dataclass(frozen=True)
class Trial:
    """One hidden truth and what was said of it.

    Attributes
    ----------
    number : of the trial within its kind, from which its random choices follow
    strengths : of the hidden effects in SI, in the order of `truth`
    rivals : the other sets of an ambiguous verdict
    unexplained_p : chance level of what the chosen model leaves
    right : the truth is the verdict, or a member of the stated ambiguous set; `adequate` where the effect
        leaves no trace in the run
    wrong_name : a cause or set was named with confidence that is not the truth
    covered : whether each hidden strength lies in its 95 % interval, where the truth was found best
    heldout : held-out error in units of noise, where the verdict is `named`
    followed : whether the next experiment of an ambiguous verdict, carried out on the truth, leads to the
        right name, both runs diagnosed together; None where none was proposed
    as_said : whether it does, or leaves beside the truth only what the proposal said nothing tells from it
    seconds : processor time of the search
    """

    kind: str
    number: int
    truth: tuple[str, ...]
    strengths: tuple[float, ...]
    verdict: str
    found: tuple[str, ...]
    rivals: tuple[str, ...]
    unexplained_p: float
    right: bool
    wrong_name: bool
    covered: tuple[bool, ...]
    heldout: float | None
    followed: bool | None
    as_said: bool | None
    seconds: float


def _stated(experiment: Experiment, kind: Kind) -> dict[str, float]:
    """Noise that the experiment claims by variable, SI."""
    factor = kind.stated or 1.0
    return {
        column.variable: factor
        * (kind.noise.elongation if column.name == "elongation" else kind.noise.temperature)
        for column in experiment.columns
    }


def trial(task: tuple[str, int, int]) -> Trial:
    """Carry out one trial, given its kind, the bench's seed and its number."""
    from warmlink.orchestration.diagnosis.fit.verdict import assess
    from warmlink.orchestration.diagnosis.ladder.prediction import Scores

    kind_name, seed, i = task
    kind = KINDS[kind_name]
    random = np.random.default_rng([seed, i, list(KINDS).index(kind_name)])
    effects = drawn(kind, random)
    if kind.varied:
        effects = over_a_decade(KNOWN[i % len(KNOWN)], random)
        kind = replace(kind, duty=drawn_duty(random, _VARIED))
    if kind.weak:
        effects = weakened(effects, kind, random)
    columns = hide(effects, kind.duty, kind.noise, seed=int(random.integers(2**31)))
    if kind.gaps:
        columns = with_gaps(columns, effects, random)
    experiment = _written_and_read(columns)
    if kind.stated is not None:
        experiment = replace(experiment, noise=_stated(experiment, kind))
    began = time.process_time()
    found = assess(experiment)
    seconds = time.process_time() - began
    truth = "+".join(sorted(effects))
    said = [fit.name for fit in (found.best, *found.rivals)] if found.word in ("named", "ambiguous") else []
    if kind.effects == 0:
        right = found.word == "adequate"
    elif kind.known:
        # What leaves no trace, as forced convection at rest, cannot be wrong.
        right = truth in said or (found.word == "adequate" and expected_gain(effects, kind) < _TRACE)
    else:
        right = found.word == "unknown"
    follow = kind.known and found.word == "ambiguous"
    followed, as_said = (
        _followed(found, experiment, effects, int(random.integers(2**31))) if follow else (None, None)
    )
    heldout = None
    if found.word == "named":
        scores = Scores(Problem(experiment), found.noise, found.best)
        measured = scores.rmse(scores.predict(found.best), True)
        heldout = None if measured is None else measured[0]
    return Trial(
        kind_name,
        i,
        tuple(sorted(effects)),
        tuple(effects[name] for name in sorted(effects)),
        found.word,
        tuple(sorted(found.best.key)) if said else (),
        tuple(said[1:]),
        found.search.lack_of_fit_p(found.best),
        right,
        found.word == "named" and not right,
        _covered(found, effects),
        heldout,
        followed,
        as_said,
        seconds,
    )


def _followed(
    found: Assessment, experiment: Experiment, effects: dict[str, float], seed: int
) -> tuple[bool | None, bool | None]:
    """Carry the next experiment out on the truth, and diagnose both runs together.

    Whether that names the truth, or says that nothing is wrong; and whether it does, or leaves beside the
    truth only what the proposal said that nothing tells from it. None where there was nothing to carry out.
    """
    from warmlink.orchestration.diagnosis.answer.next_experiment import next_experiment
    from warmlink.orchestration.diagnosis.data.experiment import together
    from warmlink.orchestration.diagnosis.fit.verdict import assess

    proposed = next_experiment(found, experiment)
    if proposed is None or not proposed.duty:
        return None, None
    again = assess(together([experiment, _written_and_read(hide(effects, proposed.duty, seed=seed))]))
    if not effects:
        return again.word == "adequate", again.word == "adequate"
    left = (
        {fit.name for fit in (again.best, *again.rivals)} if again.word in ("named", "ambiguous") else set()
    )
    truth = "+".join(sorted(effects))
    beside = left - {truth}
    right = truth in left and beside <= (TWINS if set(effects) & TWINS else set())
    alike = {frozenset(pair) for pair in proposed.alike}
    return right, right or (truth in left and all(frozenset((truth, each)) in alike for each in beside))


def _written_and_read(columns: dict[str, Any]) -> Experiment:
    from warmlink.orchestration.diagnosis.data.experiment import read_experiment

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        write_csv(columns, path)
        return read_experiment(path)


def _covered(found: Assessment, effects: dict[str, float]) -> tuple[bool, ...]:
    """Whether each hidden strength lies in its interval; empty where another model was best."""
    if found.best.key != set(effects):
        return ()
    fit = found.best
    deviations = np.sqrt(np.diag(fit.covariance()))
    result = []
    for freed, value, deviation in zip(fit.freed, fit.theta, deviations, strict=True):
        item = next((i for i in fit.items if freed in i.freed), None)
        if item is None:
            continue
        truth = effects[item.name]
        if item.cause.relative:
            truth *= freed.start
        elif item.name.endswith(":elongation"):
            truth *= 1e-5  # the strength of an offset is told in K; the camera's is 10 um a K
        result.append(bool(abs(value - truth) < 1.96 * deviation))
    return tuple(result)
