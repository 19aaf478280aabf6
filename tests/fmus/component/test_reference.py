"""The tight integration: what its phases mean."""

from dataclasses import replace

import numpy as np
import pytest

from warmlink.fmus.component.reference import Phase, Trajectory, integrate
from warmlink.fmus.plant import demand, plant

RECORD = ["link.tip_temperature", "link.elongation"]
WORK, REST = demand(60.0, 3.43, 2.5), demand(60.0, 0.0, 0.5)


def ran(*phases: Phase) -> Trajectory:
    return integrate(plant(), phases, RECORD, every=20.0, tolerance=1e-7)


def test_a_phase_object_that_comes_again_is_a_phase_like_any_other() -> None:
    again, apart = ran(WORK, REST, WORK), ran(WORK, REST, replace(WORK))
    np.testing.assert_array_equal(again.time, 20.0 * np.arange(10))
    for name in RECORD:
        np.testing.assert_array_equal(again.values[name], apart.values[name])


def test_a_phase_cut_in_two_changes_nothing() -> None:
    half = replace(WORK, duration=30.0)
    whole, halves = (
        integrate(plant(), p, RECORD, every=10.0, tolerance=1e-8) for p in ((WORK,), (half, half))
    )
    np.testing.assert_array_equal(whole.time, halves.time)
    assert halves.values["link.elongation"] == pytest.approx(whole.values["link.elongation"], abs=1e-12)


def test_a_phase_that_is_not_recorded_to_its_end_is_refused() -> None:
    """It would last as long as the next multiple."""
    with pytest.raises(ValueError, match="a phase of 50 s is no multiple of 20 s"):
        ran(WORK, replace(REST, duration=50.0))
