"""Runs whose values mean nothing: said when a band is left, ended when it is far away, with the cause."""

import json
import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import warmlink.orchestration.api as wl
from warmlink.fmus.component.variables import Band
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.orchestration import catalogue
from warmlink.orchestration.cli import app
from warmlink.orchestration.closed_loop.load import load_scenario, names_on
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.console import FAILED
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import RecordTable, Result
from warmlink.orchestration.products.compare import compare
from warmlink.orchestration.scenarios.plausible import Declared, within_bands
from warmlink.orchestration.studies.session import RunOptions

WINDING = "motor.winding_temperature"


def duty(folder: Path, torque: float, stop: str = "1 h") -> Path:
    path = folder / "hot.toml"
    segment = f'[[segment]]\nduration = "{stop}"\nspeed = "30 rpm"\ntorque = "{torque} N.m"\n'
    path.write_text(f'stop_time = "{stop}"\n{segment}')
    return path


def hot(folder: Path, torque: float, stop: str = "1 h") -> ClosedLoop:
    return wl.run(str(duty(folder, torque, stop)))


def table(name: str, values: list[float]) -> RecordTable:
    points = CommunicationPoints.between(0.0, len(values) - 1.0, 1.0)
    return RecordTable((name,), {name: "K"}, points, np.array(values)[:, None])


def looked_at(values: list[float]) -> Result:
    result = Result(table(WINDING, values), "completed")
    return within_bands(result, Declared({"motor": MOTOR}, {}, {}))


def test_a_value_outside_its_band_is_remarked_on_and_one_far_outside_ends_the_run() -> None:
    band = next(each.plausible for each in MOTOR.outputs if each.name == "winding_temperature")
    assert band is not None
    high, width = band.high, band.high - band.low
    assert looked_at([300.0, high, band.low]).remarks == ()
    (told,) = looked_at([300.0, high + 1, 300.0]).remarks
    assert told.startswith(f"{WINDING} is 247.9 degC at 1 s, outside")
    assert looked_at([300.0, high + 1.9 * width]).stopped is None
    ended = looked_at([300.0, high + 1, high + 2.1 * width, 300.0])
    assert ended.stopped is not None
    assert ended.stopped.startswith(f"{WINDING} is ")
    assert len(ended.table) == 2


@pytest.mark.parametrize("wild", [math.nan, math.inf, -math.inf])
def test_values_that_are_no_numbers_are_far_outside_once_the_band_was_left(wild: float) -> None:
    assert len(looked_at([300.0, 700.0, wild]).table) == 2


def test_every_temperature_and_growth_of_a_plant_has_a_band_and_what_instruments_say_has_none() -> None:
    bands = {
        f"{name}.{each.name}": each.plausible
        for name, component in catalogue.components().items()
        for each in component.outputs
    }
    assert {"ThermalLink.elongation", "ThermalLink.tip_temperature", "Heater.heater_temperature"} <= {
        name for name, band in bands.items() if isinstance(band, Band)
    }
    assert bands["TemperatureSensors.reading"] is None
    assert bands["DriftCamera.measured_drift"] is None
    assert bands["LagCompensator.correction"] is None


@pytest.mark.parametrize("name", names_on(WARMUP_CELL.name))
def test_no_shipped_duty_cycle_leaves_a_band(name: str) -> None:
    outcome = wl.run(name, step="10 s")
    assert outcome.cut_short is None
    assert not [told for told in outcome.remarks if "outside what the model holds for" in told]


def test_a_law_that_says_what_no_link_can_grow_by_is_shown_in_few_digits(tmp_path: Path) -> None:
    outcome = wl.run("stop_and_go", "lag", stop="1 min")
    wild = replace(outcome.metrics, max_abs_um=2.1e14)
    outcome.__dict__["metrics"] = wild
    assert "2.1e+14 µm" in outcome.summary()
    assert max(map(len, outcome.summary().splitlines()[:5])) < 100


def test_a_winding_that_gets_too_hot_is_said_with_its_torque(tmp_path: Path) -> None:
    outcome = hot(tmp_path, 10, "15 min")
    (told,) = [each for each in outcome.remarks if WINDING in each]
    assert "motor.torque is 10 N.m, ordinarily some 2.5 N.m" in told
    assert outcome.cut_short is None
    assert told in outcome.summary()


@pytest.mark.parametrize("torque", [25, 250])
def test_thermal_runaway_ends_the_run_and_the_torque_is_named_not_the_solver(
    torque: float, tmp_path: Path
) -> None:
    outcome = hot(tmp_path, torque)
    assert outcome.cut_short is not None
    assert outcome.cut_short.startswith(WINDING)
    assert f"motor.torque is {torque} N.m" in outcome.cut_short
    assert "copper loss" in outcome.cut_short
    assert "smaller step" not in outcome.summary()
    assert np.max(outcome.result[WINDING], initial=0.0) < 1300
    assert outcome.uncompensated.max_abs_um < 1000


def test_the_command_says_so_and_keeps_what_means_something(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        app(["run", str(duty(tmp_path, 25)), "--out", "o", "--no-report"])
    assert end.value.code == FAILED
    assert f"stopped early: {WINDING}" in capsys.readouterr().err
    assert json.loads((tmp_path / "o" / "metrics.json").read_text())["uncompensated"]["max_abs_um"] < 1000
    with pytest.raises(SystemExit):
        app(["save", str(duty(tmp_path, 25)), "--out", "hot.ssp"])
    with pytest.raises(SystemExit) as end:
        app(["simulate", "hot.ssp", "--out", "s"])
    assert end.value.code == FAILED
    assert f"stopped early: {WINDING}" in capsys.readouterr().err


@pytest.mark.parametrize("exact", [False, True])
def test_a_case_that_leaves_its_band_is_marked_and_never_the_best(exact: bool, tmp_path: Path) -> None:
    cycles = [str(duty(tmp_path, 10, "15 min")), "stop_and_go"]
    found = compare(["lag"], cycles, ["nominal"], options=RunOptions(exact=exact))
    row = found.row("lag", "hot")
    assert row.outcome.stopped is not None
    assert "motor.torque is 10 N.m" in row.outcome.stopped
    assert math.isnan(row.outcome.max_abs_um)
    assert not row.equals(found.best_um("hot", "nominal"))
    assert found.row("lag", "stop_and_go").outcome.stopped is None


def test_the_check_takes_less_than_a_hundredth_of_the_run() -> None:
    outcome = wl.run("stop_and_go")
    scenario = load_scenario("stop_and_go")
    known = Declared(scenario.declared, scenario.machine.fed, scenario.values())
    began = time.process_time()
    for _ in range(10):
        within_bands(outcome.result, known)
    assert (time.process_time() - began) / 10 < 0.01 * outcome.wall_seconds
