"""What an unknown cause looks like, and answers that a machine does not allow, each rule by itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from warmlink.orchestration.diagnosis.answer.diagnosis import Refusals
from warmlink.orchestration.diagnosis.answer.growth import growth_of
from warmlink.orchestration.diagnosis.answer.unknown import Hint, MissingHeat, _means, _selected


def problem(growth: dict[str, float], measured: tuple[str, ...]) -> Any:
    machine = SimpleNamespace(name="Gantry", growth=growth)
    rig = SimpleNamespace(machine=machine, unit=lambda name: "m" if "elongation" in name else "K")
    return cast(Any, SimpleNamespace(experiment=SimpleNamespace(rig=rig), variables=measured))


def test_growth_is_the_weighted_sum_of_what_was_measured() -> None:
    found = growth_of(
        problem({"y.elongation": 2.0, "x.elongation": -1.0}, ("x.elongation", "t", "y.elongation"))
    )
    assert found.channels == (2, 0)
    assert found(np.array([[1.0, 9.0, 3.0], [2.0, 9.0, 5.0]])).tolist() == [5.0, 8.0]


def test_growth_that_nothing_says_or_nobody_measured_is_refused_and_noted() -> None:
    refused = Refusals()
    assert refused.asked("claims", lambda: growth_of(problem({}, ("x.elongation",)))) is None
    other = problem({"x.elongation": 1.0}, ("y.elongation",))
    assert refused.asked("observer", lambda: growth_of(other)) is None
    assert refused.asked("feed_forward", lambda: growth_of(problem({}, ("t",)))) is None
    assert refused.asked("next", lambda: 7) == 7
    assert "nothing says which growth" in refused["claims"]
    assert "nobody measured x.elongation" in refused["observer"]
    assert "no growth was measured" in refused["feed_forward"]
    assert refused.keys() == {"claims", "observer", "feed_forward"}
    with pytest.raises(ZeroDivisionError):
        refused.asked("a fault of ours", lambda: 1 // 0)


def test_terms_are_taken_while_each_explains_a_good_part() -> None:
    random = np.random.default_rng(1)
    table = pd.DataFrame(random.normal(size=(80, 3)), columns=["speed", "torque squared", "a constant heat"])
    target = (
        2.0 * table["speed"].to_numpy() - 3.0 * table["torque squared"].to_numpy() + random.normal(0, 0.1, 80)
    )
    chosen, share = _selected(target, table)
    assert [*chosen] == ["torque squared", "speed"]
    assert [*chosen.values()] == pytest.approx([-3.0, 2.0], abs=0.05)
    assert share > 0.99
    alone = 2.0 * table["speed"].to_numpy() + random.normal(0, 0.1, 80)
    assert [*_selected(alone, table)[0]] == ["speed"]
    assert _selected(random.normal(size=80), table)[0] == {}
    assert _selected(np.zeros(80), table) == ({}, 0.0)


def test_empty_stretches_take_the_course_between_their_neighbours() -> None:
    edges = np.array([0.0, 300.0, 600.0, 900.0])
    found = _means(np.array([0.0, 100.0, 650.0, 1000.0]), np.array([1.0, 3.0, 6.0, 8.0]), edges)
    assert found.tolist() == [2.0, 4.0, 6.0, 8.0]


def test_sentences_say_how_much_and_when() -> None:
    looks = ({"term": "speed squared", "coefficient": 1e-4}, {"term": "torque", "coefficient": 1e-3})
    assert Hint("base", looks, 0.834).sentence == (
        "what is missing in base looks like speed squared and torque (83 % of its course)."
    )
    assert "no single physical term" in Hint("base", (), 0.0).sentence
    heat = MissingHeat("run", np.array([0.0, 600.0, 1200.0]), np.array([1.0, -4.0, 2.0]), np.full(3, 0.5))
    assert (
        heat.sentence
        == "heat into the shaft would have to be 4 W less at 10 min of run (95 %: within 0.98 W)."
    )
