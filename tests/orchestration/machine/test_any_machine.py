"""Two machines that nobody here knows, each one SSP and one file of roles, go through everything there is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import warmlink as wl
from benchmarks.own_systems import INPUT_HEADERS, measured, with_values, write_csv
from tests.orchestration.machine.strangers import machine
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.answer.claims import DUTIES
from warmlink.orchestration.diagnosis.causes.declared import read_causes
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.inputs import of_scenario
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import rig_of, with_paths
from warmlink.orchestration.products.diagnose import Found
from warmlink.orchestration.studies.session import RunOptions
from warmlink.orchestration.system.assemble import read_system

STUDY = """
controller = "lag"
duty_cycles = ["{name}.toml"]
[parameters]
"compensator.gain" = {{ min = "1 um/W", max = "8 um/W" }}
[tune]
trials = 2
batch = 2
"""
EXPERIMENT = """
system = "{name}.toml"
[[run]]
data = "run.csv"
[causes]
file = "causes.toml"
shipped = false
[channels]
{channels}
"""
FREES = """
[[cause]]
name = "{name}"
sentence = "It differs."
check = "Measure it."
frees = ["{variable}"]
between = {between}
"""


@pytest.fixture(params=["gantry", "spindle"])
def path(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return machine(request.param, tmp_path)


def test_a_bare_file_of_measurements_names_what_is_scored(path: Path) -> None:
    """A scenario says which machine it is; columns are called as its inputs, or by a variable's full name."""
    scored, room, value = {
        "gantry": ("y_link.elongation", "ambient_temperature [degC]", 22.0),
        "spindle": ("column.elongation", "spindle.room [1]", 295.15),  # whose FMU has no units
    }[path.stem]
    rows = "\n".join(f"{t},{value},{0.01 * t}" for t in range(0, 600, 15))
    Path("run.csv").write_text(f"time [s],{room},{scored} [um]\n{rows}\n", "utf-8")
    machine, known = of_scenario(str(path))
    assert known == {}
    (run,) = read_experiment(Path("run.csv"), ReadOptions(machine=machine)).runs
    assert run.readings.keys() == {scored}
    (end,) = run.inputs
    assert len(rig_of(machine).fed_with(end)) > 1, "the room is that of several parts"


def diagnosed(
    folder: Path, name: str, hidden: tuple[str, float], columns: Mapping[str, str], causes: str, duty: str
) -> Found:
    """Diagnosis of a run of a machine in which one value, by variable, is not nominal."""
    part, _, variable = hidden[0].rpartition(".")
    (folder / "causes.toml").write_text(causes, "utf-8")
    path = machine(name, folder)
    path.write_text(path.read_text("utf-8").replace("windshield_wiper", duty), "utf-8")
    scenario = load_scenario(str(path))
    system = scenario.system(scenario.files(FmuStore("native")))
    whole, _ = with_paths(system, read_causes(folder / "causes.toml").paths)
    truth = with_values(whole, {part: {variable: hidden[1]}})
    run, random = measured(truth, columns, 0.0, 1), np.random.default_rng(1)
    for header, values in run.items():
        if header.endswith("[um]"):
            values *= 1e6
        if not header.startswith(("time", *INPUT_HEADERS)):
            values += random.normal(0.0, 0.1 if header.endswith("[um]") else 0.02, values.size)
    write_csv(run, folder / "run.csv")
    channels = "\n".join(f'"{header}" = "{variable}"' for header, variable in columns.items())
    (folder / "experiment.toml").write_text(EXPERIMENT.format(name=name, channels=channels), "utf-8")
    return wl.diagnose(folder / "experiment.toml")


@pytest.mark.slow
def test_it_is_run_compared_and_tuned(path: Path) -> None:
    outcome = wl.run(path, step="10 s")
    assert outcome.uncompensated.max_abs_um > 5
    assert outcome.metrics.max_abs_um < outcome.uncompensated.max_abs_um
    by_fmus = RunOptions(exact=True, jobs=1)
    rows = wl.compare(["lag"], mismatches=["nominal", "insulated"], scenario=path, options=by_fmus).rows
    kept, insulated = (rows["none", path.stem, name].outcome.max_abs_um for name in ("nominal", "insulated"))
    assert insulated > kept
    Path("study.toml").write_text(STUDY.format(name=path.stem), "utf-8")
    best = wl.tune("study.toml", options=by_fmus).best
    assert best is not None
    assert best.objective < kept


@pytest.mark.slow
def test_a_law_is_designed_for_it(path: Path) -> None:
    law = "observer" if path.stem == "gantry" else "regression"
    found = wl.design(path, law, ["base", "tip"])
    found.write("law.ssv")
    outcome = wl.run(path, law, parameters="law.ssv", step="10 s")
    assert outcome.metrics.max_abs_um < 0.3 * outcome.uncompensated.max_abs_um


GANTRY_COLUMNS = {
    "speed [rad/s]": "x_motor.speed",
    "torque [N.m]": "x_motor.torque",
    "room [degC]": "x_motor.ambient_temperature",
    "x base [degC]": "x_link.base_temperature",
    "y tip [degC]": "y_link.tip_temperature",
    "x growth [um]": "x_link.elongation",
    "y growth [um]": "y_link.elongation",
}
ALIKE = "".join(
    FREES.format(name=name, variable=f"x_motor.{variable}", between=between)
    for name, variable, between in (
        ("coulomb", "coulomb_friction", '["0.5 N.m", "5 N.m"]'),
        ("viscous", "viscous_friction", '["0.1 N.m.s/rad", "3 N.m.s/rad"]'),
    )
)
JOINT = FREES.format(name="joint", variable="x_motor.joint_conductance", between='["0.1 W/K", "10 W/K"]')
SPINDLE_COLUMNS = {
    "speed [1]": "spindle.speed",
    "room [degC]": "column.ambient_temperature",
    "spindle [1]": "spindle.temperature",
    "base [degC]": "column.base_temperature",
    "tip [degC]": "column.tip_temperature",
    "growth [um]": "column.elongation",
}
PRELOAD = FREES.format(name="preload", variable="spindle.friction", between="[0.2, 20]")
PAINT = FREES.format(name="paint", variable="column.emissivity", between="[0, 1]")


@pytest.mark.slow
def test_a_gantry_with_a_riddle_is_told_what_to_do_next(tmp_path: Path) -> None:
    """At one speed two kinds of friction are alike; another speed tells them apart."""
    hidden = ("x_motor.coulomb_friction", 2.5)
    found = diagnosed(tmp_path, "gantry", hidden, GANTRY_COLUMNS, JOINT + ALIKE, "continuous").diagnosis
    assert found.verdict == "ambiguous"
    assert {item for each in found.ambiguous for item in each} == {"coulomb", "viscous"}
    proposed = found.proposed
    assert proposed is not None
    assert len({segment.speed for segment in proposed.duty}) > 1
    assert proposed.expected_chance is not None
    assert proposed.expected_chance > 0.9
    files = Found(found).write(tmp_path / "out")
    following = load_scenario(str(files["next_experiment.toml"]))
    assert following.machine.name == "Gantry"
    assert following.values()["duty"]["segment_speed[1]"] == proposed.duty[0].speed
    assert "x_motor, y_motor: differ in" in found.unanswered["observer"], "one law knows one motor"


@pytest.mark.slow
def test_a_gantry_is_extended_and_gains_by_an_observer_of_its_own(tmp_path: Path) -> None:
    hidden = ("x_motor.joint_conductance", 2.0)
    answer = diagnosed(tmp_path, "gantry", hidden, GANTRY_COLUMNS, JOINT + ALIKE, "windshield_wiper")
    found = answer.diagnosis
    assert answer.causes == ("joint",)
    assert [each.duty for each in found.claims] == list(DUTIES)
    assert not found.unanswered
    assert found.observer is not None
    before, after = found.observer
    assert after.largest < before.largest
    extended = read_system(answer.write(tmp_path / "out")["extended.ssp"])
    conductance = extended.components["x_motor"].values["joint_conductance"]
    assert float(conductance) == pytest.approx(2.0, rel=0.05)


@pytest.mark.slow
def test_a_spindle_is_extended_and_what_it_cannot_have_is_said(tmp_path: Path) -> None:
    hidden = ("spindle.friction", 3.0)
    answer = diagnosed(tmp_path, "spindle", hidden, SPINDLE_COLUMNS, PRELOAD + PAINT, "windshield_wiper")
    found = answer.diagnosis
    assert found.verdict == "named"
    assert answer.causes == ("preload",)
    assert [each.duty for each in found.claims] == list(DUTIES)
    assert found.unanswered == {
        "observer": "Spindle: a design needs motors and links of warmlink's, and it has none; take "
        "law='linear_observer', whose model is found from runs"
    }
    extended = read_system(answer.write(tmp_path / "out")["extended.ssp"])
    assert float(extended.components["spindle"].values["friction"]) == pytest.approx(3.0, rel=0.05)


@pytest.mark.slow
def test_a_spindle_with_a_riddle_is_to_do_one_thing_at_a_time(tmp_path: Path) -> None:
    hidden = ("spindle.friction", 3.0)
    found = diagnosed(tmp_path, "spindle", hidden, SPINDLE_COLUMNS, PAINT, "windshield_wiper").diagnosis
    assert found.verdict == "unknown"
    assert found.proposed is not None
    assert [segment.pad_mode for segment in found.proposed.duty] == [0, 0, 0, 0], "it has no pad"
