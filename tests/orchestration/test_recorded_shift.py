"""A recorded shift that changes in every row drives runs, studies, joined and own systems."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.shared_data import given
from warmlink.fmus.component.instance import Instance
from warmlink.orchestration.closed_loop.load import driven, load_scenario
from warmlink.orchestration.closed_loop.outcome import run
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.scenarios.duties.duty import Duty, Recorded
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.simulation import simulate
from warmlink.orchestration.studies.case import case_of
from warmlink.orchestration.studies.joined import differences_from_fmus, joined_systems
from warmlink.orchestration.studies.workers import FmuSet, attempt, joined_outcomes
from warmlink.orchestration.system.write import write_ssp

ROWS = 1200


@pytest.fixture
def shift(tmp_path: Path) -> Path:
    """Twenty minutes, a row each second; beside it a scenario in which the ambient temperature is linear."""
    generator = np.random.default_rng(5)
    speed = 3 * (np.arange(ROWS) % 300 < 200) + generator.uniform(0, 0.2, ROWS)
    rows = (f"{i},{s:.5f},{1 + s / 2:.5f},{22 + np.sin(i / 200):.4f}" for i, s in enumerate(speed))
    path = tmp_path / "shift.csv"
    path.write_text("\n".join(["time [s],speed [rad/s],torque [N.m],ambient_temperature [degC]", *rows]))
    text = 'duty = "shift.csv"\nlinear = ["ambient_temperature"]\nstop_time = "25 min"\n'
    (tmp_path / "linear.toml").write_text(text)
    return path


def test_a_run_takes_every_row(shift: Path) -> None:
    scenario = load_scenario(str(shift))
    assert isinstance(scenario.duty, Recorded)
    found = run(scenario)
    np.testing.assert_array_equal(found.result["duty.speed"], scenario.duty.table.over(found.time)[:, 0])
    assert found.coupling_error_um is not None
    assert found.coupling_error_um < 0.1


def test_the_joined_system_meets_the_co_simulated_one_within_the_coupling_error(shift: Path) -> None:
    scenario = load_scenario(str(shift))
    found, joined = run(scenario), Instance(scenario.joined())
    joined.initialize()
    growth = [joined.get("link.elongation")]
    for second in range(ROWS // 4):  # work, and a pause
        joined.step(second, 1.0)
        growth.append(joined.get("link.elongation"))
    difference = 1e6 * np.abs(np.array(growth) - found.result["link.elongation"][: len(growth)]).max()
    assert found.coupling_error_um is not None
    assert 0 < difference <= found.coupling_error_um


def test_native_and_python_fmus_play_the_same(shift: Path) -> None:
    scenario = load_scenario(str(shift.with_name("linear.toml")))
    native, python = (run(scenario, stop="1 min", fmus=kind) for kind in ("native", "python"))
    for name in native.result.table.names:
        np.testing.assert_allclose(
            python.result[name], native.result[name], rtol=1e-9, atol=1e-15, err_msg=name
        )


def test_what_comes_after_the_last_row_is_said(shift: Path) -> None:
    found = run(load_scenario(str(shift.with_name("linear.toml"))), controller="none")
    assert "shift ends at 1199 s; its last row holds from then on" in found.remarks
    assert len(set(found.result["duty.ambient_temperature"][1199:])) == 1


def test_lanes_play_tables_beside_segments(shift: Path) -> None:
    recorded = load_scenario(str(shift))
    scenarios = [recorded, replace(load_scenario("stop_and_go"), controller=recorded.controller)]
    said: list[str] = []
    rollouts = joined_systems(scenarios, said.append)
    assert (said, list(rollouts)) == ([], ["LagCompensator"])
    store = FmuStore("native")
    files = {name: path for each in scenarios for name, path in each.files(store).items()}
    fmus = FmuSet("native", FmuSet.read("native", files).contents, rollouts)
    ended = [replace(each, duty=each.duty.until(900.0)) for each in scenarios]
    cases = [case_of(each, (each.name,), with_budget=True) for each in ended]
    for place, outcome in joined_outcomes(cases, rollouts).items():
        exact = attempt(cases[place], fmus)
        assert exact.coupling_um is not None
        assert abs(exact.max_abs_um - outcome.max_abs_um) <= exact.coupling_um
    assert len(joined_outcomes(cases, rollouts)) == 2
    assert list(differences_from_fmus([], fmus, said.append)) == []


def test_a_case_knows_its_rows(shift: Path) -> None:
    first = case_of(load_scenario(str(shift)), ("one",))
    shift.write_text(shift.read_text().replace("22.0000", "22.0001"))
    assert case_of(load_scenario(str(shift)), ("one",)).digest != first.digest


def test_what_drives_a_scenario_may_change_from_segments_to_rows_and_back(shift: Path) -> None:
    cell, recorded = load_scenario("stop_and_go"), load_scenario(str(shift))
    played = driven(cell, recorded)
    assert played.machine.parts["duty"] == "RecordedDuty"
    back = driven(played, cell)
    assert isinstance(back.duty, Duty)
    assert back.machine == cell.machine


def saved(scenario: Scenario, path: Path) -> Path:
    write_ssp(scenario.system(scenario.files(FmuStore("native"))), path)
    return path


def test_a_system_that_was_saved_plays_on_and_is_a_scenarios_system(shift: Path, tmp_path: Path) -> None:
    scenario = load_scenario(str(shift))
    ssp = saved(scenario, tmp_path / "cell.ssp")
    alone = simulate(ssp, stop=600.0, step=1.0)
    whole = run(scenario, stop=600.0)
    np.testing.assert_array_equal(alone["link.elongation"], whole.result["link.elongation"])
    roles = '[roles]\nscore = "link.elongation - compensator.correction"\n'
    for name, duty in (("again", "shift.csv"), ("written", "stop_and_go")):
        text = f'system = "cell.ssp"\nduty = "{duty}"\nstop_time = "10 min"\n{roles}'
        (tmp_path / f"{name}.toml").write_text(text)
    again = run(load_scenario(str(tmp_path / "again.toml")))
    np.testing.assert_array_equal(again.result["link.elongation"], whole.result["link.elongation"])
    written, shipped = (
        run(load_scenario(n), stop=600.0) for n in (str(tmp_path / "written.toml"), "stop_and_go")
    )
    np.testing.assert_array_equal(written.result["link.elongation"], shipped.result["link.elongation"])


@pytest.mark.parametrize("name", ["machine1_hot_restart", "machine2_overnight"])
def test_logs_of_real_shifts_run(name: str) -> None:
    scenario = load_scenario(str(given(f"machine/{name}.parquet")))
    found = run(scenario, stop="20 min")
    assert found.metrics.max_abs_um < found.uncompensated.max_abs_um
