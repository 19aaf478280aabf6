"""SSV and SSM: sets of start values, in a file or inside an SSD, and how names map (SSP 6 and 7)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import whole_file
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.ssp.elements import (
    children,
    element,
    only_child,
    refuse_other_children,
    root_of_file,
    sub_element,
    to_bytes,
    unit_elements,
)
from warmlink.orchestration.system.units import Conversion, Unit, definitions_of_units
from warmlink.orchestration.system.xml import boolean, integer, local, number, optional_number, required

# Names of SSP 1.0 and 2.0 for values of each kind.
_REAL = ("Real", "Float64", "Float32")
_INTEGER = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


@dataclass(frozen=True)
class Parameter:
    """One value of a parameter set: an Enumeration's is the name of its item.

    Parameters
    ----------
    type
        `Real`, `Integer`, `Boolean`, `String` or `Enumeration`.
    unit
        Unit of a Real; None means that of the variable it goes to.
    """

    name: str
    type: str
    value: Value
    unit: Unit | None = None


@dataclass(frozen=True)
class MappingEntry:
    """One entry of a parameter mapping: `target = factor * source + offset` after unit conversion."""

    source: str
    target: str
    transformation: Conversion | None = None
    suppress_unit_conversion: bool = False


def read_ssv(path: Path) -> dict[str, Parameter]:
    """Read an SSV file.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    dict
        The parameters by name, each with its own unit.

    Raises
    ------
    InputError
        If the file is absent, not an SSV, or holds what is not supported.
    """
    return {p.name: p for p in parameter_set(root_of_file(path, "ParameterSet", path.name), path.name)}


def write_ssv(
    values: Mapping[str, Value | Parameter],
    path: Path,
    name: str = "parameters",
) -> None:
    """Write an SSV file, whole or not at all.

    Parameters
    ----------
    values
        By variable name: plain Python values, or `Parameter` where a unit or an Enumeration is to be told.
    path
        Where to write.
    name
        Name of the parameter set.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as scratch:
        scratch.write_bytes(to_bytes(parameter_set_element(name, values)))


def parameter_set(root: Any, where: str) -> tuple[Parameter, ...]:
    """Give the parameters of an `ssv:ParameterSet` element; what does not fit is an InputError."""
    refuse_other_children(root, ("Parameters", "Enumerations", "Units", "Annotations", "MetaData"), where)
    units = definitions_of_units(only_child(root, "Units"), where)
    held = only_child(root, "Parameters")
    parameters: dict[str, Parameter] = {}
    for child in () if held is None else held:
        if local(child) != "Parameter":
            continue
        name = required(child, "name", where)
        if name in parameters:
            raise InputError(f"{where}: gives the parameter {name} twice; keep one")
        parameters[name] = _parameter(name, child, units, f"{where}: {name}")
    return tuple(parameters.values())


def _parameter(name: str, entry: Any, units: Mapping[str, Unit], where: str) -> Parameter:
    typed = [child for child in entry if local(child) not in ("Annotations", "MetaData")]
    if len(typed) != 1:
        raise InputError(f"{where}: needs one value, not {len(typed)}; arrays are not supported")
    held = typed[0]
    kind = local(held)
    text = required(held, "value", where)
    if kind in _REAL:
        unit = held.get("unit")
        return Parameter(
            name, "Real", number(text, where), None if unit is None else units.get(unit, Unit(unit))
        )
    if kind in _INTEGER:
        return Parameter(name, "Integer", integer(text, where))
    if kind == "Boolean":
        return Parameter(name, "Boolean", boolean(held, "value", where, default=False))
    if kind in ("String", "Enumeration"):
        return Parameter(name, kind, text)
    raise InputError(
        f"{where}: values of type {kind} are not supported; use Real, Integer, Boolean or String"
    )


def parameter_mapping(root: Any, where: str) -> tuple[MappingEntry, ...]:
    """Give the entries of an `ssm:ParameterMapping` element; raises `InputError` on what is not supported."""
    refuse_other_children(root, ("MappingEntry", "Annotations", "MetaData"), where)
    entries = []
    for entry in children(root, "MappingEntry"):
        source, target = required(entry, "source", where), required(entry, "target", where)
        here = f"{where}: {source} -> {target}"
        suppress = boolean(entry, "suppressUnitConversion", here, default=False)
        entries.append(MappingEntry(source, target, transformation(entry, here), suppress))
    return tuple(entries)


def transformation(entry: Any, where: str) -> Conversion | None:
    """Give the linear transformation of a connection or mapping entry, or None where it has none."""
    refuse_other_children(
        entry, ("LinearTransformation", "ConnectionGeometry", "Annotations", "MetaData"), where
    )
    linear = only_child(entry, "LinearTransformation")
    if linear is None:
        return None
    factor = optional_number(linear, "factor", where)
    return Conversion(1.0 if factor is None else factor, optional_number(linear, "offset", where) or 0.0)


def parameter_set_element(name: str, values: Mapping[str, Value | Parameter]) -> Any:
    """Give an `ssv:ParameterSet` element that holds the values and the definitions of their units."""
    root = element("ssv", "ParameterSet", version="1.0", name=name)
    held = sub_element(root, "ssv", "Parameters")
    used: dict[str, Unit] = {}
    for key, value in values.items():
        parameter = value if isinstance(value, Parameter) else _plain(key, value)
        entry = sub_element(held, "ssv", "Parameter", name=key)
        typed = sub_element(entry, "ssv", parameter.type, value=_text(parameter.value))
        if parameter.unit is not None:
            typed.set("unit", parameter.unit.name)
            used[parameter.unit.name] = parameter.unit
    unit_elements(root, "ssv", used.values())
    return root


def _plain(name: str, value: Value) -> Parameter:
    # bool is an int in Python, hence the order.
    kinds = ((bool, "Boolean"), (int, "Integer"), (float, "Real"), (str, "String"))
    return Parameter(name, next(label for kind, label in kinds if isinstance(value, kind)), value)


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)
