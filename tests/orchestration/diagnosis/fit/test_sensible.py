"""What would only be misread: too few means of readings, and rows whose order is lost."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.fit.sensible import _disorder, refuse_too_short


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
