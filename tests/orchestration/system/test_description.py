"""What an FMU says of itself, in both FMI versions, beside FMPy's reading of the same file."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import DefaultExperiment

from .ssp_text import LINK, Lab, fmi2, fmi2_variable

STRUCTURE = (
    '<Outputs><Unknown index="5" dependencies="1 2"/><Unknown index="6" dependencies=""/></Outputs>'
    '<InitialUnknowns><Unknown index="5"/><Unknown index="12" dependencies="7"/></InitialUnknowns>'
)
FMI3 = """
<fmiModelDescription fmiVersion="3.0" modelName="Link" instantiationToken="{token}">
  <CoSimulation modelIdentifier="link3" canGetAndSetFMUState="true" canSerializeFMUState="true"
    providesDirectionalDerivatives="true" providesIntermediateUpdate="true" hasEventMode="true"
    canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="0.5"/>
  <UnitDefinitions><Unit name="K"><BaseUnit K="1"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <Float64Type name="Temperature" unit="K" min="0" nominal="300" relativeQuantity="true"/>
    <EnumerationType name="Metal">
      <Item name="steel" value="1"/><Item name="brass" value="2"/>
    </EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="ambient" valueReference="1" causality="input" declaredType="Temperature" start="295"/>
    <Float64 name="temperature" valueReference="2" causality="output" unit="K">
      <Alias name="tip_temperature"/>
    </Float64>
    <Float32 name="length" valueReference="3" causality="parameter" start="0.33" max="INF"/>
    <UInt8 name="cells" valueReference="4" causality="parameter" start="40" min="2" max="200"/>
    <Boolean name="radiates" valueReference="5" causality="parameter" start="true"/>
    <String name="label" valueReference="6" causality="parameter"><Start value="rod"/></String>
    <Enumeration name="metal" valueReference="7" causality="parameter" declaredType="Metal" start="2"/>
    <Float64 name="field" valueReference="8" causality="input" start="1 2 3"><Dimension start="3"/></Float64>
    <Binary name="image" valueReference="9" causality="output"/>
    <Clock name="tick" valueReference="11" causality="output" intervalVariability="triggered"/>
    <Int64 name="count" valueReference="10" causality="output"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="2" dependencies="1"/><Output valueReference="10"/>
    <InitialUnknown valueReference="2" dependencies="3 1"/>
  </ModelStructure>
</fmiModelDescription>"""


@pytest.fixture
def two(lab: Lab) -> ModelInfo:
    return read_description(lab.fmu("Link", fmi2("Link", LINK, structure=STRUCTURE)))


@pytest.fixture
def three(lab: Lab) -> ModelInfo:
    return read_description(lab.fmu("Link3", FMI3))


def test_the_model_of_fmi_two(two: ModelInfo) -> None:
    assert (two.fmi_version, two.model_name, two.model_identifier, two.guid) == (
        "2.0",
        "Link",
        "Link",
        "{Link}",
    )
    assert two.default_experiment == DefaultExperiment(0.0, 10.0, 0.5, 1e-5)
    assert two.capabilities.get_set_state
    assert not two.capabilities.serialize_state
    assert two.units["degC"].offset == 273.15


def test_the_variables_of_fmi_two(two: ModelInfo) -> None:
    length = two.variables["length"]
    assert (length.value_reference, length.type, length.unit, length.start) == (6, "Real", "m", 0.33)
    assert (length.min, length.max, length.nominal) == (0.0, 10.0, None)
    assert (length.causality, length.variability, length.initial) == ("parameter", "fixed", "exact")
    assert two.variables["difference"].relative
    assert two.variables["metal"].items == {"steel": 1, "brass": 2}
    assert two.variables["radiates"].start is False
    assert two.variables["label"].start == "link"
    assert two.with_causality("output") == ("temperature", "elongation")


def test_dependencies_and_what_is_not_declared(two: ModelInfo) -> None:
    assert two.outputs == ("temperature", "elongation")
    assert two.dependencies == {"temperature": ("heat_flow", "ambient"), "elongation": ()}
    assert two.feedthrough("temperature") == {"heat_flow", "ambient"}
    assert two.feedthrough("elongation") == frozenset()
    assert two.feedthrough("rate") == {"heat_flow", "ambient", "difference", "mode"}


def test_the_model_of_fmi_three(three: ModelInfo) -> None:
    assert (three.fmi_version, three.model_identifier, three.guid) == ("3.0", "link3", "{token}")
    has = three.capabilities
    assert has.get_set_state
    assert has.serialize_state
    assert has.directional_derivatives
    assert has.intermediate_update
    assert has.variable_step


def test_the_variables_of_fmi_three(three: ModelInfo) -> None:
    kinds = {name: (v.type, v.kind) for name, v in three.variables.items()}
    assert kinds["length"] == ("Float32", "Real")
    assert kinds["cells"] == ("UInt8", "Integer")
    assert kinds["image"] == ("Binary", "Binary")
    assert kinds["tick"] == ("Clock", None)
    ambient = three.variables["ambient"]
    assert (ambient.unit, ambient.min, ambient.nominal, ambient.relative) == ("K", 0.0, 300.0, True)
    assert (ambient.variability, ambient.initial, ambient.settable) == ("continuous", "exact", True)
    assert three.variables["cells"].variability == "fixed"
    assert three.variables["count"].variability == "discrete"
    assert three.variables["length"].max is None
    assert three.variables["label"].start == "rod"
    assert three.variables["metal"].start == 2
    assert three.arrays == {"field": ("field[1]", "field[2]", "field[3]")}
    assert [three.variables[name].start for name in three.arrays["field"]] == [1.0, 2.0, 3.0]
    assert three.variables["tip_temperature"].value_reference == 2
    assert three.dependencies == {"temperature": ("ambient",), "count": None}


@pytest.mark.parametrize("text", [fmi2("Link", LINK, structure=STRUCTURE), FMI3], ids=["fmi2", "fmi3"])
def test_fmpy_reads_the_same(lab: Lab, text: str) -> None:
    fmpy = pytest.importorskip("fmpy")
    path = lab.fmu("Link", text)
    ours, theirs = read_description(path), fmpy.read_model_description(path, validate=False)
    assert ours.guid == theirs.guid
    elements = {name for names in ours.arrays.values() for name in names}
    assert {v.name for v in theirs.modelVariables} == ours.variables.keys() - elements | ours.arrays.keys()
    for other in theirs.modelVariables:
        mine = ours.variables[ours.arrays.get(other.name, (other.name,))[0]]
        assert mine.value_reference == other.valueReference
        assert (mine.type, mine.causality) == (other.type, other.causality)
        if other.type in ("Real", "Float64"):
            assert (mine.variability, mine.initial) == (other.variability, other.initial)
    assert [u.variable.name for u in theirs.outputs] == list(ours.outputs)
    for unknown in theirs.outputs:
        names = None if unknown.dependencies is None else tuple(d.name for d in unknown.dependencies)
        assert ours.dependencies[unknown.variable.name] == names


@pytest.mark.parametrize("model", ["Rod", "Line"])
def test_the_same_file_is_read_once_and_a_changed_one_again(lab: Lab, model: str) -> None:
    path = lab.fmu("Link", fmi2("Link", LINK))
    os.utime(path, (1e9, 1e9))  # as some tools do, for archives of equal bytes
    first = read_description(path)
    assert read_description(path) is first
    lab.fmu("Link", fmi2(model, LINK))
    os.utime(path, (1e9, 1e9))
    assert read_description(path).model_name == model


def test_what_is_kept_of_an_fmu_is_kept_once_wherever_it_lies(
    lab: Lab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path / "cache"))
    path = lab.fmu("Link", fmi2("Link", LINK))
    for folder in ("one", "two", "three"):
        (tmp_path / folder).mkdir()
        copy = tmp_path / folder / path.name
        copy.write_bytes(path.read_bytes())
        assert read_description(copy).path == copy
    kept = (tmp_path / "cache" / "descriptions").iterdir()
    assert len([file for file in kept if file.suffix != ".lock"]) == 1


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("modelName=", "model="), "fmiModelDescription lacks its attribute modelName"),
        (('guid="', 'uid="'), "fmiModelDescription lacks its attribute guid"),
        (("modelIdentifier", "identifier"), "CoSimulation lacks its attribute modelIdentifier"),
        (('valueReference="0"', 'valueReference="x"'), "heat_flow: 'x' is not an integer of 64 bits"),
        (
            ('name="ambient"', 'name="heat_flow"'),
            "declares the variable heat_flow twice; names must be unique",
        ),
        (('min="0"', 'min="low"'), "length: 'low' is not a number"),
        (('start="40"', 'start="4.5"'), "cells: '4.5' is not an integer of 64 bits"),
        (('declaredType="Metal"', 'declaredType="Wood"'), "metal: its declared type Wood is not defined"),
        (('dependencies="1 2"', 'dependencies="1 99"'), "refers to variable 99, which is not declared"),
        (('canGetAndSetFMUstate="true"', 'canGetAndSetFMUstate="yes"'), "is 'yes', neither true nor false"),
    ],
)
def test_a_damaged_description_is_named(lab: Lab, change: tuple[str, str], sentence: str) -> None:
    text = fmi2("Link", LINK, structure=STRUCTURE)
    assert change[0] in text
    with pytest.raises(InputError) as refusal:
        read_description(lab.fmu("Link", text.replace(*change)))
    assert str(refusal.value).startswith("Link.fmu: modelDescription.xml: ")
    assert str(refusal.value).endswith(sentence)


def test_a_declared_type_without_a_name_is_nobodys(lab: Lab) -> None:
    text = fmi2("Link", LINK, structure=STRUCTURE)
    nameless = text.replace("<SimpleType", '<SimpleType><Real min="1000"/></SimpleType><SimpleType', 1)
    assert nameless != text
    assert read_description(lab.fmu("Link", nameless)).variables["ambient"].min is None


def test_a_variable_without_type_is_named(lab: Lab) -> None:
    bare = fmi2_variable("a", "input", "Complex")
    with pytest.raises(InputError, match=": a: has no type"):
        read_description(lab.fmu("Link", fmi2("Link", (bare,))))


def test_an_absent_fmu_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_description(tmp_path / "none.fmu")


@pytest.mark.parametrize("reference", [-1, 1 << 32, 99999999999])
def test_a_value_reference_that_does_not_fit_into_32_bits_is_refused(lab: Lab, reference: int) -> None:
    text = FMI3.replace('name="ambient" valueReference="1"', f'name="ambient" valueReference="{reference}"')
    assert text != FMI3
    with pytest.raises(
        InputError, match=f"ambient: the valueReference {reference} is not between 0 and 4294967295"
    ):
        read_description(lab.fmu("Link3", text))
    text = fmi2("Link", LINK).replace('valueReference="1"', f'valueReference="{reference}"', 1)
    with pytest.raises(InputError, match=f"the valueReference {reference} is not between 0 and 4294967295"):
        read_description(lab.fmu("Link", text))
