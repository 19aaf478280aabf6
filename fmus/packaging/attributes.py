"""What a modelDescription.xml says of single variables, of their units and of their types."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Parameter, Scalar, Variable
from warmlink.fmus.component.quantities import quantity
from warmlink.fmus.component.units import display_conversion, unit
from warmlink.fmus.component.variables import is_difference

VENDOR = "warmlink"
"""Name under which this project annotates a model description."""

Attributes = Mapping[str, Any]
"""Texts, numbers and truth values that an element states; those of None are left out."""


def add(parent: ET.Element, tag: str, attributes: Attributes | None = None, **more: Any) -> ET.Element:
    """Add an element to another, with the attributes of both kinds in their order."""
    told = {**(attributes or {}), **more}
    return ET.SubElement(parent, tag, {key: text(v) for key, v in told.items() if v is not None})


def text(value: str | float) -> str:
    """A text, a number or a truth value as XML writes it."""
    if isinstance(value, str):
        return value
    return str(value).lower() if isinstance(value, bool) else repr(value)


def document(root: ET.Element) -> bytes:
    """Bytes of an XML file."""
    ET.indent(root)
    return (
        b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode").encode() + b"\n"
    )


def identity(scalar: Scalar) -> dict[str, str]:
    """Name, value reference, description, causality, variability and initial."""
    variable = scalar.variable
    if isinstance(variable, Parameter):
        variability = "tunable" if variable.tunable else "fixed"
    else:
        variability = "discrete" if variable.discrete or variable.type != "Real" else "continuous"
    causality = type(variable).__name__.lower()
    given = {"name": scalar.name, "valueReference": str(scalar.reference)}
    given |= {"description": variable.description, "causality": causality, "variability": variability}
    initial = {"parameter": "exact", "output": "calculated", "local": "calculated"}
    return given | ({"initial": initial[causality]} if causality in initial else {})


def value_attributes(scalar: Scalar, whole: bool = False) -> Attributes:
    """Type, unit, range, nominal and start of a scalar, or with the starts of all of its `whole` array."""
    variable = scalar.variable
    real, bounded = variable.type == "Real", variable.type != "Boolean"
    start: str | float | None = typed(variable, scalar.start)
    if whole and start is not None:
        starts = (typed(variable, replace(scalar, element=i).start) for i in range(variable.count))
        start = " ".join(text(each) for each in starts if each is not None)
    return {
        "declaredType": declared_type(variable),
        "unit": variable.unit if real else None,
        "displayUnit": variable.display if real else None,
        "relativeQuantity": (real and is_difference(variable)) or None,
        "min": typed(variable, scalar.lower) if bounded else None,
        "max": typed(variable, variable.maximum) if bounded else None,
        "nominal": typed(variable, variable.nominal) if real else None,
        "start": start,
    }


def typed(variable: Variable, value: float | None) -> float | None:
    """A value as a number of the variable's type; None if there is none."""
    return None if value is None else {"Real": float, "Integer": int, "Boolean": bool}[variable.type](value)


def declared_type(variable: Variable) -> str | None:
    """Name of the type definition that a variable refers to; None where its quantity has no name."""
    if variable.choice is not None:
        return variable.choice.name
    return quantity(variable) if variable.type == "Real" else None


def fmi3_type(variable: Variable) -> str:
    """Element of a variable in FMI 3.0.

    In FMI 2.0 a choice stays an Integer: libcosimpy 0.0.6 and ecospy 0.7.2 take none of its enumerations.
    """
    types = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
    return types[variable.type] if variable.choice is None else "Enumeration"


def add_units(root: ET.Element, variables: Iterable[Variable], others: Iterable[str]) -> None:
    """Add the units of variables, and others without units for display."""
    displays: dict[str, set[str]] = {"s": set(), **{name: set() for name in others}}
    for variable in variables:
        if variable.type == "Real":
            displays.setdefault(variable.unit, set()).update([variable.display] if variable.display else [])
    definitions = add(root, "UnitDefinitions")
    for name in sorted(displays):
        definition, base = add(definitions, "Unit", name=name), unit(name)
        add(definition, "BaseUnit", base.exponents, factor=None if base.factor == 1 else float(base.factor))
        for display in sorted(displays[name]):
            factor, offset = display_conversion(name, display)
            told = {"name": display, "factor": None if factor == 1 else factor, "offset": offset or None}
            add(definition, "DisplayUnit", told)


def add_types(root: ET.Element, variables: Iterable[Variable], fmi_version: str) -> None:
    """Add a type for each quantity and each choice."""
    types = {name: v for v in variables if (name := declared_type(v)) is not None}
    definitions = add(root, "TypeDefinitions") if types else root
    for name, variable in sorted(types.items()):
        choice = variable.choice
        told: dict[str, Any] = {"quantity": name}
        if choice is None:
            told |= {"unit": variable.unit, "relativeQuantity": is_difference(variable) or None}
        if fmi_version == "3.0":
            kind = "Float64Type" if choice is None else "EnumerationType"
            definition = add(definitions, kind, {"name": name}, **told)
            for i, item in enumerate(choice.items if choice else ()):
                add(definition, "Item", name=item, value=i)
        elif choice is None:
            add(add(definitions, "SimpleType", name=name), "Real", told)
        else:
            listed = ", ".join(f"{i} {item}" for i, item in enumerate(choice.items))
            definition = add(definitions, "SimpleType", name=name, description=listed)
            add(definition, "Integer", told, min=0, max=choice.last)


def inputs_accepting_nan(root: Any) -> frozenset[str]:
    """Names of the inputs that a model description of ours, of FMI 2.0 or 3.0, declares to cope with NaN."""
    names: list[str] = []
    for path in (f"VendorAnnotations/Tool[@name='{VENDOR}']", f"Annotations/Annotation[@type='{VENDOR}']"):
        for element in root.findall(f"{path}/acceptsNaN"):
            names += element.get("variables", "").split()
    return frozenset(names)
