"""The cell that ages, and what is done about it."""

import pytest

import warmlink as wl
from benchmarks.six_months import aged, log, maintained


def test_what_was_found_is_designed_for_and_taken_out() -> None:
    cell = aged(2)
    known = {"motor.joint_conductance": 0.8649, "sensors.offset[3]": 0.1}
    done = maintained(cell, known)
    assert done["sensors.offset[3]"] == pytest.approx(0.02)
    nominal = wl.design(law="observer").parameters
    assert any(done[name] != value for name, value in nominal.items())
    assert set(maintained(cell, {})) == {"sensors.offset[3]"}


def test_a_log_has_what_a_diagnosis_needs() -> None:
    loop = wl.run("production_shift", "lag", stop="20 min")
    table = log(loop)
    assert table["elongation [um]"].notna().sum() > 5
    growth = loop.result["link.elongation"][::30] * 1e6
    assert (table["elongation [um]"] - growth).abs().max() < 3.0
    assert table["speed [rad/s]"].max() == loop.result["duty.speed"].max()
