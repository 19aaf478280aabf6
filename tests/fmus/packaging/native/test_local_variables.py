"""Local variables of native FMUs show the heat flows inside, in FMI 2.0 and 3.0, and change nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description

from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion, native_fmu_files
from warmlink.fmus.packaging.native.groups import output_groups
from warmlink.fmus.packaging.views import exchanged_states, opened
from warmlink.fmus.thermal_link.equations import stretches

from .conftest import BuildNative
from .running import Native, refused

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
OPEN = [name for name, component in COMPONENTS.items() if component.local]
INPUTS = {
    "MotorHeatSource": {"speed": 3.43, "torque": 2.5, "pad_mode": 2, "pad_temperature": 303.15},
    "ThermalLink": {"heat_flow": 5.0, "speed": 3.0, "ambient_temperature": 290.0, "tip_conductance": 0.2},
}
both = pytest.mark.parametrize("version", ["2.0", "3.0"])


def ran(path: Path, name: str) -> Native:
    """An instance after a minute."""
    native = Native(path, COMPONENTS[name])
    native.set(INPUTS[name])
    if name == "ThermalLink":
        native.set({"hub_conductance": 0.1, "tip_sink_temperature": 280.0, "emissivity": 0.5})
    native.initialize()
    for i in range(60):
        native.step(float(i), 1.0)
    return native


@pytest.fixture(params=["2.0", "3.0"])
def motor(request: pytest.FixtureRequest, native_fmu: BuildNative) -> Iterator[Native]:
    native = ran(native_fmu("MotorHeatSource", request.param), "MotorHeatSource")
    yield native
    native.close()


def rates(native: Native, name: str) -> np.ndarray:
    references = [state.rate.reference for state in exchanged_states(opened(COMPONENTS[name]))]
    return np.array(getattr(native.fmu, "getFloat64" if native.modern else "getReal")(references))


def test_flows_into_each_lump_of_the_motor_warm_it(motor: Native) -> None:
    winding, shaft, _ = rates(motor, "MotorHeatSource")
    copper, iron, friction, pad, inward, outward = (
        motor.get(name)
        for name in (
            "copper_loss",
            "iron_loss",
            "friction_loss",
            "pad_heat_flow",
            "winding_heat_flow",
            "housing_heat_flow",
        )
    )
    assert min(copper, iron, friction, pad, inward, outward) > 0
    assert 200 * winding == pytest.approx(copper + iron - inward, rel=1e-12)
    left = outward + motor.get("heat_flow") + motor.get("neighbour_heat_flow")
    assert 1500 * shaft == pytest.approx(inward + friction + pad - left, rel=1e-12)


@both
def test_flows_into_each_node_of_the_link_warm_it(version: FmiVersion, native_fmu: BuildNative) -> None:
    link = COMPONENTS["ThermalLink"]
    native = ran(native_fmu("ThermalLink", version), "ThermalLink")
    conducted, lost = (
        np.array([native.get(f"{name}[{i}]") for i in range(1, count + 1)])
        for name, count in (("conducted_heat_flow", 39), ("surface_heat_flow", 40))
    )
    gain = np.concatenate([[0.0], conducted]) - np.concatenate([conducted, [0.0]]) - lost
    base, tip = stretches(40)
    gain[base] += native.get("heat_flow") - native.get("hub_heat_flow")
    gain[tip] -= native.get("tip_sink_heat_flow")
    assert min(native.get("hub_heat_flow"), native.get("tip_sink_heat_flow")) > 0
    capacity = link.d.values(link.settled(link.start_values()[0]))["heat_capacity"]
    np.testing.assert_allclose(rates(native, "ThermalLink")[:40] * capacity, gain, rtol=1e-9, atol=1e-12)
    assert sum(lost) == pytest.approx(native.get("surface_heat_loss"), rel=1e-12)
    native.close()


@pytest.mark.parametrize("name", OPEN)
def test_nothing_that_is_read_is_computed_with_them(name: str) -> None:
    component = COMPONENTS[name]
    groups = output_groups(opened(component))
    assert groups[:-1] == output_groups(component)
    assert groups[-1] == list(range(component.y.size, opened(component).y.size))


@both
def test_they_are_no_outputs(version: FmiVersion, native_fmu: BuildNative) -> None:
    description = read_model_description(str(native_fmu("MotorHeatSource", version)))
    structure = {unknown.variable.name for unknown in [*description.outputs, *description.initialUnknowns]}
    found = {v.name: v for v in description.modelVariables if v.causality == "local"}
    for local in COMPONENTS["MotorHeatSource"].local:
        assert found[local.name].initial == "calculated"
        assert local.name not in structure


def test_they_have_no_derivatives_and_cannot_be_set(motor: Native) -> None:
    reference, speed = motor.references(["copper_loss", "speed"])
    assert "is no output" in refused(
        motor, lambda: motor.fmu.getDirectionalDerivative([reference], [speed], [1.0])
    )
    assert "no derivative of order 1" in refused(
        motor,
        lambda: (motor.fmu.getOutputDerivatives if motor.modern else motor.fmu.getRealOutputDerivatives)(
            [reference], [1]
        ),
    )
    assert "cannot be set" in refused(motor, lambda: motor.set({"copper_loss": 1.0}))


def test_outputs_are_the_same_without_them(motor: Native, c_compiler: Compiler, tmp_path: Path) -> None:
    entry = Entry(
        replace(COMPONENTS["MotorHeatSource"], look_inside=None), "fmus.motor_heat_source.component"
    )
    path = tmp_path / "MotorHeatSource.fmu"
    write_archive(path, native_fmu_files(entry, "3.0" if motor.modern else "2.0", [c_compiler]))
    closed = ran(path, "MotorHeatSource")
    for name in COMPONENTS["MotorHeatSource"].y.names:
        assert motor.get(name) == closed.get(name)
    closed.close()
