"""Residuals that follow an input in blocks are no noise, however fast the blocks are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.fit.two_lumps import BOUNDS, experiment, log
from warmlink.orchestration.diagnosis.data.experiment import calibrating
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.fitted import UNEXPLAINED, _Left, followed_input, lack_of_fit_p
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess


def assessed(folder: Path, blocks: float, seed: int) -> Assessment:
    """A calibration of readings with noise of 0.08 K, and blocks that follow the current."""
    table = log(7200.0, 150.0, 10.0)
    random = np.random.default_rng(seed)
    on = np.where(table["current [A]"] > 0, 1.0, -1.0)
    table["wind [degC]"] += random.normal(0, 0.06, len(table)) + blocks * on
    known = {
        "winding_heat_capacity": "60 J/K",
        "shaft_heat_capacity": "400 J/K",
        "winding_conductance": "2 W/K",
    }
    more = "\n".join(f'"motor.{name}" = "{value}"' for name, value in known.items())
    only = {"motor.housing_conductance": BOUNDS["motor.housing_conductance"]}
    return assess(calibrating(read([experiment(folder, table, only, more)])))


@pytest.mark.parametrize("seed", range(3))
def test_noise_follows_nothing(tmp_path: Path, seed: int) -> None:
    found = assessed(tmp_path, 0.0, seed)
    assert found.word == "adequate"
    assert followed_input(found.fitter, found.best) is None


def test_blocks_that_follow_the_current_are_seen_and_said(tmp_path: Path) -> None:
    found = assessed(tmp_path, 0.11, 0)
    left = followed_input(found.fitter, found.best)
    assert left is not None
    assert left.signal == "motor.current"
    assert lack_of_fit_p(found.fitter, found.best) < UNEXPLAINED
    assert found.word == "unknown"
    assert (
        _Left(found.fitter, found.best).of_slow_courses() > UNEXPLAINED
    )  # which alone would have let it pass
