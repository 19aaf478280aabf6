"""Start values that people give a system of any FMUs, as `"motor.joint_conductance" = "2 W/K"`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from warmlink.fmus.arguments import path_given
from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import end_of
from warmlink.orchestration.system.check import checked_value, own_unit, variable_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import FmuVariable, System, Value
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, read_ssv
from warmlink.orchestration.system.units import Unit, conversion, meaning, parse_unit, spelled
from warmlink.orchestration.written.quantities import number_and_unit

Written = str | float | bool | SsvValue
"""A start value: a number in the variable's own unit, a text as `"2 W/K"`, or a value of a parameter set."""

_WHOLE = re.compile(r"[+-]?\d+")

_TRUTH = {"true": True, "false": False, "1": True, "0": False}


def with_start_values(system: System, given: Mapping[str, Written], where: str = "") -> System:
    """Give a system other start values.

    Parameters
    ----------
    system : of any FMUs
    given : values by full name, as `link.length`; in a system of one FMU the variable's own name suffices
    where : the file that they come from, for errors

    Raises
    ------
    InputError
        If there is no such variable, a connection feeds it, or the value does not fit.
    """
    fed = {link.target: link.source for link in system.connections}
    components = dict(system.components)
    for name, value in given.items():
        owner, own = _owner(system, name, where)
        place = f"{where}: {name}" if where else name
        if (full := f"{owner}.{own}") in fed:
            raise InputError(f"{place}: is fed by {fed[full]}; set what that comes from, or leave it out")
        info = read_description(components[owner].fmu)
        variable = variable_of(info, own, place)
        typed = _typed(value, variable, own_unit(info, variable), place)
        values = {**components[owner].values, own: checked_value(variable, typed, place)}
        components[owner] = replace(components[owner], values=values)
    return replace(system, components=components)


def with_parameters(system: System, parameters: Mapping[str, Written] | str | Path) -> System:
    """Give a system the start values by name, or those of a parameter set (SSV) at a path."""
    if isinstance(parameters, Mapping):
        return with_start_values(system, parameters)
    path = path_given("parameters", parameters)
    return with_start_values(system, read_ssv(path), path.name)


def _owner(system: System, name: str, where: str) -> tuple[str, str]:
    """Component and variable of a name."""
    return end_of(system.components, full_name(system, name), where)


def full_name(system: System, name: str) -> str:
    """Name of a variable, or a pattern, with its component's name: of a single FMU people leave that out."""
    only, *more = system.components
    return name if more or name.startswith(("*", f"{only}.")) else f"{only}.{name}"


def _typed(given: Written, variable: FmuVariable, unit: Unit | None, where: str) -> Value:
    """A value of the variable's type, in the variable's own unit."""
    if isinstance(given, SsvValue):
        if unit is None or given.unit is None or isinstance(given.value, str):
            return given.value
        try:
            return conversion(given.unit, unit, variable.relative)(float(given.value))
        except InputError as fault:
            raise InputError(f"{where}: {fault}; give it in {unit.name}") from None
    if variable.kind == "String" or (variable.kind == "Enumeration" and given in variable.items):
        return str(given)
    if variable.kind == "Boolean":
        if str(given).lower() not in _TRUTH:
            raise InputError(f"{where}: {given!r} is neither true nor false; write true or false")
        return _TRUTH[str(given).lower()]
    if variable.kind != "Real" and _WHOLE.fullmatch(str(given)):
        return int(given)  # of 64 bits, which a float does not hold
    number, written = number_and_unit(given, unit.name if unit else "", where)
    if variable.kind != "Real":
        if written or number != int(number):
            raise InputError(f"{where}: {given!r} is not a whole number; give one")
        return int(number)
    if not written or (unit and written == unit.name):
        return number
    if unit is None:
        raise InputError(f"{where}: the FMU states no unit; give the number alone, without {written}")
    return _converted(number, written, unit, variable.relative, where)


def _converted(number: float, written: str, unit: Unit, difference: bool, where: str) -> float:
    """A number in another unit, as people write it."""
    try:
        return conversion(parse_unit(spelled(written, unit.name)), meaning(unit), difference)(number)
    except InputError as fault:
        raise InputError(f"{where}: {fault}; give it in {unit.name}") from None
