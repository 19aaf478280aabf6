"""What an FMU says of itself: its variables, what depends on what, and what a master may ask of it.

A lean reading of modelDescription.xml (FMI 2.0 section 2.2, FMI 3.0 section 2.4), safe for files made by
strangers and quick enough to be done at every start.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.attributes import inputs_accepting_nan
from warmlink.fmus.packaging.cache import remembered
from warmlink.orchestration.system import archive
from warmlink.orchestration.system.model import ConnectorType, DefaultExperiment, Value
from warmlink.orchestration.system.model_info import TYPES, Capabilities, ModelInfo, Variable
from warmlink.orchestration.system.units import definitions_of_units
from warmlink.orchestration.system.xml import (
    any_number,
    boolean,
    integer,
    optional_number,
    parse_xml,
    required,
    truth,
)
from warmlink.orchestration.text_files import is_file

_MOST_ELEMENTS = 100_000
"""Variables of one FMU, beyond which arrays are not taken apart."""

# The attribute that tells each capability, in FMI 2.0 and in 3.0; one of them may not know it.
_FLAGS = {
    "variable_step": ("canHandleVariableCommunicationStepSize", "canHandleVariableCommunicationStepSize"),
    "once_per_process": ("canBeInstantiatedOnlyOncePerProcess", "canBeInstantiatedOnlyOncePerProcess"),
    "get_set_state": ("canGetAndSetFMUstate", "canGetAndSetFMUState"),
    "serialize_state": ("canSerializeFMUstate", "canSerializeFMUState"),
    "directional_derivatives": ("providesDirectionalDerivative", "providesDirectionalDerivatives"),
    "interpolate_inputs": ("canInterpolateInputs", "canInterpolateInputs"),
    "intermediate_update": ("providesIntermediateUpdate", "providesIntermediateUpdate"),
}


def read_description(fmu: Path) -> ModelInfo:
    """Read an FMU's modelDescription.xml; the same unchanged file is read once in a process.

    Parameters
    ----------
    fmu
        Path of the .fmu file.

    Raises
    ------
    InputError
        If the file is absent, not a zip, not an FMU of FMI 2.0 or 3.0, damaged, or has no co-simulation.
    """
    if not is_file(fmu):
        raise InputError(f"{fmu}: no such file; give the path of an .fmu file")
    facts = fmu.stat()
    return _read_cached(fmu.resolve(), facts.st_mtime_ns, facts.st_size)


@lru_cache(maxsize=256)
def _read_cached(fmu: Path, _modified_ns: int, _size: int) -> ModelInfo:
    where = f"{fmu.name}: modelDescription.xml"
    text = archive.read_member(fmu, "modelDescription.xml")
    made_from = str(fmu), hashlib.sha256(text).hexdigest()
    return remembered(
        "descriptions", made_from, lambda: parse_description(parse_xml(text, where), fmu, where)
    )


def parse_description(root: Any, fmu: Path, where: str) -> ModelInfo:
    """Give the description that an `fmiModelDescription` element holds; `where` names it in errors."""
    version = root.get("fmiVersion", "")
    if root.tag != "fmiModelDescription" or not version.startswith(("2.", "3.")):
        raise InputError(f"{where}: FMI version {version!r} is not supported; give an FMU of FMI 2.0 or 3.0")
    major = int(version[0])
    slave = root.find("CoSimulation")
    if slave is None:
        kinds = [k for k in ("ModelExchange", "ScheduledExecution") if root.find(k) is not None]
        raise InputError(
            f"{where}: offers {' and '.join(kinds) or 'no interface'}, not co-simulation; "
            "export the model for co-simulation"
        )
    variables, by_key, arrays = _read_variables(root, major, where)
    outputs = _outputs(root, major, by_key, where)
    return ModelInfo(
        path=fmu,
        fmi_version=f"{major}.0",
        model_name=required(root, "modelName", where),
        model_identifier=required(slave, "modelIdentifier", where),
        guid=required(root, "guid" if major == 2 else "instantiationToken", where),
        description=root.get("description", ""),
        variables=variables,
        outputs=tuple(outputs),
        dependencies=outputs,
        capabilities=_capabilities(slave, major, where),
        default_experiment=_experiment(root.find("DefaultExperiment"), where),
        units=definitions_of_units(root.find("UnitDefinitions"), where),
        log_categories=tuple(each.get("name", "") for each in root.iterfind("LogCategories/Category")),
        arrays=arrays,
        accepts_nan=inputs_accepting_nan(root),
    )


def _experiment(element: Any, where: str) -> DefaultExperiment:
    if element is None:
        return DefaultExperiment()
    return DefaultExperiment(
        optional_number(element, "startTime", where) or 0.0,
        optional_number(element, "stopTime", where),
        optional_number(element, "stepSize", where),
    )


def _capabilities(slave: Any, major: int, where: str) -> Capabilities:
    return Capabilities(
        **{name: boolean(slave, words[major - 2], where, default=False) for name, words in _FLAGS.items()}
    )


def _read_variables(
    root: Any, major: int, where: str
) -> tuple[dict[str, Variable], dict[int, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Give the variables by name, the names by what ModelStructure refers to, and the arrays' elements.

    ModelStructure refers to indices in FMI 2.0, and to value references in FMI 3.0.
    """
    types = _declared_types(root, major)
    variables: dict[str, Variable] = {}
    by_key: dict[int, tuple[str, ...]] = {}
    arrays: dict[str, tuple[str, ...]] = {}
    found = root.find("ModelVariables")
    elements = () if found is None else tuple(found)
    lengths = {e.get("valueReference", ""): e.get("start", "") for e in elements}
    for index, element in enumerate(elements, start=1):
        variable = _variable(element, types, major, lengths, where)
        names = [variable.name, *(required(a, "name", where) for a in element.iterfind("Alias"))]
        for name in names:
            named = variable if name == variable.name else replace(variable, name=name)
            scalars = _scalars(named, element, where, _MOST_ELEMENTS - len(variables))
            for scalar in scalars:
                if scalar.name in variables:
                    raise InputError(
                        f"{where}: declares the variable {scalar.name} twice; names must be unique"
                    )
                variables[scalar.name] = scalar
            if variable.dimensions:
                arrays[name] = tuple(scalar.name for scalar in scalars)
            if name == variable.name:
                key = index if major == 2 else variable.value_reference
                by_key[key] = tuple(scalar.name for scalar in scalars)
    return variables, by_key, arrays


def _scalars(variable: Variable, element: Any, where: str, most: int) -> list[Variable]:
    """Give the elements of an array; what is none, or has too many, stays as it is."""
    sizes, kind = variable.dimensions, variable.kind
    count = math.prod(sizes)
    if not sizes or kind is None or count > most:
        return [variable]
    where = f"{where}: {variable.name}"
    listed = [held.get("value", "") for held in element.iterfind("Start")] or element.get("start", "").split()
    if len(listed) not in (0, 1, count):
        raise InputError(f"{where}: has {len(listed)} start values for {count} elements; give one for each")
    starts = [_value(text, kind, where) for text in listed] * (count if len(listed) == 1 else 1)
    return [
        replace(
            variable,
            name=f"{variable.name}[{','.join(str(i + 1) for i in place)}]",
            start=starts[number] if starts else None,
            dimensions=(),
            element=number,
            elements=count,
        )
        for number, place in enumerate(product(*(range(size) for size in sizes)))
    ]


def _declared_types(root: Any, major: int) -> dict[str, Any]:
    """Give the elements that hold the attributes of declared types, by the types' names."""
    if major == 2:
        simple = root.iterfind("TypeDefinitions/SimpleType")
        return {t.get("name"): t[0] for t in simple if len(t) and t.get("name")}
    return {t.get("name"): t for t in root.iterfind("TypeDefinitions/*") if t.get("name")}


def _variable(
    element: Any, types: dict[str, Any], major: int, lengths: dict[str, str], where: str
) -> Variable:
    name = required(element, "name", where)
    typed = element if major == 3 else next((child for child in element if child.tag in TYPES), None)
    if typed is None:
        raise InputError(f"{where}: the variable {name} has no type")
    kind = TYPES.get(typed.tag)
    where = f"{where}: {name}"
    declared_name = typed.get("declaredType")
    declared = types.get(declared_name)
    if declared_name is not None and declared is None:
        raise InputError(f"{where}: its declared type {declared_name} is not defined")

    def attribute(key: str) -> str | None:
        value = typed.get(key)
        return declared.get(key) if value is None and declared is not None else value

    causality = element.get("causality", "local")
    real = kind == "Real"
    variability = element.get("variability") or _default_variability(typed.tag, real, causality)
    sizes = tuple(
        integer(d.get("start") or lengths.get(d.get("valueReference", "")) or "0", where)
        for d in element.iterfind("Dimension")
    )
    return Variable(
        name=name,
        value_reference=_reference(required(element, "valueReference", where), where),
        type=typed.tag,
        kind=kind,
        causality=causality,
        variability=variability,
        initial=element.get("initial") or _default_initial(causality, variability),
        unit=(attribute("unit") or None) if real else None,
        start=None if sizes else _start(element, typed, kind, where),
        min=_bound(attribute("min"), kind, where),
        max=_bound(attribute("max"), kind, where),
        nominal=_bound(attribute("nominal"), kind, where),
        relative=real and attribute("relativeQuantity") in ("true", "1"),
        description=element.get("description", ""),
        items=_items(declared, where) if kind == "Enumeration" else {},
        dimensions=sizes,
    )


def _reference(text: str, where: str) -> int:
    """Give a value reference, which FMI passes in 32 bits without sign."""
    value = integer(text, where)
    if not 0 <= value < 1 << 32:
        raise InputError(
            f"{where}: the valueReference {value} is not between 0 and {(1 << 32) - 1}; export the FMU anew"
        )
    return value


def _items(declared: Any, where: str) -> dict[str, int]:
    if declared is None:
        return {}
    return {
        required(i, "name", where): integer(required(i, "value", where), where)
        for i in declared.iterfind("Item")
    }


def _bound(text: str | None, kind: ConnectorType | None, where: str) -> float | None:
    """Give a bound; an infinite one bounds nothing."""
    if text is None or kind not in ("Real", "Integer", "Enumeration"):
        return None
    value = any_number(text, where)
    return value if math.isfinite(value) else None


def _start(element: Any, typed: Any, kind: ConnectorType | None, where: str) -> Value | None:
    text = typed.get("start")
    if text is None and kind == "String":
        held = element.find("Start")
        text = None if held is None else held.get("value")
    return None if text is None or kind is None else _value(text, kind, where)


def _value(text: str, kind: ConnectorType, where: str) -> Value:
    if kind == "Real":
        return any_number(text, where)
    if kind in ("Integer", "Enumeration"):
        return integer(text, where)
    return truth(text, "start", where) if kind == "Boolean" else text


def _default_variability(fmi_type: str, real: bool, causality: str) -> str:
    # FMI 2.0 has one default for all types; FMI 3.0 one for parameters, one for floats, one for the rest.
    if fmi_type == "Real":
        return "continuous"
    if causality in ("parameter", "calculatedParameter", "structuralParameter"):
        return "fixed"
    return "continuous" if real else "discrete"


def _default_initial(causality: str, variability: str) -> str | None:
    """Give the default of `initial` (FMI 2.0 table in section 2.2.7; FMI 3.0 table 22)."""
    if causality == "independent":
        return None
    if variability == "constant" or causality in ("parameter", "structuralParameter", "input"):
        return "exact"
    return "calculated"


def _outputs(
    root: Any, major: int, by_key: dict[int, tuple[str, ...]], where: str
) -> dict[str, tuple[str, ...] | None]:
    """Give what each output depends on, by name; None where no dependencies are declared."""
    path, key = ("Outputs/Unknown", "index") if major == 2 else ("Output", "valueReference")

    def names(text: str) -> tuple[str, ...]:
        reference = integer(text, where)
        if reference not in by_key:
            raise InputError(f"{where}: ModelStructure refers to variable {reference}, which is not declared")
        return by_key[reference]

    found: dict[str, tuple[str, ...] | None] = {}
    for unknown in root.iterfind(f"ModelStructure/{path}"):
        dependencies = unknown.get("dependencies")
        known = (
            None if dependencies is None else tuple(n for each in dependencies.split() for n in names(each))
        )
        found |= dict.fromkeys(names(required(unknown, key, where)), known)
    return found
