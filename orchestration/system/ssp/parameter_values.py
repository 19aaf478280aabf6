"""SSV and SSM: sets of start values, in a file or inside an SSD, and how names map (SSP 6 and 7)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.records import dataclass
from warmlink.orchestration.files import whole_file
from warmlink.orchestration.system.model import TYPES, Value
from warmlink.orchestration.system.ssp.net import Edge, Node
from warmlink.orchestration.system.units import Conversion, Unit, definitions_of_units, unit_elements
from warmlink.orchestration.system.xml import (
    children,
    element,
    integer,
    local,
    number,
    only_child,
    optional,
    refuse_other_children,
    required,
    root_of_file,
    sub_element,
    to_bytes,
    truth,
)


@dataclass(frozen=True)
class Parameter:
    """One value of a parameter set: an Enumeration's is the name of its item.

    Its type is `Real`, `Integer`, `Boolean`, `String` or `Enumeration`; where a Real has no unit, it is in
    that of the variable it goes to.
    """

    name: str
    type: str
    value: Value
    unit: Unit | None = None


def read_ssv(path: Path) -> dict[str, Parameter]:
    """Read an SSV file: the parameters by name, each with its own unit.

    Raises
    ------
    InputError
        If the file is absent, not an SSV, or holds what is not supported.
    """
    return parameter_set(root_of_file(path, "ParameterSet", path.name), path.name)


def write_ssv(
    values: Mapping[str, Value | Parameter],
    path: Path,
    name: str = "parameters",
) -> None:
    """Write an SSV file, whole or not at all.

    Parameters
    ----------
    values : by variable name: plain Python values, or `Parameter` where a unit or an Enumeration is to be
        told
    path : where to write
    name : name of the parameter set
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as scratch:
        scratch.write_bytes(to_bytes(parameter_set_element(name, values)))


def parameter_set(root: Any, where: str) -> dict[str, Parameter]:
    """Give the parameters of an `ssv:ParameterSet` element by name; what does not fit is an InputError."""
    refuse_other_children(root, ("Parameters", "Enumerations", "Units"), where)
    units = definitions_of_units(only_child(root, "Units"), where)
    parameters: dict[str, Parameter] = {}
    for child in children(only_child(root, "Parameters"), "Parameter"):
        name = required(child, "name", where)
        if name in parameters:
            raise InputError(f"{where}: gives the parameter {name} twice; keep one")
        parameters[name] = _parameter(name, child, units, f"{where}: {name}")
    return parameters


def _parameter(name: str, entry: Any, units: Mapping[str, Unit], where: str) -> Parameter:
    typed = [child for child in entry if local(child) not in ("Annotations", "MetaData")]
    if len(typed) != 1:
        raise InputError(f"{where}: needs one value, not {len(typed)}; arrays are not supported")
    kind, text, unit = local(typed[0]), required(typed[0], "value", where), typed[0].get("unit")
    kind = TYPES.get(kind, kind)
    if kind == "Real":
        known = None if unit is None else units.get(unit, Unit(unit))
        return Parameter(name, kind, number(text, where), known)
    if kind == "Integer":
        return Parameter(name, kind, integer(text, where))
    if kind == "Boolean":
        return Parameter(name, kind, truth(text, f"{where}: value"))
    if kind in ("String", "Enumeration"):
        return Parameter(name, kind, text)
    raise InputError(
        f"{where}: values of type {kind} are not supported; use Real, Integer, Boolean or String"
    )


def parameter_mapping(root: Any, where: str) -> tuple[Edge, ...]:
    """Give the entries of an `ssm:ParameterMapping` element; raises `InputError` on what is not supported."""
    refuse_other_children(root, ("MappingEntry",), where)
    entries = []
    for entry in children(root, "MappingEntry"):
        source, target = (Node((), required(entry, end, where)) for end in ("source", "target"))
        edge = Edge(source, target)
        entries.append(with_transformation(edge, entry, f"{where}: {edge}"))
    return tuple(entries)


def with_transformation(edge: Edge, entry: Any, where: str) -> Edge:
    """Give a connection or mapping entry with what its element says of units and of a transformation."""
    suppress = optional(entry, "suppressUnitConversion", truth, where) or False
    refuse_other_children(entry, ("LinearTransformation", "ConnectionGeometry"), where)
    linear, change = only_child(entry, "LinearTransformation"), None
    if linear is not None:
        factor = optional(linear, "factor", number, where)
        offset = optional(linear, "offset", number, where) or 0.0
        change = Conversion(1.0 if factor is None else factor, offset)
    return replace(edge, transformation=change, suppress_unit_conversion=suppress)


def parameter_set_element(name: str, values: Mapping[str, Value | Parameter]) -> Any:
    """Give an `ssv:ParameterSet` element that holds the values and the definitions of their units."""
    root = element("ssv", "ParameterSet", version="1.0", name=name)
    held = sub_element(root, "ssv", "Parameters")
    used: dict[str, Unit] = {}
    for key, value in values.items():
        parameter = value if isinstance(value, Parameter) else _plain(key, value)
        entry = sub_element(held, "ssv", "Parameter", name=key)
        unit = parameter.unit
        told = None if unit is None else unit.name
        sub_element(entry, "ssv", parameter.type, value=parameter.value, unit=told)
        if unit is not None:
            used[unit.name] = unit
    unit_elements(root, "ssv", used.values())
    return root


def _plain(name: str, value: Value) -> Parameter:
    # bool is an int in Python, hence the order.
    kinds = ((bool, "Boolean"), (int, "Integer"), (float, "Real"), (str, "String"))
    return Parameter(name, next(label for kind, label in kinds if isinstance(value, kind)), value)
