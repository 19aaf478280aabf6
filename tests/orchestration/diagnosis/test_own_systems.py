"""A stranger's system: a heat path that the model lacks is found, and the extended SSP carries it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.own_systems import (
    CELL_CHANNELS,
    CELL_INPUTS,
    CHAIN,
    CHANNELS,
    INPUTS,
    cell,
    chain,
    experiment,
    measured,
    with_values,
    write_csv,
)
from tests.documented import undescribed
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.extension import extended_values, write_ssp_of
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.causes.declared import read_causes
from warmlink.orchestration.diagnosis.data.experiment import calibrating
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import rig_in, with_paths
from warmlink.orchestration.system.assemble import read_system

FLANGE = """
[[cause]]
name = "flange"
sentence = "The first motor heats the second link through the flange."
check = "Put a thermometer on the flange."
adds = { conductance = "W/K", from = "motor1.shaft_temperature", to = "link2.base_temperature", \
into = "link2.heat_flow" }
between = ["0 W/K", "5 W/K"]
"""
OTHERS = """
[[cause]]
name = "gears"
sentence = "Gears beside the second link heat it."
check = "Look at the gears."
adds = { heat = "W", into = "link2.heat_flow", course = "with:motor1.speed" }
between = [0, 10]
[[cause]]
name = "paint"
sentence = "The second link is painted."
check = "Look at it."
frees = ["link2.emissivity"]
between = [0, 1]
[[cause]]
name = "slow"
sentence = "The thermometer at the second base follows late."
check = "Exchange it."
reading = { of = "link2.base_temperature", lag = "s" }
between = ["0 s", "10 min"]
"""


@pytest.mark.slow
def test_a_hidden_conductance_is_named_and_the_extended_system_has_it(tmp_path: Path) -> None:
    path = experiment(tmp_path, chain(), {**INPUTS, **CHANNELS}, FLANGE + OTHERS)
    changed, _ = with_paths(chain(), read_causes(tmp_path / "causes.toml").paths)
    truth = with_values(changed, {"flange": {"conductance": 0.3}})
    columns = measured(truth, {**INPUTS, **CHANNELS}, 0.05, 1)
    write_csv(columns, tmp_path / "run.csv")

    found = diagnose_experiment(read([path]))
    assert found.verdict == "named"
    assert [item.title for item in found.causes] == ["flange"]
    fit = found.assessment.best
    deviation = float(np.sqrt(fit.covariance()[0, 0]))
    assert deviation < 0.001
    assert abs(fit.theta[0] - 0.3) < 4 * deviation

    problem = found.assessment.problem
    values = extended_values(problem, fit)
    write_ssp_of(problem.experiment.rig, values, tmp_path / "extended.ssp", FmuStore("native"))
    extended = read_system(tmp_path / "extended.ssp")
    assert set(extended.components) == {*CHAIN, "flange"}, "and no path that was not found"
    again = measured(replace(extended, default_experiment=truth.default_experiment), CHANNELS, 0.0, 1)
    for header in CHANNELS:
        assert np.std(again[header] - columns[header]) < 0.06, header


def test_inputs_stand_before_a_path_that_is_put_before_them() -> None:
    rig = rig_in(chain())
    assert rig.component.u.names == rig.externals
    assert rig.component.p.names == rig.parameters
    assert rig.fed_with("motor1.speed") == ("motor1.speed", "link1.speed", "motor2.speed", "link2.speed")
    assert rig.on_link("link2.tip_temperature") == ("link2", 3)
    assert set(rig.called("motor")) == {"motor1", "motor2"}


def flat(headers: Iterable[str]) -> dict[str, np.ndarray]:
    """A run in which everything rises alike: enough to be read."""
    time = np.arange(0.0, 600.0, 15.0)
    return {"time [s]": time, **dict.fromkeys(headers, 20 + 0.01 * time)}


@pytest.mark.parametrize(
    ("causes", "sentence"),
    [
        ('[[cause]]\nname = "a"', "causes.toml: cause 1: sentence is missing"),
        (FLANGE.replace("flange", "link2"), "link2: Chain has a component of this name; rename the cause"),
        (FLANGE.replace('"5 W/K"', '"5 W"'), "experiment.toml: causes.toml: flange.between: W does not"),
        (
            FLANGE.replace('"0 W/K"', '"1 W/K"'),
            "1 to 5 W/K does not contain 0 W/K, the value without the cause",
        ),
        (FLANGE.replace(", from", ", fro"), "causes.toml: cause 1.adds: fro is not known; did you mean from"),
        (FLANGE.replace("conductance =", "heat ="), "flange.adds: W/K does not convert to W"),
        (FLANGE.replace("link2.base_", "link3.base_"), "there is no component of this name"),
        (OTHERS.replace("link2.emissivity", "link2.emisivity"), "has no variable link2.emisivity"),
        (OTHERS.replace('lag = "s"', 'lag = "m"'), "slow.reading: m does not convert to s"),
        (OTHERS.replace("link2.base_temperature", "link2.surface_heat_loss"), "no column of the runs is"),
        (
            FLANGE.replace("motor1.shaft_temperature", "motor2.neighbour_temperature"),
            "motor2.neighbour_temperature: is an input that nothing feeds in Chain",
        ),
        (FLANGE + FLANGE, "two causes are called flange; rename one"),
        (
            OTHERS.replace("with:motor1.speed", "with:"),
            "course: 'with:' is not a course; give constant, ramp or with:",
        ),
    ],
    ids=range(13),
)
def test_what_does_not_fit_is_said(tmp_path: Path, causes: str, sentence: str) -> None:
    path = experiment(tmp_path, chain(), {**INPUTS, **CHANNELS}, causes)
    write_csv(flat([*INPUTS, *CHANNELS]), tmp_path / "run.csv")
    with pytest.raises(InputError) as told:
        read([path])
    assert sentence in str(told.value)


def test_a_shipped_system_takes_paths_too(tmp_path: Path) -> None:
    tube = (
        FLANGE.replace("motor1.", "motor.")
        .replace("link2.base", "link.tip")
        .replace("link2.heat", "link.tip_heat")
    )
    path = experiment(tmp_path, chain(), {"base": "link.base_temperature"}, tube)
    path.write_text(path.read_text("utf-8").replace("system.ssp", "WarmupCell"), "utf-8")
    write_csv({**flat(["speed [rad/s]"]), **flat(["base [degC]"])}, tmp_path / "run.csv")
    found = read([path])
    assert "flange.conductance" in found.rig.parameters
    assert "speed" in found.rig.columns
    assert found.rig.component.name == "WarmupCell"


def test_calibration_gives_intervals_and_what_is_not_told_apart(tmp_path: Path) -> None:
    truth = with_values(cell(), {"link": {"convection_still": 6.0}, "motor": {"joint_conductance": 1.5}})
    columns = {**CELL_INPUTS, **CELL_CHANNELS}
    write_csv(measured(truth, columns, 0.05, 1), tmp_path / "run.csv")
    asked = """[calibrate]
"link.convection_still" = { min = "1 W/(m2.K)", max = "12 W/(m2.K)", start = "4.5 W/(m2.K)" }
"link.density" = { min = "2000 kg/m3", max = "4000 kg/m3", start = "2700 kg/m3" }
"link.specific_heat" = { min = "600 J/(kg.K)", max = "1200 J/(kg.K)", start = "890 J/(kg.K)" }
"motor.joint_conductance" = { min = "0.2 W/K", max = "8 W/K" }
"""
    causes = OTHERS.replace("link2", "link").replace("motor1", "motor")
    path = experiment(tmp_path, cell(), columns, causes, asked)
    found = diagnose_experiment(calibrating(read([path])))
    known = {each.name: each for each in calibration(found)}
    for name, value in (("link.convection_still", 6.0), ("motor.joint_conductance", 1.5)):
        assert abs(known[name].value - value) < 4 * known[name].std, name
        assert not known[name].alike
    assert known["link.density"].alike == ("link.specific_heat",)
    assert known["link.density"].unknown
    said = summary(found)
    assert "The calibrated model explains the data to within their noise." in said
    assert "of which the data say nothing, not told apart from link.specific_heat" in said
    assert "Error on fitted rows: " in said
    content = json_content(found)
    assert content["calibrated"]["motor.joint_conductance"]["unit"] == "W/K"
    assert not undescribed("diagnosis.json", content)


def test_a_calibration_wants_something_to_calibrate(tmp_path: Path) -> None:
    columns = {**INPUTS, **CHANNELS}
    write_csv(flat(columns), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"calibrates nothing; name under \[calibrate\]"):
        calibrating(read([experiment(tmp_path, chain(), columns, OTHERS)]))


def test_an_offset_of_a_gauge_has_the_unit_of_a_length(tmp_path: Path) -> None:
    columns = {**CELL_INPUTS, **CELL_CHANNELS, "growth [m]": "link.elongation"}
    path = experiment(tmp_path, cell(), columns, FLANGE.replace("2.", ".").replace("1.", "."))
    path.write_text(path.read_text("utf-8").replace("shipped = false", "shipped = true"), "utf-8")
    run, random = measured(cell(), columns, 0.0, 1), np.random.default_rng(1)
    for header in CELL_CHANNELS:
        run[header] = run[header] + 0.05 * random.standard_normal(run[header].size)
    run["growth [m]"] = run["growth [m]"] + 4e-6 + 0.2e-6 * random.standard_normal(run["time [s]"].size)
    write_csv(run, tmp_path / "run.csv")
    found = json_content(diagnose_experiment(read([path])))["causes"]
    assert [each["name"] for each in found] == ["sensor_offset:growth"]
    (offset,) = found[0]["parameters"].values()
    assert offset["unit"] == "m"
    assert offset["value"] == pytest.approx(4e-6, abs=0.2e-6)
