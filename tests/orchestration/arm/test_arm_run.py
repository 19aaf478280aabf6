"""The arm in closed loop: what the observers remove, where the error comes from, what the report shows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.command import exit_code, refused
from tests.documented import undescribed
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.chain import arm_values
from warmlink.orchestration.arm.errors import ArmErrors, sensitivities, workspace
from warmlink.orchestration.arm.program import DESIGNED
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.load import load_scenario, names_on, read_scenario
from warmlink.orchestration.closed_loop.outcome import ClosedLoop, run_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.roles import Sensors
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.compare import plan, run_comparison, write_csv
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.workers import FmuSet

HOUR = 3600.0


def shortened(name: str, stop_time: float) -> Scenario:
    scenario = load_scenario(name)
    return replace(scenario, duty=scenario.duty.until(stop_time))


@pytest.fixture(scope="module")
def outcome(fmu_store: FmuStore) -> ClosedLoop:
    """An hour of the fastest program, with the thermometers where they tell least."""
    scenario = shortened("six_axis_iso_9283", HOUR)
    scenario = replace(scenario, sensors=Sensors(used=("base",)), step_size=2.0)
    return run_scenario(scenario, fmu_store)


@pytest.mark.parametrize("name", names_on("SixAxisArm"))
def test_observers_remove_nine_tenths_in_every_program(name: str, fmu_store: FmuStore) -> None:
    """From a cold start, one thermometer for each joint with 0.1 K of noise; below 30 um throughout.

    In steps of 10 s, in which the observers still sample each second.
    """
    scenario = load_scenario(name)
    record = [f"kinematics.{each}" for each in ("error_norm", "uncompensated_error_norm")]
    system = scenario.system(scenario.files(fmu_store))
    result = simulate(system, scenario.stop_time, 10.0, GaussSeidel(), record=record)
    assert result.status == "completed"
    before, after = (float(result[each].max()) for each in reversed(record))
    assert before > 30e-6
    assert after < 30e-6
    assert after < 0.1 * before


def test_errors_are_those_of_the_kinematics_component(outcome: ClosedLoop) -> None:
    errors = ArmErrors(outcome.result)
    error = errors.tool_error(errors.left)
    for k in range(3):
        assert np.abs(error[:, k] - outcome.result[f"kinematics.error[{k + 1}]"]).max() < 1e-12
    length = outcome.result["kinematics.uncompensated_error_norm"]
    assert outcome.uncompensated.max_abs_um == pytest.approx(1e6 * length.max())
    assert np.linalg.norm(error, axis=1) == pytest.approx(outcome.error, abs=1e-12)


def test_shares_of_the_axes_sum_to_the_largest_error(outcome: ClosedLoop) -> None:
    errors = ArmErrors(outcome.result)
    for elongation, found in ((errors.growth, outcome.uncompensated), (errors.left, outcome.metrics)):
        assert 1e6 * errors.by_axis(elongation).sum() == pytest.approx(found.max_abs_um)
    # The forearm points elsewhere than the tool, so that growth there takes some of the error away.
    assert errors.by_axis(errors.growth)[:3].min() > 1e-6


def test_the_coupling_error_is_small_beside_what_is_left(outcome: ClosedLoop) -> None:
    assert outcome.coupling_error_um is not None
    assert 0 < outcome.coupling_error_um < 0.1
    assert outcome.discretisation_error_um < 0.1
    for audit in outcome.result.audits:
        assert abs(audit.total) < 1e-2 * max(abs(audit.delivered), 1.0)
    assert len(outcome.result.audits) == 6


def test_the_map_shows_the_error_at_its_points() -> None:
    grid, growth = workspace(9, 9), np.array([5e-5, 4e-5, 1e-5, 2e-5, 1e-5, 3e-5])
    error = grid.error(growth)
    assert error.shape == (9, 9)
    reached = np.argwhere(np.isfinite(error))
    assert 10 < len(reached) < 81
    row, column = reached[len(reached) // 2]
    from warmlink.orchestration.arm.chain import joint_angles

    # Turned by the waist the error is as long, wherever it points.
    for turn in (0.0, 1.0):
        x, y = grid.out[column] * np.cos(turn), grid.out[column] * np.sin(turn)
        angles = joint_angles(x, y, grid.up[row], -np.pi / 2)
        there = np.linalg.norm(sensitivities(angles)[0] @ growth)
        assert error[row, column] == pytest.approx(there, rel=1e-12)


def test_the_report_shows_axes_and_maps(outcome: ClosedLoop, tmp_path: Path) -> None:
    from warmlink.orchestration.report.arm import moments
    from warmlink.orchestration.report.closed_loop import write_report

    write_report(outcome, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text("utf-8")
    for heading in ("axis by axis", "Error over the workspace, uncompensated", "shoulder", "observer"):
        assert heading in text
    assert "heatmap" in plots(tmp_path / "report.html")
    assert moments(outcome)[-1] == len(outcome.time) - 1


def test_a_mismatch_of_the_cell_goes_to_every_axis() -> None:
    scenario = replace(load_scenario("six_axis_shift"), controller=shipped("none"))
    changed = scenario.mismatched(mismatch.load("losses_high")).parameters
    scaled = [name for name in changed if name.startswith("axis4.motor")]
    assert scaled
    factors = mismatch.load("losses_high").scale
    for name in scaled:
        own = arm_values()["axis4.motor"].get(name.rpartition(".")[2])
        if own is not None:
            assert changed[name] == pytest.approx(factors[name.removeprefix("axis4.")] * float(own))
    assert scenario.mismatched(mismatch.load("nominal")).parameters == {}


@pytest.fixture(scope="module")
def comparison_files(fmu_store: FmuStore) -> FmuSet:
    scenario = load_scenario("six_axis_iso_9283")
    files = [replace(scenario, controller=shipped(name)).files(fmu_store) for name in ("none", "observer")]
    return FmuSet.read(fmu_store.kind, files[0] | files[1])


def test_a_comparison_has_a_row_for_each_controller(comparison_files: FmuSet, tmp_path: Path) -> None:
    duties = [shortened("six_axis_iso_9283", 600.0)]
    cases = plan([shipped("observer")], duties, [mismatch.load("nominal")]).cases
    with LocalWorkers(comparison_files, 1) as workers:
        comparison = run_comparison(cases, workers, lambda share: None)
    rows = list(comparison.rows.values())
    assert [row.controller for row in rows] == ["none", "observer"]
    assert rows[0].removed_percent == 0
    assert rows[1].removed_percent is not None
    assert rows[1].removed_percent > 50
    write_csv(comparison, tmp_path / "compare.csv")
    assert len((tmp_path / "compare.csv").read_text("utf-8").splitlines()) == 3


def test_the_command_writes_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["run", "six_axis_inspection", "--stop", "5 min", "--no-report", "--out", str(tmp_path / "o")]
    assert exit_code(asked, monkeypatch) == 0
    assert "largest error" in capsys.readouterr().out
    figures = json.loads((tmp_path / "o/metrics.json").read_text("utf-8"))
    assert figures["system"] == "SixAxisArm"
    assert not undescribed("metrics.json", figures)
    assert figures["controller"] == "observer"
    assert set(figures["compensated"]["largest_error_by_axis_um"]) >= {"waist", "shoulder", "elbow"}
    assert (tmp_path / "o/results.csv").is_file()
    assert (tmp_path / "o/results.parquet").is_file()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("run", "six_axis_shift", "--set", "axis9.motor.joint_conductance=1 W/K"),
            "no component axis9.motor",
        ),
        (("compare", "--system", "SixAxisArm", "--controllers", "analytic"), "has no design for SixAxisArm"),
    ],
)
def test_what_is_wrong_ends_in_one_sentence(
    arguments: tuple[str, ...],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert sentence in refused([*arguments, "--out", "o"], capsys, monkeypatch)


def test_a_file_of_one_s_own_is_a_scenario_of_the_arm() -> None:
    text = (
        'system = "SixAxisArm"\nstop_time = "1 h"\ntolerance = "20 um"\n'
        '[sensors]\nused = ["base"]\n'
        '[[segment]]\nduration = "1 h"\n'
        'speed = ["1 rad/s", "1 rad/s", "0 rad/s", "0 rad/s", "0 rad/s", "0 rad/s"]\n'
        '[[pose]]\nhold = "10 s"\npoint = ["450 mm", "0 mm", "150 mm"]\npitch = "-90 deg"\n'
    )
    scenario = read_scenario("mine", text)
    assert (scenario.in_use, scenario.controller.name) == (Sensors(0.1, ("base",)), "observer")
    assert scenario.tolerance == pytest.approx(20e-6)
    with pytest.raises(InputError, match=r"sensors\.used: 'sky' is not known; choose shaft"):
        read_scenario("mine", text.replace('"base"', '"sky"'))


@pytest.mark.parametrize("name", DESIGNED)
def test_a_scenario_is_designed_for_the_law_that_it_runs_with(name: str) -> None:
    joined = replace(load_scenario("six_axis_shift"), controller=shipped(name)).joined()
    assert "axis6.compensator.correction" in joined.y.names
