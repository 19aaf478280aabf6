"""A cell of one's own in one file: an 800 mm steel link through the commands."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warmlink as wl
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration import cli
from warmlink.orchestration.catalogue import entries
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import materials
from warmlink.orchestration.studies.compare import plan_on
from warmlink.orchestration.studies.study import load_study

CELL = """
title = "An 800 mm steel link"
duty = "windshield_wiper"
stop_time = "1 h"
controller = "observer"
tolerance = "10 um"
[materials]
link = "steel"
[parameters]
"link.length" = "800 mm"
"link.tip_position" = "780 mm"
"link.sensor_position[2]" = "200 mm"
[sensors]
noise = "0.1 K"
used = ["base", "middle", "tip"]
"""
STUDY = """
controller = "lag"
duty_cycles = ["stop_and_go"]
scenario = "my_cell.toml"
[parameters]
"compensator.gain" = { min = "0.5 um/W", max = "8 um/W" }
"""
Warmlink = Callable[..., tuple[int, str, str]]


@pytest.fixture
def warmlink(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Warmlink:
    monkeypatch.chdir(tmp_path)
    Path("my_cell.toml").write_text(CELL)

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
        with pytest.raises(SystemExit) as stop:
            cli.main()
        return int(stop.value.code or 0), *capsys.readouterr()

    return run


@pytest.mark.parametrize("name", materials())
def test_a_material_has_its_figures_and_their_source(name: str) -> None:
    material = materials()[name]
    assert material["about"]
    assert material["source"]
    given = {
        f"link.{key}": each for key, each in material.items() if key not in ("about", "source", "family")
    }
    found = start_values(given, {"link": LINK}, name)["link"]
    assert found.keys() == {"conductivity", "density", "specific_heat", "expansion_coefficient"}
    # Heat capacity of a volume is much the same in all metals; a slip of a power of ten is not.
    assert 2e6 < float(found["density"]) * float(found["specific_heat"]) < 4.5e6
    assert 5 < float(found["conductivity"]) < 250
    assert 1e-6 < float(found["expansion_coefficient"]) < 25e-6


def test_what_stands_under_parameters_comes_on_top_of_the_material() -> None:
    read = read_scenario("mine", CELL)
    assert read.parameters["link.conductivity"] == materials()["steel"]["conductivity"]
    other = read_scenario("mine", CELL.replace('"link.length"', '"link.conductivity" = 40\n"link.length"'))
    assert other.parameters["link.conductivity"] == 40
    with pytest.raises(InputError, match=r"materials\.link: 'stel' is not known; did you mean steel\?"):
        read_scenario("mine", CELL.replace('"steel"', '"stel"'))


def test_one_file_goes_through_run_design_save_and_simulate(warmlink: Warmlink) -> None:
    code, printed, _ = warmlink("run", "my_cell.toml", "--no-report", "--out", "shipped")
    assert code == 0
    command = "warmlink design my_cell.toml --law observer --out observer.ssv"
    assert "observer was designed for another cell; this one differs in link.conductivity" in printed
    assert command in printed
    code, printed, _ = warmlink(*command.split()[1:])
    assert (code, printed.splitlines()[0]) == (0, "observer from base, middle, tip")
    designed = ("--parameters", "observer.ssv")
    code, printed, _ = warmlink("run", "my_cell.toml", *designed, "--no-report", "--out", "designed")
    assert code == 0
    assert "designed for another cell" not in printed
    metrics = json.loads(Path("designed/metrics.json").read_text("utf-8"))
    assert metrics["reduction_percent"] > 95
    code, printed, told = warmlink("save", "my_cell.toml", *designed, "--out", "mine.ssp")
    assert (code, told) == (0, "")
    assert "warmlink simulate mine.ssp" in printed
    saved = wl.simulate("mine.ssp", master="gauss_seidel")
    ran = wl.run("my_cell.toml", parameters="observer.ssv")
    for name in ("link.elongation", "compensator.correction"):
        np.testing.assert_array_equal(saved[name], ran.result[name])


@pytest.mark.parametrize("mismatch", ["insulated", "ventilated"])
def test_the_observer_designed_for_it_tolerates_a_cell_that_differs(
    warmlink: Warmlink, mismatch: str
) -> None:
    """The two of `compare`'s mismatches under which it removes least."""
    designed = wl.design("my_cell.toml").parameters
    percent = wl.run("my_cell.toml", parameters=designed, mismatches=[mismatch]).reduction_percent
    assert percent is not None
    assert percent > 95


def test_what_is_set_beside_the_file_stands_in_the_advice(warmlink: Warmlink) -> None:
    outcome = wl.run("my_cell.toml", parameters={"motor.joint_conductance": "0.8 W/K"}, stop="1 min")
    assert '--law observer --set "motor.joint_conductance=0.8 W/K" --out' in str(outcome)


def test_compare_and_studies_take_the_cell(warmlink: Warmlink) -> None:
    Path("study.toml").write_text(STUDY)
    scenarios = (
        *plan_on(scenario="my_cell.toml", controllers=["lag"], duty_cycles=["stop_and_go"]).scenarios,
        *load_study("study.toml").scenarios,
    )
    for each in scenarios:
        assert (each.name, each.stop_time) == ("stop_and_go", 14400.0)
        assert each.tolerance == pytest.approx(1e-5)
        assert each.values()["link"]["length"] == 0.8
        assert each.values()["sensors"]["noise[1]"] == 0.1
    Path("study.toml").write_text(re.sub(r"duty_cycles = .*\n", "", STUDY))
    with pytest.raises(InputError, match="has a system of its own, WarmupCell; leave one of the two out"):
        plan_on("SixAxisArm", ["lag"], scenario="my_cell.toml")
    of_its_own = plan_on(scenario="my_cell.toml", controllers=["lag"]).scenarios
    for each in (*of_its_own, *load_study("study.toml").scenarios):
        assert (each.name, each.duty) == ("my_cell", load_scenario("my_cell.toml").duty)
    options = ("--duty-cycles", "six_axis_shift", "--mismatch", "nominal")
    code, _, told = warmlink("compare", "--scenario", "my_cell.toml", *options)
    assert (code, told) == (
        2,
        "warmlink: six_axis_shift: is made for SixAxisArm, but my_cell is a scenario of WarmupCell; "
        "choose another duty cycle\n",
    )


def test_the_cell_is_one_component_for_build(warmlink: Warmlink, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("my cell.toml").write_text(CELL)
    asked: list[list[Entry]] = []

    def built(components: list[Entry], how: Any) -> list[Path]:
        asked.append(components)
        return build_python_fmus([each for each in components if each.component.name in entries()], how.out)

    monkeypatch.setattr("warmlink.orchestration.products.build._build_native", built)
    wl.build(fmus="native", scenario="my cell.toml")
    whole = asked[-1][0].component
    assert whole.name == "my_cell"
    assert whole.start_values()[0][whole.p.index["link.length"]] == 0.8


def test_its_measurements_are_diagnosed_by_the_same_file(warmlink: Warmlink) -> None:
    frame = wl.run("my_cell.toml", "none").to_frame()
    noise = np.random.default_rng(1).normal(size=(3, len(frame)))
    for i, name in enumerate(("base", "tip")):
        frame[f"{name}_temperature [K]"] = frame[f"link.{name}_temperature [K]"] + 0.05 * noise[i]
    frame["elongation [m]"] = frame["link.elongation [m]"] + 3e-7 * noise[2]
    for name in ("speed [rad/s]", "torque [N.m]", "ambient_temperature [K]"):
        frame[name] = frame[f"duty.{name}"]
    kept = [name for name in frame if "." not in name.partition(" ")[0] and "error" not in name]
    assert wl.diagnose(frame[kept][::10], scenario="my_cell.toml").verdict == "adequate"


def test_a_made_up_run_says_that_it_is_of_the_nominal_cell(warmlink: Warmlink) -> None:
    Path("my_cell.toml").write_text(CELL.replace("1 h", "2 min"))
    code, _, told = warmlink("hide", "hub_heat_loss", "--duty", "my_cell.toml")
    assert code == 0
    assert "the made-up run is of the nominal cell; link.conductivity, link.density" in told
