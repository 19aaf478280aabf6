"""What an FMU says of itself: its variables, what depends on what, and what a master may ask of it.

A lean reading of modelDescription.xml (FMI 2.0 section 2.2, FMI 3.0 section 2.4; what is of FMI 1.0 is put
into the words of 2.0 first), safe for files made by
strangers and quick enough to be done at every start.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.attributes import inputs_accepting_nan
from warmlink.fmus.packaging.cache import remembered
from warmlink.orchestration.system import archive, xml
from warmlink.orchestration.system.fmi1 import in_words_of_fmi2
from warmlink.orchestration.system.model import (
    TYPES,
    Capabilities,
    ClockTicks,
    ConnectorType,
    DefaultExperiment,
    FmuVariable,
    ModelInfo,
    Value,
)
from warmlink.orchestration.system.model_structure import outputs_of, sizes_of
from warmlink.orchestration.system.units import definitions_of_units
from warmlink.orchestration.text_files import demand_file

_MOST_ELEMENTS = 100_000
"""Variables of one FMU, beyond which arrays are not taken apart."""

# The attribute that tells each capability, in FMI 2.0 and in 3.0; one of them may not know it.
_FLAGS = {
    "variable_step": ("canHandleVariableCommunicationStepSize",) * 2,
    "once_per_process": ("canBeInstantiatedOnlyOncePerProcess",) * 2,
    "get_set_state": ("canGetAndSetFMUstate", "canGetAndSetFMUState"),
    "serialize_state": ("canSerializeFMUstate", "canSerializeFMUState"),
    "directional_derivatives": ("providesDirectionalDerivative", "providesDirectionalDerivatives"),
    "interpolate_inputs": ("canInterpolateInputs",) * 2,
    "intermediate_update": ("providesIntermediateUpdate",) * 2,
    "event_mode": ("hasEventMode",) * 2,
}


def read_description(fmu: Path) -> ModelInfo:
    """Read an FMU's modelDescription.xml; the same unchanged file is read once in a process.

    InputError if the file is absent, not a zip, not an FMU, damaged, or offers neither co-simulation nor
    model exchange.
    """
    demand_file(fmu, "give the path of an .fmu file")
    facts = fmu.stat()
    return _read_cached(fmu.resolve(), (facts.st_mtime_ns, facts.st_ctime_ns, facts.st_size))


@lru_cache(maxsize=256)
def _read_cached(fmu: Path, _facts: tuple[int, int, int]) -> ModelInfo:
    where = f"{fmu.name}: modelDescription.xml"
    text = archive.read_member(fmu, "modelDescription.xml")
    # By what it says alone: FMUs of a system are unpacked into another folder for each run.
    said = hashlib.sha256(text).hexdigest()
    info = remembered("descriptions", said, lambda: _parsed(text, fmu, where))
    remarks = *(f"{where}: {each}" for each in info.remarks), *archive.repeated_entries(fmu)
    return replace(info, path=fmu, remarks=remarks)


def _parsed(text: bytes, fmu: Path, where: str) -> ModelInfo:
    remarks: list[str] = []
    root = xml.parse_xml(text, where, remarks)
    if root.get("fmiVersion") == "1.0":
        root = in_words_of_fmi2(root, where, remarks)
    found = parse_description(root, fmu, where)
    return replace(found, remarks=tuple(remarks))


def parse_description(root: Any, fmu: Path, where: str, other_sizes: bool = False) -> ModelInfo:
    """Give the description that an `fmiModelDescription` element holds; `where` names it in errors.

    With `other_sizes` of arrays than those of the file, arrays may have start values that do not fit; the FMU
    is then asked for its own.
    """
    version = root.get("fmiVersion", "")
    if root.tag != "fmiModelDescription" or not version.startswith(("1.0", "2.", "3.")):
        raise InputError(
            f"{where}: FMI version {version!r} is not supported; give an FMU of FMI 1.0, 2.0 or 3.0"
        )
    major = max(2, int(version[0]))
    interfaces = {
        kind: (xml.required(held, "modelIdentifier", where), _capabilities(held, major, where))
        for kind in ("CoSimulation", "ModelExchange", "ScheduledExecution")
        if (held := root.find(kind)) is not None
    }
    if not interfaces:
        raise InputError(f"{where}: offers no interface; export the model for co-simulation")
    interface: Any = next(iter(interfaces))
    identifier, capabilities = interfaces.pop(interface)
    experiment = root.find("DefaultExperiment")
    variables, by_key, arrays = _read_variables(root, major, where, other_sizes)
    outputs = outputs_of(root, major, by_key, where)
    sizes = sizes_of(root, major, by_key, variables, where)
    return ModelInfo(
        path=fmu,
        fmi_version=f"{version[0]}.0",
        model_name=xml.required(root, "modelName", where),
        model_identifier=identifier,
        guid=xml.required(root, "guid" if major == 2 else "instantiationToken", where),
        description=root.get("description", ""),
        variables=variables,
        outputs=tuple(outputs),
        dependencies=outputs,
        capabilities=capabilities,
        default_experiment=DefaultExperiment(
            xml.optional(experiment, "startTime", xml.number, where) or 0.0,
            xml.optional(experiment, "stopTime", xml.number, where),
            xml.optional(experiment, "stepSize", xml.number, where),
            xml.optional(experiment, "tolerance", xml.number, where),
        ),
        units=definitions_of_units(root, where, "UnitDefinitions"),
        log_categories=tuple(each.get("name", "") for each in root.iterfind("LogCategories/Category")),
        arrays=arrays,
        accepts_nan=inputs_accepting_nan(root),
        interface=interface,
        exchange=interfaces.get("ModelExchange"),
        continuous_states=sizes[0],
        event_indicators=sizes[1],
    )


def _capabilities(interface: Any, major: int, where: str) -> Capabilities:
    """Give what an FMU can do as one of its interfaces; a model takes steps of any size."""
    flags = {
        name: xml.optional(interface, words[major - 2], xml.truth, where) or False
        for name, words in _FLAGS.items()
    }
    if interface.tag != "CoSimulation":
        flags["variable_step"] = True
    return Capabilities(
        **flags, internal_step=xml.optional(interface, "fixedInternalStepSize", xml.number, where)
    )


def _read_variables(
    root: Any, major: int, where: str, other_sizes: bool
) -> tuple[dict[str, FmuVariable], dict[int, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Give the variables by name, the names by what ModelStructure refers to, and the arrays' elements.

    ModelStructure refers to indices in FMI 2.0, and to value references in FMI 3.0.
    """
    # The attributes of a declared type stand in a child of its element in FMI 2.0.
    declared = root.iterfind("TypeDefinitions/SimpleType" if major == 2 else "TypeDefinitions/*")
    types = {t.get("name"): t[0] if major == 2 else t for t in declared if major == 3 or len(t)}
    types.pop(None, None)  # one without a name is no variable's
    variables: dict[str, FmuVariable] = {}
    by_key: dict[int, tuple[str, ...]] = {}
    arrays: dict[str, tuple[str, ...]] = {}
    elements = [each for held in root.iterfind("ModelVariables") for each in held]
    sizes = {e.get("valueReference", ""): e.get("start", "") for e in elements}
    for index, element in enumerate(elements, start=1):
        variable = _variable(element, types, major, sizes, where)
        for name in [variable.name, *(xml.required(a, "name", where) for a in element.iterfind("Alias"))]:
            most = _MOST_ELEMENTS - len(variables)
            scalars = _scalars(replace(variable, name=name), element, where, most, other_sizes)
            for scalar in scalars:
                if scalar.name in variables:
                    raise InputError(
                        f"{where}: declares the variable {scalar.name} twice; names must be unique"
                    )
                variables[scalar.name] = scalar
            names = tuple(scalar.name for scalar in scalars)
            if variable.dimensions:
                arrays[name] = names
            by_key.setdefault(index if major == 2 else variable.value_reference, names)
    return variables, by_key, arrays


def _typed(
    element: Any, types: dict[str, Any], major: int, where: str
) -> tuple[Any, dict[str, str], dict[str, int]]:
    """Give the element that tells a variable's type, all that it and its declared type say, and its items."""
    typed = element if major == 3 else next((child for child in element if child.tag in TYPES), None)
    if typed is None:
        raise InputError(f"{where}: has no type")
    name = typed.get("declaredType")
    if name is not None and name not in types:
        raise InputError(f"{where}: its declared type {name} is not defined")
    declared = types.get(name, typed)
    items = {
        xml.required(item, "name", where): xml.integer(xml.required(item, "value", where), where)
        for item in declared.iterfind("Item")
    }
    return typed, {**declared.attrib, **typed.attrib}, items


def _variable(
    element: Any, types: dict[str, Any], major: int, sizes: dict[str, str], where: str
) -> FmuVariable:
    """Give a variable, or an array without its start values; `sizes` are starts by value reference."""
    name = xml.required(element, "name", where)
    where = f"{where}: {name}"
    typed, said, items = _typed(element, types, major, where)
    kind, causality = TYPES.get(typed.tag), element.get("causality", "local")

    def bound(key: str) -> float | None:
        text = said.get(key) if kind in ("Real", "Integer", "Enumeration") else None
        value = math.inf if text is None else xml.any_number(text, where)
        if text is not None and kind != "Real" and value.is_integer():
            with suppress(ValueError):
                return int(text)  # of 64 bits, which a float does not hold
        return value if math.isfinite(value) else None

    reference = xml.integer(xml.required(element, "valueReference", where), where)
    if not 0 <= reference < 1 << 32:
        ends = f"not between 0 and {(1 << 32) - 1}"
        raise InputError(f"{where}: the valueReference {reference} is {ends}; export the FMU anew")
    dimensions = tuple(
        xml.integer(d.get("start") or sizes.get(d.get("valueReference", "")) or "0", where)
        for d in element.iterfind("Dimension")
    )
    variability, initial = _defaults(typed.tag, causality, element.get("variability"))
    starts = () if dimensions or kind is None else _starts(typed, kind, where)
    return FmuVariable(
        name=name,
        value_reference=reference,
        type=typed.tag,
        kind=kind,
        causality=causality,
        variability=variability,
        initial=element.get("initial") or initial,
        unit=(said.get("unit") or None) if kind == "Real" else None,
        start=starts[0] if starts else None,
        min=bound("min"),
        max=bound("max"),
        nominal=bound("nominal"),
        relative=kind == "Real" and said.get("relativeQuantity") in ("true", "1"),
        description=element.get("description", ""),
        items=items if kind == "Enumeration" else {},
        dimensions=dimensions,
        negated=element.get("alias") == "negatedAlias",
        clock=_ticks(name, said, where) if typed.tag == "Clock" else None,
    )


def _ticks(name: str, said: Mapping[str, str], where: str) -> ClockTicks:
    """Give when a clock ticks."""
    texts = {key: said.get(key) for key in ("intervalDecimal", "shiftDecimal")}
    interval, shift = (None if text is None else xml.number(text, where) for text in texts.values())
    priority = xml.integer(said.get("priority", "0"), where)
    return ClockTicks(name, said.get("intervalVariability", "triggered"), interval, shift or 0.0, priority)


def _defaults(fmi_type: str, causality: str, variability: str | None) -> tuple[str, str | None]:
    """Give variability and initial with their defaults (FMI 2.0 section 2.2.7; FMI 3.0 table 22)."""
    parameters = ("parameter", "structuralParameter")
    if not variability:
        # FMI 2.0 has one default for all types; FMI 3.0 one for parameters, one for floats, one for the rest.
        other = "continuous" if TYPES.get(fmi_type) == "Real" else "discrete"
        fixed = fmi_type != "Real" and causality in (*parameters, "calculatedParameter")
        variability = "fixed" if fixed else other
    if causality == "independent":
        return variability, None
    exact = variability == "constant" or causality in (*parameters, "input")
    return variability, "exact" if exact else "calculated"


def _starts(typed: Any, kind: ConnectorType, where: str, array: bool = False) -> list[Value]:
    """Give the start values of a variable, which are several for an array."""
    text = typed.get("start")
    texts = [held.get("value", "") for held in typed.iterfind("Start")]
    if text is not None and not (array and texts):
        texts = text.split() if array else [text]
    if kind == "Real":
        return [xml.any_number(text, where) for text in texts]
    if kind in ("Integer", "Enumeration"):
        return [xml.integer(text, where) for text in texts]
    return [xml.truth(text, f"{where}: start") if kind == "Boolean" else text for text in texts]


def _scalars(
    variable: FmuVariable, element: Any, where: str, most: int, other_sizes: bool
) -> list[FmuVariable]:
    """Give the elements of an array; what is none, or has too many, stays as it is."""
    sizes, count = variable.dimensions, math.prod(variable.dimensions)
    if not sizes or variable.kind is None or count > most:
        return [variable]
    where = f"{where}: {variable.name}"
    starts = _starts(element, variable.kind, where, array=True)
    if other_sizes and len(starts) not in (1, count):
        starts = []
    if len(starts) not in (0, 1, count):
        raise InputError(f"{where}: has {len(starts)} start values for {count} elements; give one for each")
    return [
        replace(
            variable,
            name=f"{variable.name}[{','.join(str(i + 1) for i in place)}]",
            start=starts[number % len(starts)] if starts else None,
            dimensions=(),
            element=number,
            elements=count,
        )
        for number, place in enumerate(product(*(range(size) for size in sizes)))
    ]
