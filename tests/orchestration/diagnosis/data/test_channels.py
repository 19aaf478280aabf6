"""What a column may be beside one variable: a weighted sum of outputs, or what drives a term's input."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.data.experiment import Experiment, calibrating
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

_DUTY = (Segment(300), Segment(900, 3.0, 3.0))
BASE, TIP = "base_temperature [degC]", "tip_temperature [degC]"


def cell(folder: Path, channels: str, more: str = "", **columns: np.ndarray) -> Experiment:
    """An experiment on a run of the cell with further columns, by headers with _ for spaces."""
    run = hide({}, _DUTY)
    write_csv({**run, **{name.replace("_", " "): each for name, each in columns.items()}}, folder / "run.csv")
    path = folder / "e.toml"
    path.write_text(f'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n[channels]\n{channels}\n{more}')
    return read([path])


def test_a_column_may_be_a_weighted_sum_of_outputs(tmp_path: Path) -> None:
    run = hide({}, _DUTY)
    channels = """
"across [K]" = "link.base_temperature - link.tip_temperature"
"mean [degC]" = "0.5 * link.base_temperature + link.tip_temperature / 2"
"twice [um]" = "2 * link.elongation"
"""
    columns = {
        "across [K]": run[BASE] - run[TIP],
        "mean [degC]": (run[BASE] + run[TIP]) / 2,
        "twice [um]": 2 * run["elongation [um]"],
    }
    found = cell(tmp_path, channels, '[noise]\n"across [K]" = "0.1 K"\n', **columns)
    problem = Problem(found)
    z = problem.neutral[0]
    values, by_slot = problem.predict(0, z)
    at = {problem.names[name]: i for i, name in enumerate(problem.variables)}
    one, other = at["base_temperature"], at["tip_temperature"]
    assert values[:, at["across"]] == pytest.approx(values[:, one] - values[:, other], abs=1e-9)
    assert values[:, at["mean"]] == pytest.approx((values[:, one] + values[:, other]) / 2, abs=1e-9)
    assert values[:, at["twice"]] == pytest.approx(2 * values[:, at["elongation"]], abs=1e-12)
    inner = slice(0, len(problem.inner))
    changes = by_slot[:, one, inner] - by_slot[:, other, inner]
    assert np.abs(changes).max() > 0.1
    assert by_slot[:, at["across"], inner] == pytest.approx(changes, abs=1e-9)
    # Read in K without a zero, and in degC with one.
    read_out = problem.data[0].readings
    assert np.abs(read_out[:, at["across"]] - values[:, at["across"]]).max() < 1.0
    assert np.abs(read_out[:, at["mean"]] - values[:, at["mean"]]).max() < 1.0
    assert found.noise == {"link.base_temperature - link.tip_temperature": 0.1}


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("link.base_temperature - 2 * link.tip_temperature", "add up to -1"),
        ("link.base_temperature - link.elongation", "adds K and m"),
        ("link.base_temperature * link.tip_temperature", "not linear"),
        ("link.base_temperature - motor.speed", "made of outputs, and has motor.speed"),
        ("link.base_temperature - link.tip_temperatur", "did you mean link.tip_temperature"),
        ("__import__('os')", "neither a variable nor a number"),
        ("1 + 1", "names no variable"),
    ],
)
def test_a_column_that_is_no_sum_of_outputs_is_refused(expression: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        cell(tmp_path, f'"x [K]" = "{expression}"')
    assert said in str(refused.value)
    assert str(refused.value).startswith("e.toml: channels")


DRIVEN = """
system = "BenchMotor"
initial = "measured"
[[run]]
data = "run.csv"
[channels]
"P_el [W]" = "heating.power"
"T_wall [degC]" = "wall.temperature"
"air [degC]" = "motor.ambient_temperature"
"body [degC]" = "motor.shaft_temperature"
[term.heating]
heat = "share * power"
into = "shaft"
inputs = { power = "0 W" }
parameters = { share = 0.9 }
[term.wall]
heat = "g * (temperature - shaft_temperature)"
into = "shaft"
inputs = { temperature = "22 degC" }
parameters = { g = "1 W/K" }
[known]
"motor.speed" = "0 rad/s"
"motor.torque" = "0 N*m"
"motor.joint_conductance" = "0 W/K"
"motor.shaft_heat_capacity" = "500 J/K"
"motor.winding_conductance" = "0 W/K"
[calibrate]
"heating.share" = { min = 0.1, max = 1 }
"wall.g" = { min = 0.1, max = 10 }
"""


def lump(folder: Path) -> Path:
    """A body of 500 J/K that 70 % of a power heats, and a wall behind 1.5 W/K; 1 W/K to the air."""
    time, random = np.arange(0.0, 3600.0, 10.0), np.random.default_rng(1)
    wall = 22 + 8 * np.clip((time - 300) / 900, 0, 1) + 3 * np.sin(time / 700) * (time > 300)
    power = np.where(time // 1200 % 2 == 1, 25.0, 0.0)
    body, rise = [], 0.0
    for warm, heat in zip(wall - 22, power, strict=True):
        body.append(22 + rise)
        for _ in range(100):
            rise += 0.1 * (0.7 * heat + 1.5 * (warm - rise) - rise) / 500
    columns = {"P_el [W]": power, "T_wall [degC]": wall, "air [degC]": np.full(time.size, 22.0)}
    columns["body [degC]"] = np.array(body) + random.normal(0, 0.02, time.size)
    pd.DataFrame({"time [s]": time, **columns}).to_csv(folder / "run.csv", index=False)
    path = folder / "e.toml"
    path.write_text(DRIVEN)
    return path


def test_a_logged_power_and_a_logged_wall_drive_the_model_through_terms(tmp_path: Path) -> None:
    found = diagnose_experiment(calibrating(read([lump(tmp_path)])))
    assert found.verdict == "adequate"
    numbers = {each.name: each for each in calibration(found)}
    assert numbers["heating.share"].value == pytest.approx(0.7, abs=0.01)
    assert numbers["wall.g"].value == pytest.approx(1.5, abs=0.03)


def test_an_input_that_no_column_drives_keeps_what_is_written(tmp_path: Path) -> None:
    path = lump(tmp_path)
    path.write_text(path.read_text().replace('"T_wall [degC]" = "wall.temperature"\n', ""))
    rig = read([path]).rig
    assert rig.variables["wall.temperature"].start == pytest.approx(295.15)
    assert "wall.temperature" in rig.externals


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('inputs = { power = "0 W" }', 'inputs = { powr = "0 W" }', "inputs: powr is not in the law"),
        ('inputs = { power = "0 W" }', 'inputs = { power = "0 K" }', "is a power in W, and"),
        ("parameters = { share = 0.9 }", "parameters = { share = 0.9, power = 1 }", "name it once"),
        ('"P_el [W]" = "heating.power"', '"P_el [W]" = "heating.pwr"', "did you mean heating.power"),
        ('inputs = { power = "0 W" }', "", "nor under parameters or inputs"),
    ],
)
def test_an_input_that_does_not_fit_its_term_is_refused(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    path = lump(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError) as refused:
        read([path])
    assert said in str(refused.value)


_ROD = """
system = "BenchRod"
[[run]]
data = "run.csv"
[channels]
"P" = "%s"
"air" = "link.ambient_temperature"
"base" = "link.base_temperature"
"""


def rod(folder: Path, variable: str) -> Experiment:
    time = np.arange(0.0, 600.0, 10.0)
    columns = {"P [W]": 6.0 * (time > 100), "air [degC]": 22.0, "base [degC]": 22 + time / 100}
    pd.DataFrame({"time [s]": time, **columns}).to_csv(folder / "run.csv", index=False)
    (folder / "e.toml").write_text(_ROD % variable)
    return read([folder / "e.toml"])


def test_a_logged_power_may_stand_for_the_heater_of_a_rod(tmp_path: Path) -> None:
    found = rod(tmp_path, "link.heat_flow")
    assert found.remarks == ()
    assert found.rig.required_inputs == (("link.ambient_temperature",),)
    problem = Problem(found)
    read_out = problem.predict(0, problem.neutral[0])[0][:, 0]
    assert read_out[5] == pytest.approx(295.15)
    assert read_out[-1] > 300


def test_a_power_for_what_is_none_is_refused_with_the_way_to_give_it(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"is a power in W, and heater.on is in 1; let it drive a \[term.NAME\]"
    ):
        rod(tmp_path, "heater.on")
