"""A hidden cause is found in the joint that it is in, and nowhere else."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.documented import undescribed
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.program import arm
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.command_line.diagnose import diagnose
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.arm.diagnose import diagnose_arm
from warmlink.orchestration.diagnosis.arm.hide import hide_in_arm, possible_effects
from warmlink.orchestration.diagnosis.arm.measured import arm_experiments, is_arm_file
from warmlink.orchestration.diagnosis.practice.hide import write_csv
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.report.diagnosis import SSV, write_diagnoses

ELBOW = 3
RESISTANCE = 0.6


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = FmuStore("native")
    try:
        store.files(arm().blueprint.kinds | shipped("none").kinds)
    except InputError as fault:
        pytest.skip(str(fault))
    path = tmp_path_factory.mktemp("arm") / "arm.csv"
    write_csv(hide_in_arm({"joint_resistance": RESISTANCE}, ELBOW, store, seed=11), path)
    return path


@pytest.mark.slow
def test_a_cause_hidden_in_joint_3_is_named_as_joint_3s(run: Path, tmp_path: Path) -> None:
    experiments = arm_experiments(run)
    assert list(experiments) == [1, 2, 3, 4, 5, 6]
    found = diagnose_arm(experiments)
    assert found.at_fault == (ELBOW,)
    (cause,) = found.axes[ELBOW].causes
    assert cause.name == "joint_resistance"
    said = json_content(found.axes[ELBOW])["causes"][0]["parameters"]["motor.joint_resistance"]
    assert said["low95"] <= RESISTANCE <= said["high95"]
    for _ in range(2):  # a second time over the first
        write_diagnoses(found.by_name, found.to_json(SSV), tmp_path / "out")
    whole = json.loads((tmp_path / "out/diagnosis.json").read_text())
    assert whole["at_fault"] == ["axis3"]
    assert not undescribed("diagnosis.json", whole)
    assert (tmp_path / "out/axis3/report.html").is_file()
    assert "axis3  elbow       named       joint_resistance" in found.summary()


def test_only_what_differs_in_an_axis_enters_its_experiment(run: Path) -> None:
    experiments = arm_experiments(run)
    first, third, last = (experiments[i] for i in (1, 3, 6))
    assert first.known["motor.neighbour_conductance"] == 0.0
    assert "motor.neighbour_temperature" in third.runs[0].inputs
    assert "link.tip_sink_temperature" in third.runs[0].inputs
    assert "link.tip_conductance" not in last.known
    assert len(third.columns) == 6


def test_rows_stand_where_the_duty_cycle_changes(run: Path) -> None:
    table = pd.read_csv(run)
    gaps = np.diff(table["time [s]"])
    assert gaps.max() <= 10.0
    changed = np.diff(table["axis2.speed [rad/s]"]) != 0
    # Jobs last whole seconds, few of them tens.
    assert np.any(table["time [s]"].to_numpy()[1:][changed] % 10.0 != 0)


def test_files_of_the_arm_are_told_by_their_header(run: Path, tmp_path: Path) -> None:
    assert is_arm_file(run)
    other = tmp_path / "run.csv"
    other.write_text("time [s],shaft_temperature [degC]\n0,20\n")
    assert not is_arm_file(other)
    assert not is_arm_file(tmp_path / "absent.csv")


def test_a_missing_column_is_said(run: Path, tmp_path: Path) -> None:
    path = tmp_path / "arm.csv"
    pd.read_csv(run).drop(columns="axis4.shaft_temperature [degC]").to_csv(path, index=False)
    with pytest.raises(InputError, match=r"no column 'axis4.shaft_temperature \[degC\]'"):
        diagnose([path], out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_run_of_the_arm_stands_alone(run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a run of the whole arm cannot be combined with others"):
        diagnose([run, run], out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_no_axis_can_have_is_refused() -> None:
    store = FmuStore("native")
    assert {"joint_resistance", "friction_level", "radiation"} <= set(possible_effects())
    with pytest.raises(InputError, match="'sensor_lag:tip_temperature' cannot be hidden in an axis"):
        hide_in_arm({"sensor_lag:tip_temperature": 60.0}, 2, store)
    with pytest.raises(InputError, match="--axis 7: the arm has no such axis; choose 1 to 6"):
        hide_in_arm({"radiation": 0.6}, 7, store)
