"""Model descriptions of FMI 2.0 and 3.0."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Scalar
from warmlink.fmus.component.dependencies import TIME, dependencies
from warmlink.fmus.component.table import RecordedTable
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.attributes import inputs_accepting_nan
from warmlink.fmus.packaging.model_description import (
    instantiation_token,
    model_description,
    time_reference,
)
from warmlink.fmus.packaging.views import opened
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

COMPONENTS = [entry.component for entry in catalogue()]
WRITERS: dict[str, Callable[..., bytes]] = {
    "fmi2": model_description,
    "fmi3": partial(model_description, fmi_version="3.0"),
}
FORMS: tuple[tuple[str, dict[str, bool]], ...] = (
    ("fmi2", {"native": False}),
    ("fmi2", {"native": True}),
    ("fmi3", {"arrays": False}),
    ("fmi3", {"arrays": True}),
)
every = pytest.mark.parametrize("component", COMPONENTS, ids=lambda c: c.name)
both = pytest.mark.parametrize("fmi", WRITERS)


def read(xml: bytes) -> Any:
    import fmpy

    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("modelDescription.xml", xml)
    return fmpy.read_model_description(archive)


@every
@pytest.mark.parametrize(("fmi", "form"), FORMS)
def test_schema_and_fmpy_find_nothing(component: Component, fmi: str, form: dict[str, bool]) -> None:
    import fmpy
    from fmpy.validation import validate_model_description
    from lxml import etree

    folder = Path(fmpy.__file__).parent / "schema" / fmi
    schema = etree.XMLSchema(etree.parse(str(folder / f"{fmi}ModelDescription.xsd")))
    xml = WRITERS[fmi](opened(component), **form)
    schema.assertValid(etree.fromstring(xml))
    assert validate_model_description(read(xml), validate_model_structure=True) == []


@every
@both
def test_every_scalar_is_there_as_declared(component: Component, fmi: str) -> None:
    told = read(WRITERS[fmi](component)).modelVariables
    variables = {v.name: v for v in told if v.causality not in ("independent", "local")}
    scalars = list(component.scalars())
    assert list(variables) == [s.name for s in scalars]
    for scalar in scalars:
        found = variables[scalar.name]
        assert found.valueReference == scalar.reference
        assert found.causality == type(scalar.variable).__name__.lower()
        assert found.description == scalar.variable.description
        if scalar.variable.type == "Real":
            assert found.unit == scalar.variable.unit
            assert found.displayUnit == scalar.variable.display
        if scalar.start is not None and scalar.variable.type != "Boolean":
            assert float(found.start) == scalar.start
        bounds = (scalar.lower, scalar.variable.maximum)
        stated = (found.min, found.max)
        if scalar.variable.type != "Boolean":
            assert tuple(None if b is None else float(b) for b in stated) == bounds


def test_quantities_and_choices_are_declared_types() -> None:
    two, three = (ET.fromstring(write(MOTOR)) for write in WRITERS.values())
    names = ("none", "power", "temperature")
    pad = three.find("ModelVariables/Enumeration[@name='pad_mode']")
    assert pad is not None
    assert [pad.get(key) for key in ("declaredType", "start", "min", "max")] == ["PadMode", "0", "0", "2"]
    items = three.findall("TypeDefinitions/EnumerationType[@name='PadMode']/Item")
    assert [(i.get("name"), i.get("value")) for i in items] == [(n, str(i)) for i, n in enumerate(names)]
    # libcosim passes over variables that are enumerations in FMI 2.0, and could not set them.
    integer = two.find("ModelVariables/ScalarVariable[@name='pad_mode']/Integer")
    assert integer is not None
    assert integer.get("declaredType") == "PadMode"
    told = two.find("TypeDefinitions/SimpleType[@name='PadMode']")
    assert told is not None
    assert told.get("description") == "0 none, 1 power, 2 temperature"
    for root, path in ((two, "SimpleType/Real[@quantity='{}']"), (three, "Float64Type[@quantity='{}']")):
        for name, unit in (("Power", "W"), ("ThermodynamicTemperature", "K"), ("TemperatureDifference", "K")):
            (found,) = root.findall("TypeDefinitions/" + path.format(name))
            assert found.get("unit") == unit
            relative = "true" if name == "TemperatureDifference" else None
            assert found.get("relativeQuantity") == relative


@every
def test_bounds_of_a_choice_are_those_of_its_items(component: Component) -> None:
    for variable in (*component.inputs, *component.parameters):
        if variable.choice is not None:
            assert (variable.minimum, variable.maximum) == (0, variable.choice.last)


def test_fmi3_has_time_after_the_component_s_own() -> None:
    description = read(model_description(LINK, "3.0"))
    (time,) = [v for v in description.modelVariables if v.causality == "independent"]
    assert (time.name, time.valueReference, time.unit) == (TIME, time_reference(LINK), "s")
    (loss,) = [u for u in description.outputs if u.variable.name == "surface_heat_loss"]
    known = {v.name for v in loss.dependencies if v.causality != "local"}
    assert known == {"ambient_temperature", "speed", TIME}


def test_links_and_motors_close_no_loop_that_is_not_there() -> None:
    link, motor = dependencies(LINK).outputs, dependencies(MOTOR).outputs
    assert link["base_temperature"] == link["elongation"] == link["tip_temperature"] == ()
    assert motor["heat_flow"] == ("link_base_temperature",)


@both
def test_rates_depend_on_the_states_that_they_depend_on(fmi: str) -> None:
    description = read(WRITERS[fmi](LINK))
    assert description.modelExchange.modelIdentifier == description.coSimulation.modelIdentifier == LINK.name
    assert description.numberOfContinuousStates == LINK.x.size
    rates = {u.variable.name: {v.name for v in u.dependencies} for u in description.derivatives}
    assert rates["der(state.heat_received)"] == {"heat_flow"}
    near = {f"state.temperature[{i}]" for i in (19, 20, 21)}
    inputs = {"ambient_temperature", "speed"} | ({TIME} if fmi == "fmi3" else set())
    assert rates["der(state.temperature[20])"] == near | inputs
    (elongation,) = [u for u in description.outputs if u.variable.name == "elongation"]
    assert {v.name for v in elongation.dependencies} < {f"state.temperature[{i}]" for i in range(1, 41)}


def some(scalar: Scalar, rng: np.random.Generator) -> float:
    if scalar.variable.type != "Real":
        return float(rng.integers(0, 3 if scalar.variable.type == "Integer" else 2))
    return (scalar.start or 0.0) * rng.uniform(0.5, 1.5) + rng.uniform(0, 0.1)


@every
def test_time_acts_where_it_is_said_to(component: Component) -> None:
    rng = np.random.default_rng(3)
    moving = (
        replace(each, table=RecordedTable([0.0, 1.0], {name: [1.0, 2.0] for name in each.table.names}))
        for each in component.tables
    )
    component = replace(component, tables=tuple(moving))
    said = dependencies(component).outputs
    acting: set[str] = set()
    for _ in range(80):
        p = np.array(
            [some(scalar, rng) for scalar in component.scalars() if scalar.name in component.p.index]
        )
        settled = component.settled(p)
        u, x = rng.uniform(0.5, 300, component.u.size), rng.uniform(280, 330, component.x.size)
        before, after = (component.outputs_of(x, u, settled, t) for t in (0.0, rng.uniform(1, 2e4)))
        with np.errstate(invalid="ignore"):  # the variance of what is no covariance has no root
            same = np.isclose(before, after, rtol=0, atol=0, equal_nan=True)
        acting |= {name for name, equal in zip(component.y.names, same, strict=True) if not equal}
    assert acting == {name for name, known in said.items() if TIME in known}


def test_inputs_that_cope_with_nan_are_told_in_both_versions() -> None:
    law = next(c for c in COMPONENTS if c.name == "LagCompensator")
    expected = {s.name for s in law.scalars() if getattr(s.variable, "accepts_nan", False)}
    assert "tip_temperature" in expected
    for write in WRITERS.values():
        assert inputs_accepting_nan(ET.fromstring(write(law))) == expected
        assert inputs_accepting_nan(ET.fromstring(write(MOTOR))) == frozenset()


def test_the_token_follows_interface_and_implementation() -> None:
    token = instantiation_token(MOTOR)
    assert token == instantiation_token(replace(MOTOR, description="other words"))
    assert token != instantiation_token(MOTOR, "another implementation")
    assert token != instantiation_token(replace(MOTOR, outputs=MOTOR.outputs[:-1]))
    assert token.encode() in model_description(MOTOR)
    assert token.encode() in model_description(MOTOR, "3.0")


def test_differences_are_marked_and_absolute_temperatures_are_not() -> None:
    root = ET.fromstring(model_description(LINK))
    marked = {
        v.get("name")
        for v in root.iter("ScalarVariable")
        if v.find("Real[@relativeQuantity='true']") is not None
    }
    assert {"ambient_offset", "initial_temperature_rise[1]"} <= marked
    assert not {"initial_temperature", "reference_temperature", "tip_temperature"} & marked


@both
def test_the_date_is_that_of_the_sources(fmi: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def date() -> str | None:
        return ET.fromstring(WRITERS[fmi](MOTOR)).get("generationDateAndTime")

    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    assert date() == f"{release.DATE:%Y-%m-%d}T00:00:00Z"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert date() == "2023-11-14T22:13:20Z"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    assert date() == f"{release.DATE:%Y-%m-%d}T00:00:00Z"


def test_sources_and_capabilities_are_stated() -> None:
    two = model_description(MOTOR, sources=("fmi2.c", "model.c"))
    interface = read(two).coSimulation
    assert interface.modelIdentifier == MOTOR.name
    assert [file.get("name") for file in ET.fromstring(two).iterfind("CoSimulation//File")] == [
        "fmi2.c",
        "model.c",
    ]
    assert interface.canInterpolateInputs
    assert interface.providesDirectionalDerivative
    assert interface.maxOutputDerivativeOrder == 1
    assert not interface.needsExecutionTool
    three = model_description(MOTOR, "3.0")
    assert b'providesIntermediateUpdate="true"' in three
    assert b'name="pad_mode"' in three
    pad = next(line for line in three.splitlines() if b'name="pad_mode"' in line)
    assert b"intermediateUpdate" not in pad
