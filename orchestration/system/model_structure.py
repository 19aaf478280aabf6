"""What an FMU's ModelStructure tells: outputs, what they depend on, and the size of its equations."""

from __future__ import annotations

import math
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system import xml
from warmlink.orchestration.system.model import FmuVariable


def outputs_of(
    root: Any, major: int, by_key: dict[int, tuple[str, ...]], where: str
) -> dict[str, tuple[str, ...] | None]:
    """Give what each output depends on, by name; None where no dependencies are declared."""
    path, key = ("Outputs/Unknown", "index") if major == 2 else ("Output", "valueReference")

    def names(text: str) -> tuple[str, ...]:
        reference = xml.integer(text, where)
        if reference not in by_key:
            raise InputError(f"{where}: ModelStructure refers to variable {reference}, which is not declared")
        return by_key[reference]

    found: dict[str, tuple[str, ...] | None] = {}
    for unknown in root.iterfind(f"ModelStructure/{path}"):
        texts = unknown.get("dependencies")
        known = None if texts is None else tuple(n for each in texts.split() for n in names(each))
        found |= dict.fromkeys(names(xml.required(unknown, key, where)), known)
    return found


def sizes_of(
    root: Any, major: int, by_key: dict[int, tuple[str, ...]], variables: dict[str, FmuVariable], where: str
) -> tuple[int, int]:
    """Give how many continuous states and event indicators a model has."""

    def count(path: str) -> int:
        found = root.iterfind(f"ModelStructure/{path}")
        references = (xml.integer(xml.required(each, "valueReference", where), where) for each in found)
        names = (name for reference in references for name in by_key.get(reference, ()))
        return sum(math.prod(variables[name].dimensions) for name in names)

    if major == 3:
        return count("ContinuousStateDerivative"), count("EventIndicator")
    indicators = xml.optional(root, "numberOfEventIndicators", xml.integer, where) or 0
    # FMI 1.0 counts the states in an attribute.
    states = xml.optional(root, "numberOfContinuousStates", xml.integer, where)
    return len(root.findall("ModelStructure/Derivatives/Unknown")) if states is None else states, indicators
