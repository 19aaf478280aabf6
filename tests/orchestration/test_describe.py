"""What can be set and read of anything by name or file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import warmlink as wl
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.describe import VariableRow
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.write import write_ssp


def row(found: object, name: str) -> VariableRow:
    (one,) = (each for each in found.variables if each.name == name)  # type: ignore[attr-defined]
    return one


def test_a_component_says_unit_default_range_and_meaning() -> None:
    found = wl.describe("ThermalLink")
    assert row(found, "length") == VariableRow(
        "parameter", "length", "mm", "330.2", "> 0, ≤ 20000", "length of the link"
    )
    assert row(found, "heat_flow").role == "input"
    assert row(found, "sensor_temperature[1..8]").default == ""
    assert "length of the link" in repr(found)
    frame = found.to_frame()
    assert list(frame.columns) == ["role", "name", "unit", "default", "range", "meaning"]
    assert len(frame) == len(found.variables)


def test_a_list_of_starts_ends_where_it_repeats() -> None:
    assert row(wl.describe("DutyCycle"), "duration[1..32]").default == "7200, 0 …"


def test_a_system_has_its_parts_and_no_connected_input() -> None:
    names = [each.name for each in wl.describe("WarmupCell").variables]
    assert "motor.joint_conductance" in names
    assert "link.heat_flow" not in names
    assert any(name.startswith("axis6.") for name in (e.name for e in wl.describe("SixAxisArm").variables))


def test_an_fmu_says_what_its_component_says() -> None:
    found, declared = wl.describe(FmuStore("native").files(["Heater"])["Heater"]), wl.describe("Heater")
    assert {each.name for each in found.variables} == {each.name for each in declared.variables}
    assert row(found, "power").range.startswith("≥ 0")


def test_an_ssp_says_what_feeds_an_input_and_what_the_system_sets(tmp_path: Path) -> None:
    scenario = load_scenario("stop_and_go")
    write_ssp(scenario.system(scenario.files(FmuStore("native"))), tmp_path / "cell.ssp")
    found = wl.describe(tmp_path / "cell.ssp")
    assert row(found, "link.heat_flow").role == "fed by motor.heat_flow"
    lasts = next(each for each in found.variables if each.name.startswith("duty.duration[1"))
    assert float(lasts.default) == scenario.duty.segments[0].duration  # type: ignore[union-attr]


def test_a_name_that_is_nothing_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"ThermalLnk: no such component.*did you mean ThermalLink\?"):
        wl.describe("ThermalLnk")


def test_the_command_lists_it(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for arguments in (("Heater",), ("Heater", "--json")):
        monkeypatch.setattr("sys.argv", ["warmlink", "list", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        assert not stop.value.code
    table, whole = capsys.readouterr().out.split("\n{", 1)
    assert "electric" in table.lower()
    assert json.loads("{" + whole)["name"] == "Heater"


def test_info_says_what_kind_of_file_it_is(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    fmu = FmuStore("native").files(["Heater"])["Heater"]
    assert wl.describe(fmu).facts["FMI"] == "2.0, co-simulation and model exchange"
    monkeypatch.setattr("sys.argv", ["warmlink", "info", str(fmu)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code
    said = capsys.readouterr().out
    assert "get and set its state" in said
    assert f"what can be set  warmlink list {fmu}" in said
    monkeypatch.setattr("sys.argv", ["warmlink", "info", "Heater"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert "Heater: is neither FMU nor SSP" in capsys.readouterr().err
