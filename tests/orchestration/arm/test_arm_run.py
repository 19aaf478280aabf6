"""The arm in closed loop: what the observers remove, where the error comes from, what the report shows."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.blueprint import arm_values
from warmlink.orchestration.arm.centralised import CentralisedObserver, Readings
from warmlink.orchestration.arm.compare import applied, compare_arm, write_csv
from warmlink.orchestration.arm.compensation import plant
from warmlink.orchestration.arm.error_map import workspace
from warmlink.orchestration.arm.library import arm_scenario_names, is_arm_scenario
from warmlink.orchestration.arm.outcome import ArmOutcome, columns
from warmlink.orchestration.arm.pose import sensitivities
from warmlink.orchestration.arm.run import arm_system, run_arm
from warmlink.orchestration.arm.scenario import ArmScenario, load_arm_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.algorithms.gauss_seidel import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.studies import mismatch

HOUR = 3600.0


def shortened(name: str, stop_time: float) -> ArmScenario:
    scenario = load_arm_scenario(name)
    return replace(scenario, program=replace(scenario.program, stop_time=stop_time))


@pytest.fixture(scope="module")
def outcome(fmu_store: FmuStore) -> ArmOutcome:
    """An hour of the fastest program, with the thermometers where they tell least."""
    return run_arm(
        replace(shortened("six_axis_iso_9283", HOUR), sensor="base", step_size=2.0), "observer", fmu_store
    )


@pytest.mark.parametrize("name", arm_scenario_names())
def test_observers_remove_nine_tenths_in_every_program(name: str, fmu_store: FmuStore) -> None:
    """From a cold start, one thermometer a joint with 0.1 K of noise; below 30 um throughout.

    In steps of 10 s, in which the observers still sample each second.
    """
    scenario = load_arm_scenario(name)
    record = [f"kinematics.{each}" for each in ("error_norm", "uncompensated_error_norm")]
    result = simulate(
        arm_system(scenario, "observer", fmu_store), scenario.stop_time, 10.0, GaussSeidel(), record=record
    )
    assert result.status == "completed"
    before, after = (float(result[each].max()) for each in reversed(record))
    assert before > 30e-6
    assert after < 30e-6
    assert after < 0.1 * before


def test_one_observer_over_all_axes_sees_what_comes_through_the_chain(outcome: ArmOutcome) -> None:
    """At the link's base nothing tells of heat from the next joint, unless the model holds that joint."""
    before, alone, together = (
        outcome.metrics(correction).max_abs_um
        for correction in (None, *(each.correction for each in outcome.compensations))
    )
    assert [each.name for each in outcome.compensations] == ["observer", "centralised"]
    assert together < 0.05 * before
    assert together < 0.3 * alone
    assert alone < 0.5 * before


def test_the_chain_s_model_predicts_without_any_reading(outcome: ArmOutcome) -> None:
    """By duty alone, all thermometers absent: the linear, reduced chain against the co-simulated arm."""
    result = outcome.result
    nothing = np.full((len(result.times), 6), np.nan)
    known = Readings(
        outcome.scenario.step_size,
        columns(result, "duty.speed"),
        columns(result, "duty.torque"),
        result["axis1.duty.ambient_temperature"],
        nothing,
    )
    found = CentralisedObserver([plant(i) for i in range(1, 7)], "base_temperature", 0.1).run(known)
    assert np.abs(found - outcome.growth).max() < 0.01 * outcome.growth.max()
    uncoupled = CentralisedObserver([plant(i, coupled=False) for i in range(1, 7)], "base_temperature", 0.1)
    assert np.abs(uncoupled.run(known) - outcome.growth).max() > 0.1 * outcome.growth.max()


def test_errors_are_those_of_the_kinematics_component(outcome: ArmOutcome) -> None:
    error = outcome.tool_error(outcome.compensations[0].correction)
    for k in range(3):
        assert np.abs(error[:, k] - outcome.result[f"kinematics.error[{k + 1}]"]).max() < 1e-12
    length = outcome.result["kinematics.uncompensated_error_norm"]
    assert outcome.metrics().max_abs_um == pytest.approx(1e6 * length.max())


def test_shares_of_the_axes_sum_to_the_largest_error(outcome: ArmOutcome) -> None:
    for correction in (None, outcome.compensations[0].correction):
        shares = outcome.by_axis(correction)
        assert 1e6 * shares.sum() == pytest.approx(outcome.metrics(correction).max_abs_um)
    # The forearm points elsewhere than the tool, so that growth there takes some of the error away.
    assert outcome.by_axis()[:3].min() > 1e-6


def test_the_coupling_error_is_small_beside_what_is_left(outcome: ArmOutcome) -> None:
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
    from warmlink.orchestration.arm.inverse import joint_angles

    # Turned by the waist the error is as long, wherever it points.
    for turn in (0.0, 1.0):
        x, y = grid.out[column] * np.cos(turn), grid.out[column] * np.sin(turn)
        angles = joint_angles(x, y, grid.up[row], -np.pi / 2)
        there = np.linalg.norm(sensitivities(angles)[0] @ growth)
        assert error[row, column] == pytest.approx(there, rel=1e-12)


def test_the_report_shows_axes_and_maps(outcome: ArmOutcome, tmp_path: Path) -> None:
    from warmlink.orchestration.report.arm import moments, write_report

    write_report(outcome, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text("utf-8")
    for heading in ("axis by axis", "Error over the workspace, uncompensated", "shoulder", "centralised"):
        assert heading in text
    assert moments(outcome)[-1] == len(outcome.time) - 1


def test_a_mismatch_of_the_cell_goes_to_every_axis() -> None:
    changed = applied(mismatch.load("losses_high"))
    scaled = [name for name in changed if name.startswith("axis4.motor")]
    assert scaled
    factors = mismatch.load("losses_high").scale
    for name in scaled:
        own = arm_values()["axis4.motor"].get(name.rpartition(".")[2])
        if own is not None:
            assert changed[name] == pytest.approx(factors[name.removeprefix("axis4.")] * float(own))
    assert applied(mismatch.load("nominal")) == {}


def test_a_comparison_has_a_row_a_controller(fmu_store: FmuStore, tmp_path: Path) -> None:
    scenario = shortened("six_axis_iso_9283", 600.0)
    rows = compare_arm(["none", "observer"], [scenario], [mismatch.load("nominal")], fmu_store)
    assert [row.controller for row in rows] == ["none", "observer", "centralised"]
    assert rows[0].removed_percent == 0
    assert all(row.removed_percent is not None and row.removed_percent > 50 for row in rows[1:])
    write_csv(rows, tmp_path / "compare.csv")
    with (tmp_path / "compare.csv").open(encoding="utf-8") as stream:
        written = list(csv.DictReader(stream))
    assert [row["controller"] for row in written] == ["none", "observer", "centralised"]
    assert float(written[1]["max_abs_um"]) == pytest.approx(rows[1].max_abs_um, abs=1e-6)


def warmlink(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "warmlink.orchestration.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=200)


def test_the_command_writes_what_it_says(tmp_path: Path) -> None:
    done = warmlink(
        "run", "six_axis_inspection", "--stop", "5 min", "--no-report", "--out", str(tmp_path / "o")
    )
    assert done.returncode == 0, done.stderr
    assert "largest tool-point error" in done.stdout
    figures = json.loads((tmp_path / "o/metrics.json").read_text("utf-8"))
    assert figures["system"] == "SixAxisArm"
    assert set(figures["compensations"]) == {"observer", "centralised"}
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
        (("compare", "--system", "SixAxisArm", "--controllers", "analytic"), "has no design for the arm"),
    ],
)
def test_what_is_wrong_ends_in_one_sentence(
    arguments: tuple[str, ...], sentence: str, tmp_path: Path
) -> None:
    done = warmlink(*arguments, "--out", str(tmp_path / "o"))
    assert done.returncode == 2, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "o").exists()


def test_a_file_of_one_s_own_is_a_scenario_of_the_arm(tmp_path: Path) -> None:
    own = tmp_path / "mine.toml"
    text = (
        'system = "SixAxisArm"\nstop_time = "1 h"\nsensor = "base"\ntolerance = "20 um"\n'
        '[[segment]]\nduration = "1 h"\n'
        'speed = ["1 rad/s", "1 rad/s", "0 rad/s", "0 rad/s", "0 rad/s", "0 rad/s"]\n'
        '[[pose]]\nhold = "10 s"\npoint = ["450 mm", "0 mm", "150 mm"]\npitch = "-90 deg"\n'
    )
    own.write_text(text)
    assert is_arm_scenario(str(own))
    assert not is_arm_scenario("windshield_wiper")
    scenario = load_arm_scenario(str(own))
    assert (scenario.sensor, scenario.sensor_channel) == ("base", 3)
    assert scenario.tolerance == pytest.approx(20e-6)
    own.write_text(text.replace('"base"', '"sky"'))
    with pytest.raises(InputError, match="sensor 'sky' is none"):
        load_arm_scenario(str(own))
