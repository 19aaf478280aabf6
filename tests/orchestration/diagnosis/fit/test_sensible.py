"""What would only be misread: too few means of readings, and rows whose order is lost."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.fit import sensible
from warmlink.orchestration.diagnosis.fit.sensible import _disorder, refuse_senseless, refuse_too_short


def averaged(kept: int, heldout: bool = False) -> Any:
    """A problem of one run of 20 means, of which so many are fitted in the fuller of its two columns."""
    readings = np.full((20, 2), np.nan)
    readings[:kept, 0], readings[: kept // 2, 1] = 1.0, 1.0
    data = SimpleNamespace(readings=readings, fitted=np.ones(20, bool))
    run = SimpleNamespace(name="run", heldout=heldout)
    return cast("Any", SimpleNamespace(experiment=SimpleNamespace(runs=[run]), data=[data]))


def test_sixteen_means_of_one_column_are_enough_and_fifteen_are_not() -> None:
    refuse_too_short(averaged(16))
    with pytest.raises(InputError, match=r"run: no column keeps more than 15 readings .* at least 16"):
        refuse_too_short(averaged(15))
    refuse_too_short(averaged(3, heldout=True))


def test_disorder_is_near_0_of_a_smooth_course_and_near_1_of_rows_in_random_order() -> None:
    smooth = np.sin(np.linspace(0.0, 6.0, 400))
    shuffled = np.random.default_rng(4).permutation(smooth)
    assert _disorder(smooth) < 0.01
    assert _disorder(shuffled) == pytest.approx(1.0, abs=0.15)
    assert _disorder(np.where(np.arange(400) % 7 == 0, np.nan, smooth)) < 0.01, "empty cells count as nothing"
    assert _disorder(np.full(50, 3.0)) == 0.0


def measured(readings: np.ndarray, course: np.ndarray, unit: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """An experiment of one run, of one column in a unit, and what it would read as the system stands."""
    simulated = SimpleNamespace(neutral=[None], variables=["x"], predict=lambda *_: (course[:, None], None))
    fitted = np.ones(readings.size, bool)
    run = SimpleNamespace(name="run", heldout=False, fitted=fitted, readings={"x": readings})
    monkeypatch.setattr(sensible, "Problem", lambda experiment: simulated)
    monkeypatch.setattr(sensible, "names_of", lambda columns: {"x": "probe"})
    return SimpleNamespace(runs=[run], columns=(), rig=SimpleNamespace(unit=lambda name: unit))


def refused(experiment: Any) -> str:
    """Why an experiment is refused; empty if it is not."""
    try:
        refuse_senseless(experiment)
    except InputError as fault:
        return str(fault)
    return ""


@pytest.mark.parametrize(("unit", "least"), [("K", 1.0), ("m", 2e-6)])
def test_a_column_that_never_changes_is_dead_where_it_should_move(
    unit: str, least: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    for share, dead in ((1.1, True), (0.9, False)):
        course = np.linspace(0.0, share * least, 200)
        told = refused(measured(np.full(200, 7.0), course, unit, monkeypatch))
        assert ("column 'probe' never changes, while it should by about" in told) == dead


@pytest.mark.parametrize(("unit", "least"), [("K", 1.0), ("m", 5e-6)])
def test_rows_in_random_order_are_refused_where_they_jump_by_more_than_noise(
    unit: str, least: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    smooth = np.sin(np.linspace(0.0, 6.0, 400))
    shuffled = np.random.default_rng(8).permutation(smooth) / smooth.std()
    for share, wrong in ((1.1, True), (0.9, False)):
        told = refused(measured(share * least * shuffled, smooth, unit, monkeypatch))
        assert ("every reading that moves jumps from row to row (probe by" in told) == wrong
    assert not refused(measured(3 * least * shuffled, shuffled, unit, monkeypatch)), "it should jump"
