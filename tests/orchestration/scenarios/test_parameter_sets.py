"""Values of a parameter set (SSV) are read as the same values in text are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.scenarios.overrides import parameters_of
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.scenarios.system_values import Written, _typed, with_parameters
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import FmuVariable
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import Unit, parse_unit
from warmlink.orchestration.written.quantities import quantity

OWN = Unit("calorie", parse_unit("J").exponents, 4.184)


def by_file(folder: Path, name: str, value: float, unit: Unit | None) -> object:
    write_ssv({name: SsvValue(name, "Real", value, unit)}, path := folder / "set.ssv")
    instance, _, variable = name.partition(".")
    return changed(load_scenario("continuous"), parameters=path).values()[instance][variable]


@pytest.mark.parametrize(
    ("name", "value", "unit", "si"),
    [
        ("motor.ambient_offset", 0.5, "degC", 0.5),
        ("sensors.offset[1]", 0.5, "degC", 0.5),
        ("sensors.offset[1]", 0.5, "K", 0.5),
        ("link.initial_temperature", 25.0, "degC", 298.15),
        ("link.length", 400.0, "mm", 0.4),
    ],
)
def test_a_difference_is_none_of_temperatures_from_zero(
    tmp_path: Path, name: str, value: float, unit: str, si: float
) -> None:
    """An offset of 0.5 degC was 273.65 K."""
    assert by_file(tmp_path, name, value, parse_unit(unit)) == pytest.approx(si)


@pytest.mark.parametrize("unit", ["kg", "degC", "1"])
def test_a_unit_of_another_quantity_is_refused(tmp_path: Path, unit: str) -> None:
    """2 kg were taken as 2 W/K."""
    with pytest.raises(InputError, match=f"joint_conductance: {unit} does not convert to W/K"):
        by_file(tmp_path, "motor.joint_conductance", 2.0, parse_unit(unit))


def test_a_unit_of_the_files_own_is_converted(tmp_path: Path) -> None:
    write_ssv({"a.b": SsvValue("a.b", "Real", 2.0, OWN), "c": 3.0}, path := tmp_path / "set.ssv")
    heat, number = parameters_of(path).values()
    assert quantity(heat, "J") == pytest.approx(8.368)
    assert number == 3.0


def test_where_a_wrong_unit_of_a_system_s_value_stands_is_said(tmp_path: Path) -> None:
    fmu = FmuStore("native").files(["ThermalLink"])["ThermalLink"]
    write_ssv({"length": SsvValue("length", "Real", 2.0, parse_unit("kg"))}, path := tmp_path / "set.ssv")
    with pytest.raises(InputError, match=r"set\.ssv: length: kg does not convert to m; give it in m"):
        with_parameters(read_system(fmu, tmp_path), path)


@pytest.mark.parametrize("given", [2**53 + 1, str(2**53 + 1), -(2**63) + 1, 2**63 - 1, np.int64(2**53 + 1)])
def test_a_whole_number_of_64_bits_is_kept(given: Written) -> None:
    """It went through a float, which has 53."""
    variable = FmuVariable("p", 0, "Int64", "Integer", "parameter", "fixed")
    assert _typed(given, variable, None, "p") == int(given)
