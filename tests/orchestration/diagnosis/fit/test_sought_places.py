"""Numbers as a calibration seeks them: between 0 and 1, evenly or by their logarithm."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.fit.calibrated import _Sought


def sought(*bounds: tuple[float, float]) -> _Sought:
    return _Sought(cast(Any, None), [cast(Any, SimpleNamespace(lower=a, upper=b)) for a, b in bounds])


def test_wide_strengths_go_by_their_logarithm_and_all_else_evenly() -> None:
    found = sought((0.01, 100.0), (1.0, 3.0), (-5.0, 5.0))
    assert found.between(np.zeros(3)) == pytest.approx([0.01, 1.0, -5.0])
    assert found.between(np.full(3, 0.5)) == pytest.approx([1.0, 2.0, 0.0])
    assert found.between(np.ones(3)) == pytest.approx([100.0, 3.0, 5.0])


def test_places_undo_values() -> None:
    found = sought((0.01, 100.0), (1.0, 3.0), (-5.0, 5.0), (0.0, 1e6))
    for places in np.random.default_rng(1).uniform(size=(20, 4)):
        assert found._places(found.between(places)) == pytest.approx(places, abs=1e-12)
