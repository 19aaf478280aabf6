"""Readings that come late or early against inputs are told by how much, without any model."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.data.clocks import shift
from warmlink.orchestration.diagnosis.data.measured import Run

TIME = np.arange(0.0, 14400.0, 10.0)
HEAT = np.where(np.random.default_rng(5).random(TIME.size // 60) < 0.5, 40.0, 0.0).repeat(60)


def run_late_by(late: float, noise: float = 0.01) -> Run:
    """A lump of 800 J/K with 0.5 W/K to its surroundings, read `late` s after it was so."""
    step, rise, course = 1.0, 0.0, []
    times = np.arange(-1200.0, TIME[-1] + 1200.0, step)
    for time in times:
        course.append(rise)
        heat = HEAT[int(np.clip(time // 10, 0, HEAT.size - 1))]
        rise += step * (heat - 0.5 * rise) / 800.0
    read = np.interp(TIME - late, times, course)
    read += np.random.default_rng(6).normal(0.0, noise, TIME.size)
    return Run("run", TIME, {}, {"lump": 295.15 + read})


@pytest.mark.parametrize("late", [300.0, -240.0])
def test_the_shift_is_found_to_within_a_block(late: float) -> None:
    found = shift(run_late_by(late), ["lump"], [HEAT])
    assert found is not None
    assert found[0] == pytest.approx(late, abs=40.0)
    assert found[1] == "lump"


def test_readings_that_come_in_time_have_none() -> None:
    assert shift(run_late_by(0.0), ["lump"], [HEAT]) is None


def test_nothing_is_told_of_what_no_input_explains() -> None:
    run = run_late_by(0.0)
    walk = 295.15 + np.cumsum(np.random.default_rng(7).normal(0.0, 0.1, TIME.size))
    assert shift(Run("run", TIME, {}, {"lump": walk}), ["lump"], [HEAT]) is None
    assert shift(run, ["lump"], []) is None, "no heat"
    short = Run("run", TIME[:40], {}, {"lump": run.readings["lump"][:40]})
    assert shift(short, ["lump"], [HEAT[:40]]) is None, "too short"
