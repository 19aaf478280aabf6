"""The answer to an experiment: what was found, the model to use from now on, and what that says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.claims import Claim, claims
from warmlink.orchestration.diagnosis.answer.compensated import Compensated, feed_forwards, observers
from warmlink.orchestration.diagnosis.answer.findings import Findings
from warmlink.orchestration.diagnosis.fit.fitted import Wrong, what_is_wrong
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED, EQUATION, UNCORRECTED
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder

Answered = TypeVar("Answered")

_CLEARLY = 3.0
"""Times its rms error by which a model is clearly off."""


class Refusals(dict[str, str]):
    """Why an answer cannot be given, by its name."""

    def asked(self, name: str, answer: Callable[[], Answered]) -> Answered | None:
        """The answer; None if it cannot be given, and then the reason is noted."""
        try:
            return answer()
        except InputError as fault:
            self[name] = str(fault)
            return None


@dataclass(frozen=True)
class Diagnosis(Findings):
    """What was found in an experiment, the model to use from now on, and what that says."""

    @cached_property
    def remaining(self) -> Mapping[str, Wrong]:
        """What the chosen model still gets wrong, by column name."""
        best = self.assessment.best
        return what_is_wrong(self.assessment.fitter, best) if best.items else self.wrong

    @cached_property
    def left(self) -> Mapping[str, Wrong]:
        """What the model to use from now on gets wrong on fitted rows, by column name.

        Of causes that are not established it is what the uncorrected one does.
        """
        fit = self.adopted.fit
        if self.delivery.model == CALIBRATED and fit is not self.before.fit:
            return what_is_wrong(self.assessment.fitter, fit)
        return self.remaining if self.causes or self.delivered == EQUATION else self.wrong

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """What the reader should know of how the data were read and used."""
        return (*self.experiment.remarks, *self.scores.idle_adaptions(self.adopted))

    @cached_property
    def delivery(self) -> Delivery:
        """The choice of the model to use from now on, by the ladder."""
        return Delivery(self.judged)

    def with_delivery(self, delivery: Delivery, left: Mapping[str, Wrong]) -> Diagnosis:
        """The same findings with another delivery, whose model gets wrong what is `left`."""
        found = replace(self)
        known = {name: held for name, held in vars(self).items() if name in vars(Findings)}
        vars(found).update(known, delivery=delivery, remaining=left)
        return found

    @property
    def ladder(self) -> Ladder:
        """Models and the plainest fits, by what they get wrong in held-out rows."""
        return self.delivery.ladder

    @property
    def delivered(self) -> str:
        """Name of the rung whose model is to be used from now on: the one that predicts best."""
        return self.delivery.name

    @property
    def adopted(self) -> Predicted:
        """The model to use from now on, its remainder included if that is delivered."""
        return self.delivery.adopted

    @cached_property
    def handed_on(self) -> Predicted:
        """The model to use from now on as it is handed on: a plain calibration, once chosen, is refitted.

        How well it predicts is told of the one that was chosen. Under a learnt remainder it stays as it was.
        """
        refitted = self.refitted if self.delivery.model == CALIBRATED else None
        return self.adopted if refitted is None or self.delivery.remainder is not None else refitted

    @property
    def calibration(self) -> Fit:
        """The fit whose calibrated numbers are shown: those of the model to use, if it was calibrated."""
        return (self.before if self.delivery.model == UNCORRECTED else self.handed_on).fit

    @property
    def delivers(self) -> bool:
        """Whether there is a model to hand on: adequate, or better than the uncorrected one."""
        return self.verdict == "adequate" or self.delivered != UNCORRECTED

    @property
    def holds_within(self) -> float | None:
        """Difference in K of a thermometer from the model to use that is more than it leaves in its own log.

        Some times the largest rms error of any thermometer in rows that it was not fitted to; None without.
        """
        ladder, name = self.ladder, self.delivered
        if name == CALIBRATED and self.by_parts is not None:
            ladder = self.by_parts
        errors = ladder.rms(ladder.named(name)) if ladder.is_judged else {}
        unit = self.experiment.rig.unit
        warm = {c.name for c in self.experiment.columns if unit(c.variable) == "K"}
        off = [error for channel, error in errors.items() if channel in warm]
        return _CLEARLY * max(off) if off else None

    @cached_property
    def feed_forward(self) -> tuple[Compensated, Compensated] | None:
        """Largest error of the model as a feed-forward, before and after."""
        models = self.before, self.adopted
        return self._refused.asked("feed_forward", lambda: feed_forwards(self.scores.problem, *models))

    @cached_property
    def observer(self) -> tuple[Compensated, Compensated] | None:
        """Largest error of the observer designed on the model, before and after."""
        models = self.before, self.adopted
        return self._refused.asked("observer", lambda: observers(self.scores.problem, *models))

    @cached_property
    def claims(self) -> tuple[Claim, ...]:
        """What the model to use from now on says of the standard duty cycles."""
        return self._refused.asked("claims", self._claims) or ()

    def _claims(self) -> tuple[Claim, ...]:
        by_causes = self.members if self.verdict == "ambiguous" else ()
        alike = self.delivery.equations[1:] if self.delivered == EQUATION else by_causes
        return claims(self.experiment, self.assessment, (self.handed_on, *alike), self.left)

    @cached_property
    def unanswered(self) -> Mapping[str, str]:
        """Why there is no feed-forward, no observer or no claim, a sentence each."""
        for part in ("feed_forward", "observer", "claims"):
            getattr(self, part)
        return dict(self._refused)

    @cached_property
    def _refused(self) -> Refusals:
        return Refusals()
