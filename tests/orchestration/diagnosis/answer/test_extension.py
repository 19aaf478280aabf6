"""The extended model's values are taken by every command."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.answer.extension import extended_values
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.inputs import with_inputs
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.hide import STILL, hide, write_csv
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.system.ssp.parameter_values import write_ssv

KNOWN = """
system = "WarmupCell"
[known]
"motor.ambient_temperature" = "5 degC"
"motor.joint_conductance" = "2.5 W/K"
[[run]]
data = "run.csv"
"""


def test_a_known_input_is_no_value_of_the_extended_model(tmp_path: Path) -> None:
    """Every command refused the file, since the duty cycle says how warm the room is."""
    measured = hide({}, STILL, seed=1)
    write_csv({name: v for name, v in measured.items() if "ambient" not in name}, tmp_path / "run.csv")
    (tmp_path / "known.toml").write_text(KNOWN, "utf-8")
    experiment = with_inputs(read_experiment(tmp_path / "known.toml"))
    nothing: Any = SimpleNamespace(freed=(), theta=())
    values = extended_values(Problem(experiment), nothing)
    write_ssv(values, tmp_path / "extended.ssv")
    asked = changed(load_scenario("continuous"), parameters=tmp_path / "extended.ssv").values()
    assert asked["motor"]["joint_conductance"] == pytest.approx(2.5)
    assert "motor.ambient_temperature" not in values
