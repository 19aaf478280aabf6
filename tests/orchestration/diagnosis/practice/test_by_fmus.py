"""A stranger's machine has practice runs: what hides in its parts, its instruments, any parameter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import warmlink as wl
from tests.orchestration.machine.strangers import machine
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.practice.by_fmus import (
    HiddenEffect,
    effect_in,
    effects_in,
    values_together,
)
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import rig_of

SPINDLE = {"spindle.speed [1]", "spindle.room [1]", "base_temperature [degC]", "tip_temperature [degC]"}


@pytest.fixture(scope="module")
def gantry(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(machine("gantry", tmp_path_factory.mktemp("gantry")))


@pytest.fixture(scope="module")
def spindle(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(machine("spindle", tmp_path_factory.mktemp("spindle")))


def test_what_can_hide_is_what_its_parts_and_instruments_have(gantry: str, spindle: str) -> None:
    of_gantry, of_spindle = effects_in(rig_of(gantry)), effects_in(rig_of(spindle))
    assert {"joint_resistance:x_motor", "radiation:y_link", "sensor_lag:tip_temperature"} <= of_gantry.keys()
    assert {"elongation_scale:x_link.elongation", "clock_offset", "start_temperature"} <= of_gantry.keys()
    assert {"radiation", "elongation_scale", "sensor_offset:base_temperature"} <= of_spindle.keys()
    assert not {name for name in of_spindle if name.startswith(("joint", "copper", "friction"))}
    assert "neighbour_heat:x_motor" not in of_gantry, "nothing feeds the neighbour's temperature"


@pytest.mark.slow
def test_what_hides_in_one_of_two_motors_is_found_there(gantry: str) -> None:
    found = wl.diagnose(wl.hide({"joint_resistance:x_motor": 0.5}, scenario=gantry, seed=2), scenario=gantry)
    assert found.verdict == "named"
    assert found.causes == ("joint_resistance:x_motor",)


def test_a_cause_starts_from_what_the_machine_has(gantry: str) -> None:
    scenario = load_scenario(gantry)
    system = scenario.system(scenario.files(FmuStore("native")))
    rig = rig_of(gantry)
    warmer = effect_in(rig, "start_temperature").values(system, 3.0)
    assert warmer["x_link.initial_temperature"] == pytest.approx(298.15)
    assert effect_in(rig, "conductivity:x_link").values(system, 0.8) == {"x_link.conductivity": 0.8 * 167}
    assert effect_in(rig, "radiation:x_link").values(system, 0.6) == {"x_link.emissivity": 0.6}


def test_effects_on_one_variable_add_up_or_are_refused(gantry: str) -> None:
    scenario = load_scenario(gantry)
    system, rig = scenario.system(scenario.files(FmuStore("native"))), rig_of(gantry)
    x, b = "x_link.emissivity", "x_link.initial_temperature"

    def found(**sizes: float) -> dict[str, float]:
        return values_together(system, {name: made[name] for name in sizes}, sizes)

    made = {
        "warmer": effect_in(rig, "start_temperature"),
        "again": HiddenEffect(1.0, (b,), added=True),
        "scaled": HiddenEffect(1.0, (b,), relative=True),
        "twice": HiddenEffect(1.0, (b,), relative=True),
        "radiation": effect_in(rig, "radiation:x_link"),
        x: effect_in(rig, x),
    }
    assert found(warmer=3.0, again=1.5)[b] == found(again=1.5, warmer=3.0)[b] == pytest.approx(299.65)
    assert found(scaled=0.5, twice=3.0)[b] == pytest.approx(1.5 * 295.15)
    with pytest.raises(InputError, match=f"'radiation' and '{x}' both set {x}; give one of them"):
        found(**{"radiation": 0.6, x: 0.5})
    with pytest.raises(InputError, match=f"'warmer' and 'scaled' both set {b}"):
        found(warmer=3.0, scaled=1.1)


def test_the_air_of_the_link_is_off_by_all_that_is_hidden() -> None:
    def tip(effects: dict[str, float]) -> float:
        return float(wl.hide(effects, scenario="still_with_pad", seed=1)["tip_temperature [degC]"].iloc[-1])

    both = tip({"ambient_offset": 1.5, "link_air_offset": 1.2})
    assert both - tip({"ambient_offset": 1.5}) == pytest.approx(
        tip({"link_air_offset": 1.2}) - tip({}), rel=0.1
    )


def test_any_parameter_of_a_foreign_part_hides(spindle: str) -> None:
    plain, hidden = (wl.hide(each, scenario=spindle, seed=1) for each in ({}, {"spindle.friction": 3.0}))
    assert set(plain.columns) == {"time [s]", *SPINDLE, "column.elongation [um]"}
    warmer = (hidden - plain)["base_temperature [degC]"]
    assert warmer.iloc[-1] > 1, "half as much friction again, and the same noise"
    assert warmer.iloc[0] == 0
    pd.testing.assert_series_equal(plain["spindle.speed [1]"], hidden["spindle.speed [1]"])


def test_faults_of_clock_and_instruments_are_in_the_readings(gantry: str) -> None:
    faults = {"sensor_offset:tip_temperature": 1.5, "elongation_scale:y_link.elongation": 2.0}
    plain, wrong = (wl.hide(each, scenario=gantry, seed=3) for each in ({}, faults))
    off = wrong - plain
    assert off["tip_temperature [degC]"].to_numpy() == pytest.approx(1.5)
    assert off["base_temperature [degC]"].to_numpy() == pytest.approx(0.0)
    assert off["y_link.elongation [um]"].iloc[-1] == pytest.approx(
        plain["y_link.elongation [um]"].iloc[-1], 0.1
    )
    late = wl.hide({"clock_offset": 300.0}, scenario=gantry, seed=3)["base_temperature [degC]"]
    true = np.interp(plain["time [s]"] - 300, plain["time [s]"], plain["base_temperature [degC]"])
    assert np.std(late - true) < 0.2 < np.std(late - plain["base_temperature [degC]"])


def test_another_duty_cycle_drives_it(gantry: str) -> None:
    made = wl.hide([], "still_with_pad", scenario=gantry)
    assert made["speed [rad/s]"].iloc[0] == 0
    assert "pad_temperature [degC]" not in made, "the gantry has no role for a pad"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["joint_resistance"], "did you mean joint_resistance:x_motor or joint_resistance:y_motor?"),
        (["draught"], "effect: 'draught' cannot be hidden in Gantry"),
        (["x_motor.joint_conductance"], "has no usual strength; write x_motor.joint_conductance=VALUE"),
        (["x_motor.joint_conductance=-1"], "x_motor.joint_conductance: -1"),
        (["conductivity:x_link=0"], "the strength is a factor"),
        (
            ["stuck_sensor:tip_temperature=0"],
            "effect: stuck_sensor=0: no reading falls into so small a",
        ),
        (["--with", "fea"], "a machine is computed by its FMUs; leave --with fea out"),
        (["--axis", "3"], "leave --scenario"),
        (["--duty", "six_axis_shift"], "is made for SixAxisArm"),
    ],
)
def test_what_it_cannot_have_is_refused_in_a_sentence(
    arguments: list[str],
    said: str,
    gantry: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["warmlink", "hide", *arguments, "--scenario", gantry])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not Path("run.csv").exists()


def test_an_arm_or_a_machine_where_nothing_is_measured_is_refused(gantry: str) -> None:
    with pytest.raises(InputError, match="SixAxisArm is driven by programs of its own"):
        wl.hide([], scenario="six_axis_shift")


def test_its_duty_cycle_alone_is_told_to_be_of_the_cell(
    gantry: str, capsys: pytest.CaptureFixture[str]
) -> None:
    made = wl.hide([], gantry)
    assert "shaft_temperature [degC]" in made
    assert "the made-up run is of the nominal cell, not of Gantry" in capsys.readouterr().err


def test_a_cell_of_one_s_own_is_as_its_scenario_says(tmp_path: Path) -> None:
    """The pad's cells are empty while it is off, as a log of the other solver has them."""
    path = tmp_path / "own.toml"
    path.write_text('duty = "windshield_wiper"\n[parameters]\n"link.length" = "600 mm"\n', "utf-8")
    plain = wl.hide([], "still_with_pad", scenario="windshield_wiper")
    assert set(plain.columns) == set(wl.hide([], "still_with_pad").columns)
    assert plain["pad_temperature [degC]"].notna().all()
    longer = wl.hide([], scenario=str(path))
    assert longer["pad_temperature [degC]"].isna().all()
    tip = "tip_temperature [degC]"
    assert longer[tip].iloc[-1] < wl.hide([], "windshield_wiper")[tip].iloc[-1] - 1
