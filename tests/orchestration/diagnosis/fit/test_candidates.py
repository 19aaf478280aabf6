"""What fits may free, and between which bounds."""

from __future__ import annotations

from pathlib import Path

from tests.orchestration.diagnosis.fit import two_lumps
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.candidates import Candidates, Item


def items(folder: Path, more: str = "") -> dict[str, Item]:
    known = f"[known]\n{more}"
    path = two_lumps.experiment(folder, two_lumps.log(), {})
    path.write_text(path.read_text("utf-8").replace("[known]\n", known), "utf-8")
    return {each.name: each for each in Candidates(read([path])).items}


def test_a_share_of_a_known_zero_is_no_candidate(tmp_path: Path) -> None:
    """It had bounds of 0 W/K each, and the plain calibration ended in a traceback."""
    found = items(tmp_path)
    assert "joint_conductance" not in found
    assert "housing_heat_loss" in found
    for item in found.values():
        assert all(each.lower <= each.start <= each.upper and each.span > 0 for each in item.freed)


def test_a_known_value_beyond_the_usual_ones_is_within_its_bounds(tmp_path: Path) -> None:
    given = 2 * items(tmp_path)["standby_heat"].freed[0].upper
    found = items(tmp_path, f'"motor.standby_power" = "{given} W"\n')["standby_heat"].freed[0]
    assert found.lower <= found.start <= found.upper
