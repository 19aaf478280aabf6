"""Attributes of a variable in a modelDescription.xml, which FMI 2.0 and FMI 3.0 write alike."""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component, Input, Parameter, Scalar, Variable
from warmlink.fmus.component.quantities import is_difference, quantity

VENDOR = "warmlink"
"""Name under which this project annotates a model description."""


def identity(scalar: Scalar) -> dict[str, str]:
    """Name, value reference, description, causality, variability and initial."""
    identity = {
        "name": scalar.name,
        "valueReference": str(scalar.reference),
        "description": scalar.variable.description,
        "causality": causality(scalar),
        "variability": variability(scalar),
    }
    initial = {"parameter": "exact", "output": "calculated", "local": "calculated"}
    given = initial.get(identity["causality"])
    return identity | ({"initial": given} if given else {})


def causality(scalar: Scalar) -> str:
    """`input`, `parameter`, `output` or `local`."""
    return type(scalar.variable).__name__.lower()


def variability(scalar: Scalar) -> str:
    """`fixed`, `tunable`, `discrete` or `continuous`."""
    variable = scalar.variable
    if isinstance(variable, Parameter):
        return "tunable" if variable.tunable else "fixed"
    return "discrete" if variable.discrete or variable.type != "Real" else "continuous"


def value_attributes(scalar: Scalar) -> dict[str, str]:
    """Type, unit, range, nominal and start, in the order of FMI."""
    variable = scalar.variable
    real, boolean = variable.type == "Real", variable.type == "Boolean"
    named = declared_type(variable)
    attributes: dict[str, str] = {} if named is None else {"declaredType": named}
    if real:
        attributes["unit"] = variable.unit
        if variable.display is not None:
            attributes["displayUnit"] = variable.display
        elif is_difference(variable):
            attributes["relativeQuantity"] = "true"
    values = {} if boolean else {"min": scalar.lower, "max": variable.maximum}
    if real:
        values["nominal"] = variable.nominal
    values["start"] = scalar.start
    stated = {key: text(typed(variable, value)) for key, value in values.items() if value is not None}
    return attributes | stated


def array_attributes(first: Scalar) -> dict[str, str]:
    """What differs for an array as a whole from its first element: the name, and start values of all."""
    variable = first.variable
    starts = [replace(first, element=i).start for i in range(variable.count)]
    given = [text(typed(variable, start)) for start in starts if start is not None]
    return {"name": variable.name} | ({"start": " ".join(given)} if given else {})


def typed(variable: Variable, value: float) -> float | bool:
    """A value as a number of the variable's type."""
    return {"Real": float, "Integer": int, "Boolean": bool}[variable.type](value)


def declared_type(variable: Variable) -> str | None:
    """Name of the type definition that a variable refers to; None where its quantity has no name."""
    if variable.choice is not None:
        return variable.choice.name
    return quantity(variable) if variable.type == "Real" else None


def fmi3_type(variable: Variable) -> str:
    """Element of a variable in FMI 3.0.

    In FMI 2.0 a choice stays an Integer of a named type: neither libcosimpy 0.0.6 nor ecospy 0.7.2 connects
    or sets enumerations of FMI 2.0.
    """
    if variable.choice is not None:
        return "Enumeration"
    return {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}[variable.type]


def set_within_step(scalar: Scalar) -> bool:
    """Whether FMI 3.0 may set the variable within a communication step."""
    return isinstance(scalar.variable, Input) and variability(scalar) == "continuous"


def accepting_nan(component: Component) -> list[str]:
    """Names of the inputs that cope with a missing value."""
    return [s.name for s in component.scalars() if isinstance(s.variable, Input) and s.variable.accepts_nan]


def inputs_accepting_nan(root: Any) -> frozenset[str]:
    """Names of the inputs that a model description of ours, of FMI 2.0 or 3.0, declares to cope with NaN."""
    names: list[str] = []
    for path in (f"VendorAnnotations/Tool[@name='{VENDOR}']", f"Annotations/Annotation[@type='{VENDOR}']"):
        for element in root.findall(f"{path}/acceptsNaN"):
            names += element.get("variables", "").split()
    return frozenset(names)


def document(root: ET.Element) -> bytes:
    """Bytes of an XML file."""
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="utf-8") + b"\n"


def text(value: float | bool) -> str:
    """A number or a truth value as XML writes it."""
    return str(value).lower() if isinstance(value, bool) else repr(value)
