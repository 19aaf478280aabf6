"""All that was found in an experiment, whatever model is delivered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warmlink.orchestration.diagnosis.answer.doubtful import (
    beyond_noise,
    doubts_of,
    unchanging_inputs,
    understated,
)
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed, next_experiment
from warmlink.orchestration.diagnosis.answer.separation import stand_ins
from warmlink.orchestration.diagnosis.answer.slips import slips
from warmlink.orchestration.diagnosis.answer.unknown import Hint, MissingHeat, hint, missing_heat
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.candidates import Item
from warmlink.orchestration.diagnosis.fit.fitted import Wrong, followed_input
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, Word, fitted_part
from warmlink.orchestration.diagnosis.ladder.errors import good_enough, largest_errors
from warmlink.orchestration.diagnosis.ladder.judged import (
    CALIBRATED,
    CAUSES,
    NEAREST,
    UNCORRECTED,
    JudgedModels,
)
from warmlink.orchestration.diagnosis.ladder.parts import judged_by_parts
from warmlink.orchestration.diagnosis.ladder.plain import plainly_calibrated
from warmlink.orchestration.diagnosis.ladder.prediction import (
    MISSED,
    HeldOut,
    Predicted,
    Scores,
    verdict_after_holdout,
)
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder


@dataclass(frozen=True)
class Findings:
    """All that was found in an experiment by a search, whatever model is delivered in the end.

    `would_help` says which known values may be wrong.
    """

    experiment: Experiment
    assessment: Assessment
    would_help: tuple[str, ...] = ()

    @cached_property
    def scores(self) -> Scores:
        """Errors on the whole experiment, by which models are judged."""
        return Scores(Problem(self.experiment), self.assessment.noise, self.assessment.best)

    @cached_property
    def reported(self) -> Scores:
        """The same errors as people read them, in units of a noise that no cause was needed to find."""
        begun = self.assessment.begun
        return Scores(self.scores.problem, begun.noise, begun.fit)

    @cached_property
    def before(self) -> Predicted:
        """Readings by the uncorrected model."""
        return self.reported.predict(self.assessment.null)

    @cached_property
    def after(self) -> Predicted:
        """Readings by the model that was chosen."""
        best = self.assessment.best
        return self.scores.predict(best) if best.items else self.before

    @cached_property
    def members(self) -> tuple[Predicted, ...]:
        """Readings by the rivals of an ambiguous verdict."""
        return tuple(map(self.scores.predict, self.assessment.rivals))

    @cached_property
    def held_out(self) -> tuple[HeldOut | None, ...]:
        """Errors on held-out rows of the uncorrected model, the chosen one, and its rivals."""
        wander = self.assessment.fitter.wander
        models = (self.before, self.after, *self.members)
        return tuple(self.scores.held_out(each, wander) for each in models)

    @cached_property
    def verdict_and_reason(self) -> tuple[Word, str]:
        """Verdict after the gate on prediction, and what is to be said of it."""
        word, _ = found = self._gated
        if word == "empirical" and doubts_of(self.assessment):
            return "unknown", "No cause is established, as a column looks like something else."
        if word == "empirical" and self.judged.ladder.is_judged and self.judged.base == UNCORRECTED:
            told = "none of the models predicts the held-out rows better than the uncorrected one"
            return "unknown", f"No cause is established, and {told}."
        return found

    @cached_property
    def _gated(self) -> tuple[Word, str]:
        """The verdict by the held-out errors of the calibrated model and of the one with causes."""
        wanders = not self.assessment.fitter.wander.still
        fitted = self.scores.fitted(self.after) if wanders else 0.0  # else what is left was tested
        found = verdict_after_holdout(
            self.assessment.word, self.held_out[0], self.held_out[1:], fitted, self.beyond_noise
        )
        largest = largest_errors(self.scores.by_channel(self.before))
        return good_enough(largest, self.accuracy, found)

    @property
    def accuracy(self) -> dict[str, tuple[float, str]]:
        """Error that matters in SI, and the column's unit, by column name, as far as it is said."""
        given = self.experiment.accuracy
        return {c.name: (given[c.variable], c.unit) for c in self.experiment.columns if c.variable in given}

    @cached_property
    def beyond_noise(self) -> str:
        """A sentence where the chosen model leaves more than a noise stated or credible, else ""."""
        over = self.scores.beyond(self.after)
        if not over:
            return next(iter(understated(self.assessment.problem)), "")
        return beyond_noise(self.assessment, max(over, key=lambda name: over[name]), max(over.values()))

    @property
    def verdict(self) -> Word:
        """One of adequate, named, ambiguous, empirical, unknown."""
        return self.verdict_and_reason[0]

    @property
    def causes(self) -> tuple[Item, ...]:
        """Causes found, strongest first; of an ambiguous set the best member."""
        if self.verdict in ("adequate", "unknown"):
            return ()
        return tuple(sorted(self.assessment.best.items, key=lambda item: -self.strength(item)))

    def strength(self, item: Item) -> float:
        """Chi-square that the chosen model loses without a cause."""
        fit = self.assessment.best
        which = [i for i, f in enumerate(fit.freed) if f in item.freed]
        away = fit.theta[which] - np.array([fit.freed[i].start for i in which])
        covariance = fit.covariance()[np.ix_(which, which)]
        return float(away @ np.linalg.pinv(covariance, hermitian=True) @ away)

    @cached_property
    def ambiguous(self) -> list[list[str]]:
        """Sets of causes that the data cannot tell apart; a combination is written `a+b`."""
        if self.verdict != "ambiguous":
            return []
        return stand_ins(self.assessment.best.key, [fit.key for fit in self.assessment.rivals])

    @cached_property
    def proposed(self) -> Proposed | None:
        """The next experiment, where the data leave something open; none before a slip is mended."""
        is_open = self.verdict in ("ambiguous", "unknown", "empirical") and not self.slips
        return next_experiment(self.assessment, self.experiment) if is_open else None

    @property
    def wrong(self) -> Mapping[str, Wrong]:
        """What the simulation as it stands gets wrong, by column name."""
        return self.assessment.begun.wrong

    @cached_property
    def pattern(self) -> tuple[str, str] | None:
        """Columns of a reading and of the input that what is left of it follows in blocks, if it does."""
        problem, best = self.assessment.problem, self.assessment.best
        found = followed_input(self.assessment.fitter, best) if self.assessment.word == "unknown" else None
        if found is None:
            return None
        signal = self.experiment.rig.column_of(found.signal)
        return problem.names[problem.variables[found.channel]], signal

    @property
    def _unexplained(self) -> bool:
        """Whether no cause explains the fitted rows, and that matters to whoever asks."""
        return self.assessment.word == "unknown" and self.verdict != "adequate"

    @cached_property
    def hint(self) -> Hint | None:
        """What the missing heat looks like, where the cause is unknown."""
        return hint(self.assessment) if self._unexplained else None

    @cached_property
    def missing_heat(self) -> tuple[MissingHeat, ...]:
        """When and where heat is missing, where no cause is established."""
        return missing_heat(self.assessment) if self._unexplained else ()

    @cached_property
    def slips(self) -> tuple[str, ...]:
        """Sentences on likely slips of the log, the first thing to look at."""
        found = slips(self.experiment)
        if self.verdict == "adequate":
            return found.unlogged
        missing = found.lacking if self.verdict in ("unknown", "empirical") and not found.wrong else ()
        return (*found.certain, *missing)

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on columns that look stuck, swapped or in another unit, unless nothing is wrong."""
        stated = tuple(e for e in understated(self.assessment.problem) if e != self.verdict_and_reason[1])
        if self.verdict == "adequate":
            return stated
        asked = unchanging_inputs(self.experiment) if self.verdict == "unknown" else ()
        return (*doubts_of(self.assessment), *stated) or asked

    @cached_property
    def models(self) -> dict[str, Predicted]:
        """Models that may be delivered, by the name of their rung, the uncorrected one first."""
        found = {UNCORRECTED: self.before}
        if self.experiment.calibrated:
            null = self.assessment.null
            theta = np.array([v if f.added else f.start for f, v in null.values.items()])
            found = {UNCORRECTED: self.scores.predict(replace(null, theta=theta)), CALIBRATED: self.before}
        if self.assessment.best.items:
            explains = self.assessment.word != "unknown" and self._gated[0] not in ("adequate", "unknown")
            found[CAUSES if explains else NEAREST] = self.after
        if (plain := self._plainly_calibrated) is not None:
            found[CALIBRATED] = self.scores.predict(plain)
        return found

    @cached_property
    def _plainly_calibrated(self) -> Fit | None:
        """Usual parameters fitted, if held-out rows are off and nobody said what to calibrate."""
        nearest, experiment = self.held_out[1], self.experiment
        if nearest is None or nearest.in_noise <= MISSED or experiment.calibrated or experiment.rig.in_loop:
            return None
        return plainly_calibrated(self.assessment.problem)

    @cached_property
    def _refitted(self) -> tuple[Problem, Fit] | None:
        """All rows that no person held out, and the plain calibration fitted to them; None without one."""
        if self._plainly_calibrated is None:
            return None
        runs = tuple(replace(run, fit_until=np.inf) for run in self.experiment.runs)
        problem = Problem(fitted_part(replace(self.experiment, runs=runs)))
        fit = plainly_calibrated(problem)
        return None if fit is None else (problem, fit)

    @cached_property
    def refitted(self) -> Predicted | None:
        """The plain calibration fitted once more, to rows too that nobody asked to hold out.

        M. Stone, Journal of the Royal Statistical Society B 36 (1974) 111-147: rows that were held out to
        choose a model serve it once it is chosen. None if there is no such calibration.
        """
        return None if self._refitted is None else self.scores.predict(self._refitted[1])

    @cached_property
    def by_parts(self) -> Ladder | None:
        """The uncorrected model and its plain calibration, as they predict all parts of the log.

        None if there is no such calibration, or a person holds out whole runs, which judge it.
        """
        if self._refitted is None or any(run.heldout for run in self.experiment.runs):
            return None
        return judged_by_parts(self._refitted[0], self.assessment.null)

    @cached_property
    def judged(self) -> JudgedModels:
        """Models without an equation, as held-out rows judge them."""
        wander, asked = self.assessment.fitter.wander, bool(self.experiment.calibrated)
        return JudgedModels(self.scores, wander, self.models, self._gated[0], asked, self.by_parts)

    def units(self) -> dict[str, str]:
        """Unit of each measured column by its name, as the file has it."""
        return {c.name: c.unit for c in self.experiment.columns}
