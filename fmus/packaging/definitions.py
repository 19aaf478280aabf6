"""Units and types that the variables of a modelDescription.xml refer to."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component, Variable
from warmlink.fmus.component.quantities import is_difference
from warmlink.fmus.component.units import display_conversion, unit
from warmlink.fmus.packaging.attributes import declared_type, text
from warmlink.fmus.packaging.exchange import ExchangedState


def unit_definitions(root: ET.Element, component: Component, states: Sequence[ExchangedState]) -> None:
    """Add the units of variables and states, which FMI 2.0 and 3.0 write alike."""
    displays: dict[str, set[str]] = {"s": set()}
    for variable in _variables(component):
        if variable.type == "Real":
            shown = displays.setdefault(variable.unit, set())
            if variable.display is not None:
                shown.add(variable.display)
    for state in states:
        displays.setdefault(state.unit, set())
        displays.setdefault(state.rate_unit, set())
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted(displays):
        definition = ET.SubElement(definitions, "Unit", name=name)
        described = unit(name)
        attributes = {base: str(exponent) for base, exponent in described.exponents.items()}
        if described.factor != 1:
            attributes["factor"] = text(float(described.factor))
        ET.SubElement(definition, "BaseUnit", attributes)
        for display in sorted(displays[name]):
            factor, offset = display_conversion(name, display)
            conversion = {"factor": factor, "offset": offset}
            kept = {key: text(value) for key, value in conversion.items() if value != (key == "factor")}
            ET.SubElement(definition, "DisplayUnit", {"name": display} | kept)


def type_definitions(root: ET.Element, component: Component) -> None:
    """Add a type for each quantity and each choice; `root` says of which FMI version it is."""
    types = {name: v for v in _variables(component) if (name := declared_type(v)) is not None}
    if not types:
        return
    modern = root.get("fmiVersion") == "3.0"
    definitions = ET.SubElement(root, "TypeDefinitions")
    for name, variable in sorted(types.items()):
        attributes = {"quantity": name}
        choice = variable.choice
        if choice is None:
            attributes["unit"] = variable.unit
            if is_difference(variable):
                attributes["relativeQuantity"] = "true"
        described = {"name": name}
        if choice is not None and not modern:
            attributes |= {"min": "0", "max": str(choice.last)}
            described["description"] = ", ".join(f"{i} {item}" for i, item in enumerate(choice.items))
        if not modern:
            around = ET.SubElement(definitions, "SimpleType", described)
            ET.SubElement(around, variable.type, attributes)
        elif choice is None:
            ET.SubElement(definitions, "Float64Type", described | attributes)
        else:
            enumeration = ET.SubElement(definitions, "EnumerationType", described | attributes)
            for i, item in enumerate(choice.items):
                ET.SubElement(enumeration, "Item", name=item, value=str(i))


def _variables(component: Component) -> list[Variable]:
    return [*component.inputs, *component.parameters, *component.outputs]
