"""What fits an FMU: connectors against its variables, start values against type, range and settability."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.model import (
    INTEGER_RANGES,
    TYPES,
    ConnectorType,
    FmuVariable,
    ModelInfo,
    Value,
)
from warmlink.orchestration.system.units import Unit

_HEXADECIMAL = re.compile("(?:[0-9A-Fa-f]{2})*")
_PYTHON_TYPES: dict[str, tuple[type, ...]] = {
    "Real": (float, int),
    "Integer": (int,),
    "Boolean": (bool,),
    "String": (str,),
    "Enumeration": (str, int),
    "Binary": (str,),
}


def variable_of(info: ModelInfo, name: str, where: str) -> FmuVariable:
    """Give a scalar variable that can be connected; InputError if there is none of this name."""
    variable = info.variables.get(name)
    if variable is None:
        raise InputError(f"{where}: {info.path.name} has no variable {name}; {instead(name, info.variables)}")
    if variable.dimensions:
        raise InputError(f"{where}: is an array in {info.path.name}, which is not supported; use scalars")
    if variable.kind is None:
        raise InputError(f"{where}: is of type {variable.type}, which is not supported; use numbers")
    return variable


def check_connector(variable: FmuVariable, kind: str, declared: str | None, where: str) -> ConnectorType:
    """Refuse a connector whose kind or type, in SSP's words, is not its variable's; give that type."""
    constant = variable.variability == "constant"
    if kind != variable.causality and not (kind == "constant" and constant):
        raise InputError(
            f"{where}: is declared {kind}, but the FMU's variable is {variable.causality}; correct one"
        )
    # Real and Integer are the words of SSP 1.0 for whatever width FMI 3.0 gives.
    exact = declared not in ("Real", "Integer") and variable.type not in ("Real", "Integer")
    if declared and (TYPES.get(declared) != variable.kind or (exact and declared != variable.type)):
        raise InputError(
            f"{where}: is declared {declared}, but the FMU's variable is {variable.type}; correct one"
        )
    assert variable.kind is not None  # variable_of has seen to it
    return variable.kind


def alike(one: str | None, other: str | None) -> bool:
    """Whether values of two types pass for each other; a choice is an Integer in our FMUs of FMI 2.0."""
    return one == other or {one, other} == {"Integer", "Enumeration"}


def own_unit(info: ModelInfo, variable: FmuVariable, declared: Unit | None = None) -> Unit | None:
    """Give the unit in which a variable's values are, or the declared one where the FMU tells none."""
    if variable.kind != "Real" or variable.unit is None:
        return declared if variable.kind == "Real" else None
    return info.units.get(variable.unit, Unit(variable.unit))


def checked_value(variable: FmuVariable, value: Value, where: str) -> Value:
    """Give a start value as the FMU takes it: an Enumeration's item as its integer, a Real as a float.

    The value is in the variable's own unit. InputError where its type does not fit, it is not finite or out
    of range, or the variable cannot be set; `where` is how that names it, such as `link.width`.
    """
    if not variable.settable:
        raise InputError(
            f"{where}: takes no start value, its causality being {variable.causality} and "
            f"its variability {variable.variability}; set a parameter or an input"
        )
    if isinstance(value, bool) != (variable.kind == "Boolean") or not isinstance(
        value, _PYTHON_TYPES[variable.kind or "Real"]
    ):
        raise InputError(f"{where}: {value!r} is not of type {variable.type}; give a value of that type")
    if isinstance(value, str) and variable.kind == "Enumeration":
        if value not in variable.items:
            known = instead(value, variable.items)
            raise InputError(f"{where}: {value!r} is not an item of its enumeration; {known}")
        return variable.items[value]
    if isinstance(value, str) and variable.kind == "Binary" and not _HEXADECIMAL.fullmatch(value):
        raise InputError(f"{where}: {value!r} is not hexadecimal; give two digits for each byte, as 00ff")
    if isinstance(value, str | bool):
        return value
    number = float(value) if variable.kind == "Real" else int(value)
    unit = f" {variable.unit}" if variable.unit else ""
    if variable.type in INTEGER_RANGES:
        least, most = INTEGER_RANGES[variable.type]
        bits = (most - least).bit_length()
        if not least <= number <= most:
            # FMI would pass its last bits, another number.
            raise InputError(f"{where}: {number} does not fit into {bits} bits; give {least} to {most}")
    if not math.isfinite(number):
        raise InputError(f"{where}: {number}{unit} is not a finite number; give one")
    low, high = variable.min, variable.max
    if low is not None and number < low:
        raise InputError(f"{where}: {number:g}{unit} is below its minimum; give at least {low:g}{unit}")
    if high is not None and number > high:
        raise InputError(f"{where}: {number:g}{unit} is above its maximum; give at most {high:g}{unit}")
    return number


def checked_values(info: ModelInfo, values: Mapping[str, Value], name: str) -> dict[str, Value]:
    """Give start values of a component by variable, as `checked_value` does; `name` is the component's."""
    full = {key: f"{name}.{key}" for key in values}
    return {
        key: checked_value(variable_of(info, key, full[key]), value, full[key])
        for key, value in values.items()
    }
