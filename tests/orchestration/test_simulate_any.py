"""A single FMU is a system of one; anybody's start values may have units, or are refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

import warmlink as wl
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit


@pytest.fixture(scope="module")
def fmus() -> dict[str, Path]:
    return FmuStore("native").files(["ThermalLink", "MotorHeatSource"])


def pair(fmus: dict[str, Path]) -> wl.assemble:  # type: ignore[valid-type]
    wires = [("motor.heat_flow", "link.heat_flow"), ("link.base_temperature", "motor.link_base_temperature")]
    parts = {"motor": fmus["MotorHeatSource"], "link": fmus["ThermalLink"]}
    return wl.assemble("pair", parts, wires)


def test_a_single_fmu_runs_with_values_as_people_write_them(fmus: dict[str, Path], tmp_path: Path) -> None:
    cold = wl.simulate(fmus["ThermalLink"], stop="2 min", parameters={"heat_flow": 5.0})
    same = wl.simulate(
        fmus["ThermalLink"],
        stop="2 min",
        parameters={"ThermalLink.heat_flow": "5000 mW", "initial_temperature": "22 °C", "length": "33.02 cm"},
    )
    assert cold["ThermalLink.elongation"][-1] > 5e-6
    assert same["ThermalLink.elongation"] == pytest.approx(cold["ThermalLink.elongation"], rel=1e-9)
    kept = wl.simulate(fmus["ThermalLink"], stop="1 min", record=["elongation"])
    assert kept.table.names == ("ThermalLink.elongation",)
    write_ssv({"heat_flow": SsvValue("heat_flow", "Real", 0.005, parse_unit("kW"))}, tmp_path / "q.ssv")
    again = wl.simulate(fmus["ThermalLink"], stop="2 min", parameters=tmp_path / "q.ssv")
    assert again["ThermalLink.elongation"] == pytest.approx(cold["ThermalLink.elongation"], rel=1e-12)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("link.heat_flow", 5.0, "link.heat_flow: is fed by motor.heat_flow; set what that comes from"),
        ("link.lenth", 1.0, r"has no variable lenth; did you mean length\?"),
        ("lunk.length", 1.0, r"lunk.length: there is no component of this name; choose motor or link"),
        ("link.length", "3 K", "link.length: K does not convert to m; give it in m"),
        ("link.length", "-3 mm", "link.length: -0.003 m is below its minimum"),
        ("link.length", "long", "link.length: 'long' is not a value"),
        ("motor.pad_mode", 0.5, "motor.pad_mode: 0.5 is not a whole number"),
        ("link.elongation", 0.5, "link.elongation: takes no start value"),
    ],
)
def test_values_that_do_not_fit_are_refused(
    fmus: dict[str, Path], name: str, value: float | str, sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        wl.simulate(pair(fmus), stop="1 min", parameters={name: value})


def test_the_command_shows_few_outputs_or_none(
    fmus: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    link = str(fmus["ThermalLink"])
    printed = []
    for more in ((), ("--watch", "ThermalLink.elongation"), ("--quiet",)):
        given = ["simulate", link, "--stop", "2 min", "--set", "heat_flow=5 W", "--out", "o", *more]
        monkeypatch.setattr("sys.argv", ["warmlink", *given])
        with pytest.raises(SystemExit) as stop:
            main()
        assert not stop.value.code
        printed.append(capsys.readouterr().out.splitlines())
    assert "2 more outputs are in the results; --watch chooses what is shown" in printed[0]
    assert [line.split()[0] for line in printed[1][2:3]] == ["ThermalLink.elongation"]
    assert "13 more outputs" in printed[1][3]
    assert printed[2] == ["results  o"]


def test_variables_of_a_single_fmu_are_watched_and_recorded_by_their_own_names(
    fmus: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["simulate", str(fmus["ThermalLink"]), "--stop", "1 min", "--watch", "elongation"]
    monkeypatch.setattr("sys.argv", ["warmlink", *asked, "--record", "*temperature,elongation"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code
    assert "ThermalLink.elongation" in capsys.readouterr().out
    table = Path("out/ThermalLink/simulate/results.csv").read_text("utf-8").splitlines()[0]
    assert "ThermalLink.elongation [m]" in table
    assert "ThermalLink.tip_temperature [K]" in table
    assert "surface_heat_loss" not in table
