"""An observer for plants that warmlink did not make, in closed loop, in duty cycles that no run had."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import warmlink as wl
from benchmarks.foreign_observers import judged, of_plant
from benchmarks.foreign_plants import PLANTS, SWAYING, screw
from warmlink.fmus.errors import InputError

CELL = """
duty = "random_jobs"
stop_time = "2 h"
[parameters]
"motor.joint_conductance" = "2 W/K"
"link.length" = "400 mm"
"link.tip_position" = "380 mm"
[sensors]
noise = "0.1 K"
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTS)
def test_it_removes_nine_tenths_and_knows_how_well(name: str, tmp_path: Path) -> None:
    try:
        PLANTS[name].made(tmp_path)
    except InputError as absent:
        pytest.skip(str(absent))
    found = of_plant(name, PLANTS[name], tmp_path, ("heavy_payload", "random_jobs"))
    for each, line in zip(found["linear_observer"], found["regression"], strict=True):
        assert each.removed >= 0.9
        assert each.inside >= 0.9
        assert each.rms < line.rms


@pytest.mark.slow
def test_growth_that_nothing_shows_is_refused(tmp_path: Path) -> None:
    plant = replace(PLANTS["ball screw"], made=partial(screw, source=SWAYING))
    with pytest.raises(InputError, match=r"base and the duty do not show its growth: the law would"):
        wl.design(plant.written("swaying", tmp_path), "linear_observer", ["base"])


@pytest.mark.slow
def test_our_own_cell_gets_one_as_well(tmp_path: Path) -> None:
    """With other parameters than those of what ships, which a run then does not doubt."""
    cell = tmp_path / "cell.toml"
    cell.write_text(CELL, "utf-8")
    wl.design(cell, "linear_observer").write(tmp_path / "law.ssv")
    outcome = wl.run(cell, "linear_observer", parameters=tmp_path / "law.ssv")
    assert judged(outcome).removed >= 0.9
    assert outcome.advice is None
    shipped = wl.run(cell, "linear_observer", stop="1 min")
    assert "linear_observer was designed for another cell" in str(shipped.advice)


def test_it_asks_for_a_duty_cycle_and_roles(tmp_path: Path) -> None:
    (tmp_path / "plain.ssp").touch()
    with pytest.raises(InputError, match=r"needs a duty cycle, and roles.*name a scenario file"):
        wl.design(tmp_path / "plain.ssp", "linear_observer")
