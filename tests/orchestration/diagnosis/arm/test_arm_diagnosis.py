"""A hidden cause is found in the joint that it is in, and nowhere else."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
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
from warmlink.orchestration.diagnosis.arm.measured import arm_experiments, is_arm_file, over_steps, smoothed
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.by_fmus import Hidden
from warmlink.orchestration.diagnosis.practice.hide import write_csv
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.report.diagnosis import SSV, write_diagnoses
from warmlink.orchestration.scenarios.scenario import Scenario

ELBOW = 3
RESISTANCE = 0.6
NEVER = np.array([])
LONG_ENOUGH = 4800.0
"""s, a third of the run."""


@pytest.fixture(scope="module")
def store() -> FmuStore:
    store = FmuStore("native")
    try:
        store.files(arm().kinds | shipped("none").kinds)
    except InputError as fault:
        pytest.skip(str(fault))
    return store


@pytest.fixture(scope="module")
def run(store: FmuStore, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("arm") / "arm.csv"
    write_csv(hide_in_arm({"joint_resistance": RESISTANCE}, ELBOW, store, seed=11), path)
    return path


@pytest.fixture(scope="module")
def experiments(run: Path) -> Mapping[int, Experiment]:
    return arm_experiments(run)


@pytest.mark.slow
def test_a_cause_hidden_in_joint_3_is_named_as_joint_3s(run: Path, tmp_path: Path) -> None:
    table = pd.read_csv(run)
    table[table["time [s]"] <= LONG_ENOUGH].to_csv(tmp_path / "arm.csv", index=False)
    experiments = arm_experiments(tmp_path / "arm.csv")
    assert list(experiments) == [1, 2, 3, 4, 5, 6]
    found = diagnose_arm(experiments)
    assert found.at_fault == (ELBOW,)
    (cause,) = found.axes[ELBOW].causes
    assert cause.name == "joint_resistance"
    said = json_content(found.axes[ELBOW])["causes"][0]["parameters"]["motor.joint_resistance"]
    assert said["low95"] <= RESISTANCE <= said["high95"]
    first = {"axis3": found.by_name["axis3"]}
    for written in (first, found.by_name):  # the second time over the first
        write_diagnoses(written, found.to_json(SSV), tmp_path / "out")
    whole = json.loads((tmp_path / "out/diagnosis.json").read_text())
    assert whole["at_fault"] == ["axis3"]
    assert not undescribed("diagnosis.json", whole)
    assert (tmp_path / "out/axis3/report.html").is_file()
    assert "axis3  elbow       named       joint_resistance" in found.summary()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [21, 59])
def test_the_noise_of_a_neighbours_readings_is_no_cause(store: FmuStore, tmp_path: Path, seed: int) -> None:
    """It drives the last axis, whose shaft is light, and had been called heat at standby, or warmer air."""
    path = tmp_path / "arm.csv"
    write_csv(hide_in_arm({"joint_resistance": RESISTANCE}, ELBOW, store, seed=seed), path)
    assert diagnose_arm(arm_experiments(path), [6]).at_fault == ()


@pytest.mark.slow
@pytest.mark.parametrize("number", [4, 6])
def test_what_the_noise_of_neighbours_does_is_known(
    experiments: Mapping[int, Experiment], number: int
) -> None:
    """Its expected square, against readings that are simulated with draws of it."""
    experiment = experiments[number]
    (measured,) = experiment.runs
    assert set(measured.scatter) == {"motor.neighbour_temperature", "link.tip_sink_temperature"} & {
        *measured.inputs
    }
    assert [*measured.scatter.values()] == pytest.approx([0.08] * len(measured.scatter), rel=0.1)
    problem = Problem(experiment)
    expected = np.sum(problem.scattered[0] ** 2, axis=(0, 2))
    plain, _ = problem.predict(0, problem.neutral[0])
    random, found = np.random.default_rng(3), []
    for _ in range(10):
        noise = {
            name: over_steps(smoothed(measured.time, random.normal(0.0, sigma, measured.time.size), NEVER))
            for name, sigma in measured.scatter.items()
        }
        inputs = {name: values + noise.get(name, 0.0) for name, values in measured.inputs.items()}
        drawn = Problem(replace(experiment, runs=(replace(measured, inputs=inputs),)))
        found.append(np.sum((drawn.predict(0, drawn.neutral[0])[0] - plain) ** 2, axis=0))
    assert np.mean(found, axis=0) == pytest.approx(expected, rel=0.35)


def test_only_what_differs_in_an_axis_enters_its_experiment(experiments: Mapping[int, Experiment]) -> None:
    first, third, last = (experiments[i] for i in (1, 3, 6))
    assert first.known["motor.neighbour_conductance"] == 0.0
    assert "motor.neighbour_temperature" in third.runs[0].inputs
    assert "link.tip_sink_temperature" in third.runs[0].inputs
    assert "link.tip_conductance" not in last.known
    assert len(third.columns) == 6


def test_rows_do_not_know_when_a_duty_cycle_changes(run: Path) -> None:
    """There was one more at each change, as no logger has it."""
    spacing = np.diff(pd.read_csv(run)["time [s]"])
    assert 10.0 <= spacing[0] < 20.0
    assert np.all(spacing[1:] == 10.0)


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


def test_a_neighbour_is_interpolated_where_it_was_not_read(
    experiments: Mapping[int, Experiment], run: Path, tmp_path: Path
) -> None:
    """Its last reading had been held, as what a duty cycle asks for is."""
    table = pd.read_csv(run)
    for header in ("axis3.tip_temperature [degC]", "axis5.shaft_temperature [degC]"):
        table.loc[np.arange(len(table)) % 20 != 5, header] = np.nan
    table.columns = [each.replace(" [degC]", " (C)") for each in table.columns]
    table.to_csv(tmp_path / "arm.csv", index=False)
    dense, sparse = (each[4].runs[0].inputs for each in (experiments, arm_experiments(tmp_path / "arm.csv")))
    for name in ("motor.neighbour_temperature", "link.tip_sink_temperature"):
        away = sparse[name] - dense[name]
        assert abs(np.mean(away)) < 0.02, "K"
        assert np.std(away) < 0.15, "K"


def test_a_neighbour_that_was_never_read_is_said(run: Path, tmp_path: Path) -> None:
    table = pd.read_csv(run)
    table["axis3.tip_temperature [degC]"] = np.nan
    table.to_csv(tmp_path / "arm.csv", index=False)
    with pytest.raises(InputError, match=r"column 'axis3.tip_temperature \[degC\]'.* is empty"):
        arm_experiments(tmp_path / "arm.csv")


def test_a_run_of_the_arm_stands_alone(run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a run of the whole arm cannot be combined with others"):
        diagnose([run, run], out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_no_axis_can_have_is_refused() -> None:
    store = FmuStore("native")
    assert {"joint_resistance", "friction_level", "radiation"} <= set(possible_effects())
    with pytest.raises(InputError, match="'sensor_lag:tip_temperature' cannot be hidden in an axis"):
        hide_in_arm({"sensor_lag:tip_temperature": 60.0}, 2, store)
    with pytest.raises(InputError, match="axis=7: the arm has no such axis; choose 1 to 6"):
        hide_in_arm({"radiation": 0.6}, 7, store)


def test_a_difference_is_added_to_what_an_axis_starts_from(
    store: FmuStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A start 3 K above the room's was a start at 3 K."""
    found: dict[str, float] = {}

    class EnoughError(Exception):
        pass

    def recorded(scenario: Scenario, store: FmuStore, names: object, hidden: Hidden, step: float) -> None:
        found.update(hidden(scenario.system(scenario.files(store))))
        raise EnoughError

    monkeypatch.setattr("warmlink.orchestration.diagnosis.arm.hide.recorded", recorded)
    with pytest.raises(EnoughError):
        hide_in_arm({"start_temperature": 3.0, "conductivity": 0.5}, ELBOW, store)
    assert found["axis3.link.initial_temperature"] == pytest.approx(298.15)
    assert 0 < found["axis3.link.conductivity"] < 300
