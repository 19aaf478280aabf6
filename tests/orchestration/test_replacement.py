"""`--replace` and `--map`: another FMU in place of a part, and one message for all that does not fit."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.command_line.init import list_
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.replaced import with_replaced
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system import replacement
from warmlink.orchestration.system.replacement import Replacements

pytestmark = pytest.mark.usefixtures("as_a_command")

OTHER = {"heat_flow": "Q", "base_temperature": "T.base", "elongation": "dL"}


@pytest.fixture
def strange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A link whose variables have other names."""
    monkeypatch.setattr(replacement, "cache_folder", lambda: tmp_path)
    link = FmuStore("native").files(["ThermalLink"])["ThermalLink"]
    return replacement._renamed(link, OTHER).rename(tmp_path / "My.fmu")


def cell() -> Scenario:
    scenario = load_scenario("windshield_wiper")
    return replace(scenario, controller=shipped("none"), step_size=10.0)


def given(path: Path, names: dict[str, str]) -> Replacements:
    return Replacements.given([f"link={path}"], [f"link.{name}={own}" for name, own in names.items()])


def test_a_link_under_other_names_runs_as_the_one_that_it_replaces(strange: Path) -> None:
    scenario = with_replaced(cell(), given(strange, OTHER))
    assert "ThermalLink" not in scenario.kinds
    store = FmuStore("native")
    systems = [each.system(each.files(store)) for each in (cell(), scenario)]
    systems.append(given(strange, OTHER).in_system(systems[0]))
    growths = [
        simulate(each, 600.0, 10.0, GaussSeidel(), record=["link.elongation"])["link.elongation"]
        for each in systems
    ]
    assert np.array_equal(growths[0], growths[1])
    assert np.array_equal(growths[0], growths[2])
    assert growths[0][-1] > 1e-6


def test_start_values_of_a_part_are_those_of_what_replaces_it(strange: Path) -> None:
    scenario = cell()
    before = scenario.system(scenario.files(FmuStore("native")))
    asked = {"length": 0.8, "tip_position": 0.78, "conductivity": 50.0}
    link = replace(before.components["link"], values={**asked})
    names = {**OTHER, "conductivity": "k"}
    one, other = (
        given(replacement._renamed(strange, {"conductivity": "k", **more}), names).in_system(
            replace(before, components={**before.components, "link": link})
        )
        for more in ({}, {"length": "L"})
    )
    assert one.components["link"].values == asked
    assert one.remarks == before.remarks
    assert other.components["link"].values == {n: v for n, v in asked.items() if n != "length"}
    assert other.remarks == (*before.remarks, "link.length: My.fmu takes no such value; 0.8 is left out")


def test_what_a_connection_does_to_a_value_stays(strange: Path) -> None:
    scenario = cell()
    before = scenario.system(scenario.files(FmuStore("native")))
    doubled = tuple(
        replace(each, factor=2.0, offset=1.0) if each.source_component == "link" else each
        for each in before.connections
    )
    after = given(strange, OTHER).in_system(replace(before, connections=doubled))
    assert after.connections == doubled != before.connections


def test_all_that_is_missing_is_said_at_once(strange: Path) -> None:
    for refused in (
        lambda: with_replaced(cell(), given(strange, {})),
        lambda: rig_of("WarmupCell", replaced=given(strange, {})),
    ):
        with pytest.raises(InputError) as told:
            refused()
        sentence = str(told.value)
        assert "heat_flow is missing: an input [W]" in sentence
        assert "base_temperature is missing: an output [K]" in sentence
        assert "elongation is missing: an output [m]" in sentence
        assert re.search(r"say --map \"link\.(heat_flow|base_temperature|elongation)=NAME\"", sentence)
        assert "see `warmlink list interface ThermalLink`" in sentence


def test_a_variable_that_stands_for_two_is_refused(strange: Path) -> None:
    both = {**OTHER, "tip_temperature": "T.base"}
    with pytest.raises(
        InputError, match=r"tip_temperature is to be T\.base, as base_temperature is; give each"
    ):
        with_replaced(cell(), given(strange, both))


def test_what_is_something_else_is_said(strange: Path) -> None:
    names = {**OTHER, "elongation": "tip_temperature", "heat_flow": "speed"}
    with pytest.raises(InputError) as told:
        with_replaced(cell(), given(strange, names))
    assert "elongation is in K, but [m] is needed" in str(told.value)
    assert "heat_flow is in rad/s, but [W] is needed" in str(told.value)


@pytest.mark.parametrize(
    ("fmus", "names", "sentence"),
    [
        (["link"], [], "--replace link: no value; write --replace link=My.fmu"),
        (["link=a.fmu"], ["motor.speed=w"], "--map motor.speed: is of no part that --replace names"),
        (["lunk=a.fmu"], [], "--replace lunk: no part of WarmupCell; did you mean link"),
        (["link=a.fmu"], [], "a.fmu: no such file"),
    ],
)
def test_bad_pairs_are_refused(fmus: list[str], names: list[str], sentence: str) -> None:
    with pytest.raises(InputError) as told:
        with_replaced(cell(), Replacements.given(fmus, names))
    assert sentence in str(told.value)


def test_the_interface_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    list_(["interface", "ThermalLink"], json=True)
    said = capsys.readouterr().out
    assert '"heat_flow [W]"' in said
    assert '"sensor_temperature[8] [K]"' in said
    list_(["interface", "ThermalLink"])
    told = capsys.readouterr().out
    for shown in ("speed [rad/s] ", "elongation [m] ", "sensor_temperature[8] [K] "):
        assert shown in told
    with pytest.raises(InputError, match="no such component; did you mean"):
        list_(["interface", "ThermalLnk"])
    with pytest.raises(InputError, match="nothing to list"):
        list_(["interfaces", "ThermalLink"])
