"""Parameters of a law as start values, and as a parameter set that gives the same again."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.law_values import start_values_of, write_law_values
from warmlink.orchestration.system.ssp.parameter_values import read_ssv


def test_vectors_become_elements() -> None:
    found = start_values_of({"gain": 2e-6, "sensor_std": [0.1, 0.2]})
    assert found == {
        "compensator.gain": 2e-6,
        "compensator.sensor_std[1]": 0.1,
        "compensator.sensor_std[2]": 0.2,
    }


def test_a_parameter_set_holds_values_and_units(tmp_path: Path) -> None:
    write_law_values("lag", {"gain": 2e-6, "time_constant": 900.0}, tmp_path / "law.ssv", "lag", "a bench")
    found = read_ssv(tmp_path / "law.ssv")
    assert {name: each.value for name, each in found.items()} == {"gain": 2e-6, "time_constant": 900.0}
    assert {name: each.unit.name for name, each in found.items() if each.unit} == {
        "gain": "m/W",
        "time_constant": "s",
    }


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    (tmp_path / "none").write_text("a file, and no folder", "utf-8")
    with pytest.raises(InputError, match=r"law\.ssv: cannot be written .*choose another `out`"):
        write_law_values("lag", {"gain": 2e-6}, tmp_path / "none" / "law.ssv", "lag", "a bench")
