"""Which wandering is taken: the gain that each signal must bring, and the strongest of the likely ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import pytest

from warmlink.orchestration.diagnosis.fit import likeliest as module
from warmlink.orchestration.diagnosis.fit.likeliest import ROOMS, Integrated, likeliest
from warmlink.orchestration.diagnosis.fit.wandering import STILL, Wander

GAIN = 6.0
"""Of twice the log-likelihood, that each wandering signal must bring."""


@dataclass(frozen=True)
class OfNothing:
    """A fit without anything freed."""

    point: object = None
    items: tuple[object, ...] = ()
    freed: tuple[object, ...] = ()
    theta: tuple[float, ...] = ()


@pytest.mark.parametrize(
    ("wander", "signals"),
    [(STILL, 0), (Wander(room=0.1), 1), (Wander(heat=0.1), 1), (Wander(room=0.1, heat=0.1), 2)],
)
def test_each_signal_that_wanders_costs_the_same(
    wander: Wander, signals: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Near:
        def __init__(self, *given: object) -> None:
            pass

        def singles(self) -> list[object]:
            return []

        pairs = singles

        def proposals(self, *given: object) -> list[SimpleNamespace]:
            return [SimpleNamespace(chi2=40.0, items=()), SimpleNamespace(chi2=30.0, items=("a",))]

    monkeypatch.setattr(module, "Neighbours", Near)
    seen = Integrated.__new__(Integrated)
    search = SimpleNamespace(items=(), penalty=lambda items: 7.0 * len(items))
    vars(seen).update(search=search, fit=OfNothing(), _misfits={}, _point=lambda wander: (None, 2.0))
    assert seen.misfit(wander) == 30.0 + 7.0 + 2.0 + GAIN * signals


def chosen(misfits: Mapping[Wander, float], monkeypatch: pytest.MonkeyPatch) -> Wander:
    """What is taken of these, by minus twice their log-likelihood."""

    class Seen:
        def __init__(self, *given: object) -> None:
            self.responses, self.misfit = None, misfits.__getitem__

        def candidates(self) -> list[Wander]:
            return list(misfits)

    monkeypatch.setattr(module, "Integrated", Seen)
    monkeypatch.setattr(module, "Responses", lambda problem, values: None)
    problem = SimpleNamespace(values_by_run=lambda freed, theta: None)
    search = SimpleNamespace(fitter=SimpleNamespace(problem=problem))
    return likeliest(cast("Any", search), [cast("Any", OfNothing())])[0]


def test_of_rooms_that_are_about_as_likely_the_strongest_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    weak, strong, too_strong = (Wander(room=room) for room in (0.05, 0.1, 0.2))
    assert chosen({STILL: 20.0, weak: 0.0, strong: 2.9, too_strong: 3.1}, monkeypatch) == strong
    slow = Wander(room=0.05, memory=1800.0)
    assert chosen({STILL: 20.0, weak: 0.0, slow: 1.0}, monkeypatch) == slow, "it moves farther"
    other_heat = Wander(room=0.2, heat=0.1)
    assert chosen({STILL: 20.0, weak: 0.0, other_heat: 1.0}, monkeypatch) == weak


def test_no_room_is_taken_where_none_is_likelier_or_only_an_extraordinary_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert chosen({STILL: 0.0, Wander(room=0.1): 1.0}, monkeypatch) == STILL
    assert chosen({STILL: 20.0, Wander(room=ROOMS[-1]): 0.0, Wander(room=0.1): 2.0}, monkeypatch) == STILL
