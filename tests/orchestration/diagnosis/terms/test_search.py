"""Which sets of terms are fitted in the whole simulation, by linear scores that may be off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.terms import search
from warmlink.orchestration.diagnosis.terms.modelled import Chosen
from warmlink.orchestration.diagnosis.terms.search import FittedTerms, TermSearch

BARE = 5600.0


class Scored(TermSearch):
    """A search among models of one term, with given scores in linear approximation and in the simulation."""

    def __init__(self, linear: dict[str, float], simulated: dict[str, float]) -> None:
        self._linear, self._scores = linear, simulated
        self._kept: dict[Any, FittedTerms] = {}
        self._progress = lambda *_: None
        self.missing: Any = SimpleNamespace(residual=np.array([np.sqrt(BARE)]))

    def _screened(self, sets: Any, most: int) -> Any:
        return [self._fit(name) for name in self._linear] if len(sets[0].candidates) == 0 else []

    def _fit(self, name: str) -> Any:
        form = SimpleNamespace(about=name)
        return SimpleNamespace(
            candidates=(SimpleNamespace(form=form),), chi2=self._linear[name], name=name, switches=False
        )

    def _linear_score(self, fit: Any) -> float:
        return float(self._linear[fit.name])

    def _near(self, ranked: Any, more: float) -> Any:
        return [each for each in ranked if each.chi2 - ranked[0].chi2 < 20.0 + more]

    def _simulated(self, fit: Any, like: Any) -> FittedTerms:
        model: Any = SimpleNamespace(
            on_bound=False,
            fit=SimpleNamespace(chi2=self._scores[fit.name]),
            refitted=lambda: Chosen(fit.candidates, (1.0,), (1.0,)),
        )
        self._kept[fit.name] = FittedTerms(model, self._scores[fit.name], 0.5)
        return self._kept[fit.name]


def test_a_poor_linear_score_does_not_hide_a_term_that_explains_the_run() -> None:
    """A heater at its end stop: linear answers were off by a fifth of the gain, and a wrong cause named."""
    found = Scored({"radiation": 2943.0, "loss": 2964.0}, {"radiation": 2392.0, "loss": 2397.0})
    assert [each.score for each in found.run(bar=2402.0)] == [2392.0, 2397.0]


def test_what_gains_more_by_the_simulation_than_the_best_is_fitted_too() -> None:
    """Speed to the power 1.5 was given up for a dead zone that gained less, and a wrong cause named."""
    found = Scored({"dead zone": 3312.5, "power": 3318.3}, {"dead zone": 3202.3, "power": 3151.0})
    assert next(each.score for each in found.run(bar=3156.5)) == 3151.0


def test_a_term_that_is_idle_in_the_simulation_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Radiation alone had a poor linear score; with conduction, which gave next to nothing, it was said."""
    chi2 = {"radiation": 3170.0, "conduction": 5043.0}
    radiation, conduction = (SimpleNamespace(key=(name, "shaft"), numbers=2) for name in chi2)

    def modelled(chosen: Any, chi2: float) -> Any:
        return SimpleNamespace(
            on_bound=False,
            chosen=chosen,
            numbers=2 * len(chosen.candidates),
            fit=SimpleNamespace(chi2=chi2),
            fitter=None,
            refitted=lambda: chosen,
        )

    both: Any = Chosen((radiation, conduction), (-9.8, 0.3), (1.0, 1.0))  # type: ignore[arg-type]
    monkeypatch.setattr(
        search, "fitted", lambda _, chosen: modelled(chosen, chi2[chosen.candidates[0].key[0]])
    )
    monkeypatch.setattr(search, "lack_of_fit_p", lambda _, fit: 0.5 if fit.chi2 < 4000 else 1e-9)
    found = Scored({}, {})
    found.assessment = None  # type: ignore[assignment]
    found.missing = SimpleNamespace(fitter=SimpleNamespace(count=3174), residual=np.array([np.sqrt(BARE)]))
    found.library = []
    found._keep(modelled(both, 3212.0))
    found._leave_out()
    assert [set(each.model.chosen.key) for each in found.explaining] == [{radiation.key}, set(both.key)]


@pytest.mark.parametrize(("bar", "fitted"), [(100.0, []), (2000.0, ["first"]), (2390.0, ["first", "second"])])
def test_what_cannot_be_below_the_bar_is_not_simulated(bar: float, fitted: list[str]) -> None:
    found = Scored({"first": 2400.0, "second": 2401.0}, {"first": 2395.0, "second": 2396.0})
    found.run(bar)
    assert list(found._kept) == fitted
