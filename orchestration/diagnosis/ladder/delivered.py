"""What is delivered: the model that predicts the held-out rows best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warmlink.orchestration.diagnosis.ladder.judged import EQUATION, JudgedModels, is_usable
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.diagnosis.ladder.predictor import Predictor, predictor_of
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung

_MUCH = 0.5
"""Share of the delivered model's error from which a virtual measurement is worth having."""


@dataclass(frozen=True)
class Delivery:
    """The choice of the model to use from now on.

    Attributes
    ----------
    others : the models without an equation
    equations : models with an equation for the heat that is missing, which data cannot tell apart, best first
    told_apart : whether they explain the run better than causes do
    """

    others: JudgedModels
    equations: tuple[Predicted, ...] = ()
    told_apart: bool = True

    @cached_property
    def ladder(self) -> Ladder:
        """Models and the plainest fits, by what they get wrong in held-out rows."""
        ladder = self.others.ladder
        if not self.equations:
            return ladder
        readings, numbers = self.equations[0].readings, len(self.equations[0].fit.freed)
        return ladder.with_model(Rung(EQUATION, "simulation", readings, numbers, is_model=True))

    @cached_property
    def by_equation(self) -> bool:
        """Whether the model with the equation is delivered.

        Of two that predict alike it is the one that the fitted rows establish.
        """
        if not self.equations or not self.ladder.is_judged:
            return bool(self.equations) and self.told_apart
        other = self.others.name
        names = (EQUATION, other) if self.told_apart else (other, EQUATION)
        rungs = [self.ladder.named(each) for each in names]
        rungs = [each for each in rungs if each.name == other or not self.ladder.is_worse_in_growth(each)]
        return self.ladder.simplest_of_the_best(rungs).name == EQUATION

    @property
    def name(self) -> str:
        """Name of the rung that is delivered."""
        return EQUATION if self.by_equation else self.others.name

    @property
    def plain(self) -> Mapping[int, Rung]:
        """Plain fits that are delivered beside a model, by number of their channel."""
        return {} if self.by_equation else self.others.plain

    @property
    def remainder(self) -> Remainder | None:
        """The learnt remainder that is delivered, if one is."""
        return None if self.by_equation else self.others.remainder

    @property
    def model(self) -> str:
        """Name of the rung of the model that is delivered, what stands beside it aside."""
        return EQUATION if self.by_equation else self.others.model

    @property
    def adopted(self) -> Predicted:
        """The model that is delivered, with what stands beside it."""
        return self.equations[0] if self.by_equation else self.others.adopted

    @cached_property
    def predictor(self) -> Predictor | None:
        """The plain fits that are delivered as a component, if any are."""
        return self._component(self.plain, "Predictor", "Plain fits that foretell held-out runs best")

    @cached_property
    def virtual(self) -> Mapping[int, Rung]:
        """The plain fit by which thermometers tell the growth, by its channel, if it is worth having."""
        ladder, growth = self.ladder, self.ladder.growth
        if growth is None or not ladder.is_judged:
            return {}
        tried = [each for each in ladder.plain("virtual measurement") if is_usable(each, growth)]
        best = ladder.best_in(growth, tried, ladder.named(self.name))
        if best is None:
            return {}
        name = ladder.channels[growth]
        share = ladder.rms(best)[name] / ladder.rms(ladder.named(self.name)).get(name, np.inf)
        return {growth: best} if share < _MUCH else {}

    @cached_property
    def virtual_measurement(self) -> Predictor | None:
        """The growth by thermometers as a component, if that is worth having."""
        return self._component(self.virtual, "VirtualMeasurement", "The growth by what thermometers read")

    def _component(self, plain: Mapping[int, Rung], name: str, description: str) -> Predictor | None:
        if not plain:
            return None
        ladder = self.ladder
        fits = {
            channel: (rung.linear[channel], ladder.rms(rung)[ladder.channels[channel]])
            for channel, rung in plain.items()
        }
        return predictor_of(self.others.scores.problem, ladder.runs, fits, name, description)
