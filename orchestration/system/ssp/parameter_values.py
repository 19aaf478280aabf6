"""SSV and SSM: sets of start values, in a file or inside an SSD, and how names map (SSP 6 and 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import remark_once
from warmlink.orchestration.files import whole_file
from warmlink.orchestration.system import xml
from warmlink.orchestration.system.model import TYPES, Value
from warmlink.orchestration.system.ssp.arrays import element_names, sizes_of_array
from warmlink.orchestration.system.ssp.net import Edge, Node, ValueMap
from warmlink.orchestration.system.units import (
    Conversion,
    Unit,
    definitions_of_units,
    named_unit,
    unit_elements,
)


@dataclass(frozen=True)
class SsvValue:
    """One value of a parameter set, of a type of connectors: an Enumeration's is the name of its item.

    Where a Real has no unit, it is in that of the variable it goes to. It may be one of so many `elements` of
    an array. A `contradiction` is the sentence for whoever uses a value beside which the set gives another.
    """

    name: str
    type: str
    value: Value
    unit: Unit | None = None
    elements: int = 1
    contradiction: str = ""


def read_ssv(path: Path) -> dict[str, SsvValue]:
    """Parameters of an SSV file by name; InputError if it is absent, no SSV, or not supported."""
    remarks: list[str] = []
    found = parameter_set(xml.root_of_file(path, "ParameterSet", path.name, remarks), path.name, remarks)
    for told in remarks:
        remark_once(told)
    for each in found.values():
        if each.contradiction:
            raise InputError(each.contradiction)
    return found


def description_of(path: Path) -> str:
    """What an SSV file says of itself; empty if it says nothing. InputError as for `read_ssv`."""
    root = xml.root_of_file(path, "ParameterSet", path.name, [])
    return str(root.get("description", ""))


def write_ssv(
    values: Mapping[str, Value | SsvValue], path: Path, name: str = "parameters", description: str = ""
) -> None:
    """Write values by variable, with a unit or item as `Parameter`, as an SSV file, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as scratch:
        scratch.write_bytes(xml.to_bytes(parameter_set_element(name, values, description)))


def parameter_set(root: Any, where: str, remarks: list[str]) -> dict[str, SsvValue]:
    """Give the parameters of an `ssv:ParameterSet` element by name; what does not fit is an InputError."""
    xml.refuse_other_children(root, ("Parameters", "Enumerations", "Units"), where)
    units = definitions_of_units(root, where)
    parameters: dict[str, SsvValue] = {}
    for child in root.iterfind("{*}Parameters/{*}Parameter"):
        name = xml.required(child, "name", where)
        for found in _elements(name, child, units, f"{where}: {name}", remarks):
            before = parameters.setdefault(found.name, found)
            if before != found:
                told = f"{where}: gives the parameter {found.name} twice; keep one"
                parameters[found.name] = replace(found, contradiction=told)
            elif before is not found:
                remarks.append(f"{where}: gives the parameter {found.name} twice, with the same value")
    return parameters


def _elements(
    name: str, entry: Any, units: dict[str, Unit], where: str, remarks: list[str]
) -> Iterator[SsvValue]:
    """Give the one value of a parameter, or those of an array's elements (SSP 2.0 section 6)."""
    typed = [child for child in entry if xml.local(child) not in ("Annotations", "MetaData", "Dimension")]
    if len(typed) != 1:
        raise InputError(f"{where}: needs one value, not {len(typed)}; give a value of one type")
    kind, unit = TYPES.get(xml.local(typed[0]), xml.local(typed[0])), typed[0].get("unit")
    if kind not in (*_READERS, "String", "Enumeration", "Binary"):
        raise InputError(
            f"{where}: values of type {kind} are not supported; use Real, Integer, Boolean or String"
        )
    meant = named_unit(unit, units, where, remarks) if kind == "Real" else None
    dimensions = entry.findall("{*}Dimension")
    sizes = sizes_of_array((xml.required(each, "size", where) for each in dimensions), where)
    names, texts = element_names(name, sizes), [each.get("value", "") for each in typed[0]]
    if not texts:
        text = xml.required(typed[0], "value", where)
        texts = text.split() if sizes and kind in _READERS else [text]
    if len(texts) != len(names):
        raise InputError(f"{where}: has {len(texts)} values for {len(names)} elements; give one for each")
    for element, text in zip(names, texts, strict=True):
        read = _READERS.get(kind)
        at = f"{where}: value" if kind == "Boolean" else where
        yield SsvValue(element, kind, text if read is None else read(text, at), meant, len(names))


_READERS: Mapping[str, Callable[[str, str], Value]] = {
    "Real": xml.number,
    "Integer": xml.integer,
    "Boolean": xml.truth,
}


def parameter_mapping(root: Any, where: str) -> tuple[Edge, ...]:
    """Give the entries of an `ssm:ParameterMapping` element; raises `InputError` on what is not supported."""
    xml.refuse_other_children(root, ("MappingEntry",), where)
    entries = []
    for entry in root.iterfind("{*}MappingEntry"):
        source, target = (Node((), xml.required(entry, end, where)) for end in ("source", "target"))
        edge = Edge(source, target)
        entries.append(with_transformation(edge, entry, f"{where}: {edge}"))
    return tuple(entries)


def with_transformation(edge: Edge, entry: Any, where: str) -> Edge:
    """Give a connection or mapping entry with what its element says of units and of a transformation."""
    suppress = xml.optional(entry, "suppressUnitConversion", xml.truth, where) or False
    tables = [f"{kind}MappingTransformation" for kind in _MAPPED]
    xml.refuse_other_children(entry, ("LinearTransformation", *tables, "ConnectionGeometry"), where)
    linear, change = entry.find("{*}LinearTransformation"), None
    if linear is not None:
        factor = xml.optional(linear, "factor", xml.number, where)
        offset = xml.optional(linear, "offset", xml.number, where) or 0.0
        change = Conversion(1.0 if factor is None else factor, offset)
    found = [_value_map(each, where) for each in entry if xml.local(each) in tables]
    if len(found) + (linear is not None) > 1:
        raise InputError(f"{where}: has more than one transformation; keep one")
    values = found[0] if found else None
    return replace(edge, transformation=change, suppress_unit_conversion=suppress, values=values)


_MAPPED: Mapping[str, Callable[[str, str], Value]] = {
    "Boolean": lambda text, where: xml.truth(text, where),
    "Integer": xml.integer,
    "Enumeration": lambda text, where: text,
}
"""How the values of each mapping transformation are read."""


def _value_map(element: Any, where: str) -> ValueMap:
    """Give a table of values (SSP 2.0 section 4.5.3); InputError if one source value has two targets."""
    kind = xml.local(element).removesuffix("MappingTransformation")
    read, entries = _MAPPED[kind], dict[Value, Value]()
    for each in element.iterfind("{*}MapEntry"):
        source, target = (read(xml.required(each, end, where), where) for end in ("source", "target"))
        if source in entries:
            raise InputError(f"{where}: maps the value {source} twice; keep one entry")
        entries[source] = target
    return ValueMap(kind, tuple(entries.items()))


def parameter_set_element(
    name: str,
    values: Mapping[str, Value | SsvValue],
    description: str = "",
    version: str = "1.0",
    arrays: Mapping[str, Sequence[int]] = MappingProxyType({}),
) -> Any:
    """Give an `ssv:ParameterSet` element that holds the values and the definitions of their units.

    Where all elements of `arrays`, whose sizes are given, have a value, they are written as one.
    """
    told = {"description": description} if description else {}
    root = xml.element("ssv", "ParameterSet", version=version, name=name, **told)
    held = xml.sub_element(root, "ssv", "Parameters")
    used: dict[str, Unit] = {}
    left = {
        key: value if isinstance(value, SsvValue) else _plain(key, value) for key, value in values.items()
    }
    for array, sizes in arrays.items():
        elements = element_names(array, sizes)
        chosen = [left[each] for each in elements if each in left]
        if len(chosen) == len(elements) and chosen[0].type in _READERS:
            text = " ".join(xml.text_of(each.value) for each in chosen)
            left = {key: each for key, each in left.items() if key not in elements}
            left[array] = replace(chosen[0], value=text)
    for key, parameter in left.items():
        entry = xml.sub_element(held, "ssv", "Parameter", name=key)
        unit = parameter.unit
        if unit is not None:
            used[unit.name] = unit
        xml.sub_element(entry, "ssv", parameter.type, value=parameter.value, unit=unit.name if unit else None)
        for size in arrays.get(key, ()):
            xml.sub_element(entry, "ssc", "Dimension", size=size)
    unit_elements(root, "ssv", used.values())
    return root


def _plain(name: str, value: Value) -> SsvValue:
    # bool is an int in Python, hence the order.
    kinds = ((bool, "Boolean"), (int, "Integer"), (float, "Real"), (str, "String"))
    return SsvValue(name, next(label for kind, label in kinds if isinstance(value, kind)), value)
