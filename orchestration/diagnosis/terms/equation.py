"""What a diagnosis comes to with an equation for missing heat: what to use, and what to measure next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.extension import extended_values
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.fit.fitted import what_is_wrong
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.judged import EQUATION
from warmlink.orchestration.diagnosis.terms.discovery import Discovery, discover
from warmlink.orchestration.diagnosis.terms.modelled import places_of, with_equation
from warmlink.orchestration.diagnosis.terms.next_experiment import Rival, next_for
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.progress import Progress, unseen

MOST_ALIKE = 4
"""Equations of a set that the words list, and that widen what is foreseen."""


@dataclass(frozen=True)
class Equation:
    """A diagnosis whose ladder has what was found of an equation for missing heat."""

    diagnosis: Diagnosis
    discovery: Discovery

    @property
    def extends(self) -> bool:
        """Whether the model to use from now on, which is the extended one, is that with the equation."""
        return self.diagnosis.delivered == EQUATION

    @cached_property
    def proposed(self) -> Proposed | None:
        """The duty cycle that tells the equations of a set apart; None for a single one or none."""
        if not self.discovery.found:
            return None
        experiment, assessment = self.diagnosis.experiment, self.diagnosis.assessment
        models = [each.model for each in self.discovery.members]
        rivals = [Rival(with_equation(experiment, each.chosen), each.fit) for each in models]
        by_causes = [Rival(experiment, assessment.best)] if self.discovery.causes else []
        return next_for([*rivals[:1], *by_causes, *rivals[1:]], assessment)

    @cached_property
    def held_out(self) -> dict[str, tuple[float, float]]:
        """Held-out error in SI by channel, as the model stands and with the best equation."""
        ladder = self.diagnosis.ladder
        if not self.discovery.found or not ladder.is_judged:
            return {}
        before, after = ladder.rms(ladder.rungs[0]), ladder.rms(ladder.named(EQUATION))
        return {name: (before[name], after[name]) for name in before if name in after}

    @property
    def leads(self) -> bool:
        """Whether it is the first thing to say: it explains the run, or no cause does."""
        return self.extends or self.diagnosis.verdict in ("unknown", "empirical")

    @property
    def extended(self) -> tuple[Rig, Mapping[str, float]]:
        """The machine with the terms of the best equation to be wired in, and its values in SI."""
        model, rig = self.discovery.best.model, self.diagnosis.experiment.rig
        paths = {**rig.paths, **model.refitted().terms(rig)}
        return replace(rig, paths=paths), extended_values(model.problem, model.fit)


def is_due(diagnosis: Diagnosis, discover: bool | None) -> bool:
    """Whether to look for an equation: if that was asked, else where no cause is established."""
    if discover is not None:
        return discover
    rig = diagnosis.experiment.rig
    is_open = diagnosis.verdict in ("unknown", "empirical") and not diagnosis.slips
    return is_open and not rig.in_loop and bool(places_of(rig))


def searched(diagnosis: Diagnosis, progress: Progress = unseen) -> Discovery:
    """What a search for the heat that a diagnosed model lacks comes to."""
    return discover(
        diagnosis.assessment,
        diagnosis.verdict,
        diagnosis.experiment,
        diagnosis.scores,
        diagnosis.held_out[0],
        progress,
    )


def discovered(diagnosis: Diagnosis, progress: Progress = unseen) -> Equation:
    """What is found of the heat that a diagnosed model lacks, and the experiment to make next.

    The diagnosis of what is returned has the equations on its ladder.
    """
    found = searched(diagnosis, progress)
    if found.found:
        equations = tuple(each.predicted for each in found.foretold[:MOST_ALIKE])
        delivery, best = Delivery(diagnosis.judged, equations, not found.causes), found.best.model
        left = what_is_wrong(best.fitter, best.fit) if delivery.by_equation else diagnosis.remaining
        diagnosis = diagnosis.with_delivery(delivery, left)
    equation = Equation(diagnosis, found)
    progress("terms: next experiment", 0.95)
    _ = equation.proposed
    return equation
