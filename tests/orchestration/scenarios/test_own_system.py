"""A stranger's system: two links and two motors in a chain, one scenario file, every command."""

from __future__ import annotations

import csv
import json
import math
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import pytest

import warmlink as wl
from tests.chromium import Chromium
from warmlink.controllers.design.plant import plant_model
from warmlink.controllers.design.reduction import reduce_plant
from warmlink.controllers.observer.model import MODES
from warmlink.fmus.errors import InputError
from warmlink.orchestration import cli
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.closed_loop.outcome import run as run_
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.studies.plants import plant_in
from warmlink.orchestration.system.assemble import component, connected, read_system
from warmlink.orchestration.system.model import DefaultExperiment, System
from warmlink.orchestration.system.write import write_ssp

WIRES = (
    ("motor1.heat_flow", "link1.heat_flow"),
    ("link1.base_temperature", "motor1.link_base_temperature"),
    ("motor2.heat_flow", "link2.heat_flow"),
    ("link2.base_temperature", "motor2.link_base_temperature"),
    ("link1.tip_temperature", "motor2.neighbour_temperature"),
    ("motor2.neighbour_heat_flow", "link1.tip_heat_flow"),
    ("motor1.shaft_temperature", "sensors.temperature[1]"),
    ("link1.base_temperature", "sensors.temperature[3]"),
    ("link1.tip_temperature", "sensors.temperature[5]"),
    ("sensors.reading[1]", "compensator.shaft_temperature"),
    ("sensors.reading[3]", "compensator.base_temperature"),
    ("sensors.reading[5]", "compensator.tip_temperature"),
)
MIDDLE, MIDDLE_READ = "sensors.temperature[4]", "sensors.reading[4]"
KINDS = {
    "motor1": "MotorHeatSource",
    "link1": "ThermalLink",
    "motor2": "MotorHeatSource",
    "link2": "ThermalLink",
    "sensors": "TemperatureSensors",
    "compensator": "LagCompensator",
}
ROLES = """
system = "chain.ssp"
duty = "windshield_wiper"
stop_time = "30 min"
controller = "lag"
tolerance = "10 um"
[roles]
speed = ["motor1.speed", "motor2.speed", "link1.speed", "link2.speed", "compensator.speed"]
torque = ["motor1.torque", "motor2.torque", "compensator.torque"]
score = "link1.elongation + link2.elongation - compensator.correction"
[parameters]
"motor2.neighbour_conductance" = "0.3 W/K"
"""
NOISE = """
[sensors]
noise = "0.1 K"
"""
STUDY = """
controller = "lag"
duty_cycles = ["chain.toml"]
[parameters]
"compensator.gain" = { min = "1 um/W", max = "8 um/W" }
[tune]
trials = 4
batch = 2
"""

Warmlink = Callable[..., int]


def write_chain(wires: Iterable[tuple[str, str]]) -> None:
    """Write the chain as an SSP."""
    files = FmuStore("native").files(KINDS.values())
    parts = {name: component(name, files[kind]) for name, kind in KINDS.items()}
    chain = System("Chain", parts, connected(parts, wires), DefaultExperiment(0.0, 3600.0, 1.0))
    write_ssp(chain, Path("chain.ssp"))


@pytest.fixture
def warmlink(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Warmlink:
    """The command in a folder with the chain as an SSP and its scenario."""
    (tmp_path / "chain.toml").write_text(ROLES)
    (tmp_path / "study.toml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    write_chain(WIRES)

    def run(*arguments: str) -> int:
        monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        return int(ended.value.code or 0)

    return run


def test_a_connection_that_scales_what_it_carries_does_so_in_every_run(warmlink: Warmlink) -> None:
    whole = read_system("chain.ssp")
    scaled = tuple(
        replace(each, factor=-0.5) if each.target == "link1.tip_heat_flow" else each
        for each in whole.connections
    )
    write_ssp(replace(whole, connections=scaled), Path("scaled.ssp"))
    text = Path("chain.toml").read_text("utf-8").replace("chain.ssp", "scaled.ssp")
    Path("scaled.toml").write_text(text, "utf-8")
    scenario = load_scenario("scaled.toml")
    system = scenario.system(scenario.files(FmuStore("native")))
    assert {each.target: each.factor for each in system.connections if each.factor != 1} == {
        "link1.tip_heat_flow": -0.5
    }
    for refused in (scenario.joined, lambda: plant_in(scenario)):
        with pytest.raises(InputError, match=r"a connection scales what it carries \(link1\.tip_heat_flow\)"):
            refused()
    assert warmlink("save", "scaled.toml", "--out", "saved.ssp") == 0
    saved = {each.target: each.factor for each in read_system("saved.ssp").connections}
    assert saved["link1.tip_heat_flow"] == -0.5


def test_the_chain_is_run_and_scored(warmlink: Warmlink) -> None:
    assert warmlink("run", "chain.toml", "--out", "o") == 0
    found = json.loads(Path("o/metrics.json").read_text("utf-8"))
    assert found["system"] == "Chain"
    # Two links of the cell's kind grow more than one, and less than twice as much: the first heats both.
    assert found["uncompensated"]["max_abs_um"] > 60
    assert found["compensated"]["max_abs_um"] < found["uncompensated"]["max_abs_um"]
    assert found["error_budget_um"]["coupling"] < 0.1
    text = Path("o/report.html").read_text("utf-8")
    assert "link1.elongation + link2.elongation - compensator.correction" in text
    assert "chain · Windshield wiper · lag" in text


@pytest.mark.slow
def test_the_chain_is_compared(warmlink: Warmlink) -> None:
    Path("chain.toml").write_text(ROLES.replace("30 min", "5 min"))
    options = ("--controllers", "lag", "--mismatch", "nominal,thermal_high", "--exact", "--jobs", "1")
    assert warmlink("compare", "--duty-cycles", "chain.toml", *options, "--no-report", "--out", "o") == 0
    with Path("o/compare.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["controller"], row["mismatch"]) for row in rows] == [
        ("none", "nominal"),
        ("none", "thermal_high"),
        ("lag", "nominal"),
        ("lag", "thermal_high"),
    ]
    assert rows[0]["max_abs_um"] != rows[1]["max_abs_um"], "the mismatch reaches both motors and links"


@pytest.mark.slow
def test_the_chain_is_tuned(warmlink: Warmlink) -> None:
    assert warmlink("tune", "study.toml", "--jobs", "1", "--out", "o") == 0
    assert (Path("o") / "trials.csv").is_file() or list(Path("o").glob("*.csv"))


@pytest.mark.slow
def test_an_observer_designed_for_the_chain_knows_both_links(warmlink: Warmlink) -> None:
    Path("chain.toml").write_text(ROLES.replace("windshield_wiper", "stop_and_go") + NOISE)
    assert warmlink("design", "chain.toml", "--law", "observer", "--out", "observer.ssv") == 0
    largest = {}
    for name, options in (("cell's", ()), ("chain's", ("--parameters", "observer.ssv"))):
        assert warmlink("run", "chain.toml", "--controller", "observer", *options, "--out", name) == 0
        largest[name] = json.loads(Path(name, "metrics.json").read_text("utf-8"))["compensated"]["max_abs_um"]
    assert largest["chain's"] < 3
    assert largest["cell's"] > 10 * largest["chain's"]


def test_thermometers_of_a_reduced_chain_do_not_contradict_each_other(warmlink: Warmlink) -> None:
    """They did by 0.18 K, so that an observer with more of them was worse."""
    reduced = reduce_plant(plant_model(plant_in(load_scenario("chain.toml"))), MODES)
    assert reduced.error.temperature_step < 0.04
    assert reduced.error.elongation_step < 3e-8


@pytest.mark.slow
def test_more_thermometers_make_no_observer_of_the_chain_worse(warmlink: Warmlink) -> None:
    write_chain(
        (*WIRES, ("link1.sensor_temperature[2]", MIDDLE), (MIDDLE_READ, "compensator.middle_temperature"))
    )
    Path("chain.toml").write_text(ROLES.replace("windshield_wiper", "continuous").replace("30", "90") + NOISE)
    rms = []
    for sensors in ("base,tip", "base,middle,tip", "shaft,base,middle,tip"):
        wl.design("chain.toml", "observer", sensors.split(",")).write("own.ssv")
        rms.append(wl.run("chain.toml", "observer", parameters="own.ssv").metrics.rms_um)
    assert rms[0] < 0.35
    assert max(rms[1:]) < rms[0]


def test_a_regression_is_designed_for_fmus_whose_equations_nobody_knows(
    warmlink: Warmlink, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.machine.read.is_ours", lambda fmu, _: "Link" not in fmu.name)
    Path("chain.toml").write_text(
        ROLES.replace('stop_time = "30 min"', 'step_size = "5 s"\nstop_time = "1 h"')
    )
    fit = ("design", "chain.toml", "--law", "regression", "--out", "own.ssv", "--sensors")
    assert warmlink(*fit, "shaft,base,tip") == 0
    assert "plant: as in a run of its FMUs" in capsys.readouterr().out
    largest = {}
    for name, options in (("cell's", ()), ("chain's", ("--parameters", "own.ssv"))):
        assert warmlink("run", "chain.toml", "--controller", "regression", *options, "--out", name) == 0
        largest[name] = json.loads(Path(name, "metrics.json").read_text("utf-8"))["compensated"]["max_abs_um"]
    assert largest["chain's"] < 3
    assert largest["cell's"] > 5 * largest["chain's"]
    capsys.readouterr()
    assert warmlink(*fit, "base,winding") == 2
    assert "--sensors: Chain feeds no winding to compensator; choose" in capsys.readouterr().err


@pytest.mark.parametrize("law", ["observer", "regression"])
def test_no_law_is_designed_from_thermometers_that_are_not_there(
    warmlink: Warmlink, capsys: pytest.CaptureFixture[str], law: str
) -> None:
    assert warmlink("design", "chain.toml", "--law", law, "--sensors", "base,middle") == 2
    assert "--sensors: Chain feeds no middle to compensator; choose" in capsys.readouterr().err
    write_chain(wire for wire in WIRES if "sensors" not in f"{wire}")
    for sensors in ((), ("--sensors", "none")):
        assert warmlink("design", "chain.toml", "--law", law, *sensors) == 2
        said = capsys.readouterr().err
        assert said == (
            "warmlink: Chain: feeds no thermometer to compensator; wire one to it, as base_temperature\n"
        )
    assert not list(Path().glob("*.ssv"))


def test_an_observer_needs_no_thermometer_at_the_shaft(warmlink: Warmlink) -> None:
    write_chain(wire for wire in WIRES if "[1]" not in f"{wire}")
    found = wl.design("chain.toml").parameters
    assert all(math.isfinite(value) for value in found.values())


def test_what_is_passed_over_in_a_system_is_told_once(
    warmlink: Warmlink, capsys: pytest.CaptureFixture[str]
) -> None:
    with zipfile.ZipFile("chain.ssp") as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    odd = b'<ssd:Connector name="_u_start" kind="parameter"/></ssd:Connectors>'
    structure = entries["SystemStructure.ssd"].replace(b"</ssd:Connectors>", odd, 1)
    with zipfile.ZipFile("chain.ssp", "w") as archive:
        for name, content in {**entries, "SystemStructure.ssd": structure}.items():
            archive.writestr(name, content)
    for _ in range(2):
        load_scenario("chain.toml")
    assert capsys.readouterr().err.count("_u_start: declared as a connector, but no variable of") == 1


def test_the_chain_joins_into_one_component(warmlink: Warmlink) -> None:
    scenario = load_scenario("chain.toml")
    joined = scenario.joined()
    assert {"motor2.winding_temperature", "link1.elongation"} <= {*joined.x.names, *joined.y.names}
    start = joined.start_values()[0][joined.p.index["motor2.neighbour_conductance"]]
    assert start == 0.3


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("score = ", "skore = ", "roles: skore is not known; did you mean score"),
        ("link2.elongation -", "link3.elongation -", "link3.elongation: Chain has no such component"),
        ("link2.elongation -", "link2.elongated -", "fmu has no variable elongated; did you mean elongation"),
        ('"motor1.torque"', '"link1.heat_flow"', "link1.heat_flow is fed in Chain already"),
        ('controller = "lag"', "[roles.x]", "roles"),
        ("chain.ssp", "chan.ssp", "no such file"),
        ("torque = [", "torque = 3 # [", "is no list of names"),
        ("link1.elongation + link2", "link1.elongation ++* link2", "is no expression"),
    ],
)
def test_roles_that_do_not_fit_are_refused(warmlink: Warmlink, old: str, new: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read_scenario("chain", ROLES.replace(old, new, 1))


@pytest.mark.slow
@pytest.mark.platform
def test_the_chain_runs_on_a_page(warmlink: Warmlink, tmp_path: Path) -> None:
    """Its figures are those of the command, within the coupling error that the command states."""
    pytest.importorskip("ziglang", reason='ziglang is not installed: pip install "warmlink[live]"')
    assert warmlink("live", "chain.toml", "--controller", "lag") == 0
    largest = """
        const most = ({ name, values }) => [name, Math.max(...values.map(Math.abs))];
        const result = Object.fromEntries(plots()[0].lines.map(most));
    """
    with Chromium.started(tmp_path) as browser:
        shown = browser.browse(Path("chain.html"), largest)
    outcome = run_("chain.toml")
    bound = outcome.coupling_error_um
    assert bound is not None
    assert abs(shown["none"] - outcome.uncompensated.max_abs_um) <= 2 * bound  # of two links
    assert abs(shown["lag"] - outcome.metrics.max_abs_um) <= 2 * bound


def test_a_page_of_foreign_fmus_is_refused(
    warmlink: Warmlink, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.machine.read.is_ours", lambda fmu, declared: False)
    assert warmlink("live", "chain.toml", "--controller", "lag") == 2
    told = capsys.readouterr().err
    assert "Chain: contains foreign FMUs (motor1 of Chain" in told
    assert "whose equations are not known; run it with a master instead" in told
    assert not list(Path().glob("*.html"))
