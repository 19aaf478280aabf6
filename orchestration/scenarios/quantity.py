"""Values with units as people write them, `22 degC` or `2 h`, turned into SI, and headers `name [unit]`."""

from __future__ import annotations

import math
import re

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.units import Conversion, conversion, parse_unit
from warmlink.orchestration.text_files import shortened, shown

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf|nan)\s*+(.*)$", re.DOTALL)


def quantity(text: str | float, unit: str, where: str, *, difference: bool = False) -> float:
    """Value in an SI unit; `where` says what the value is for in an error message. Raises as `in_si`."""
    try:
        return in_si(text, unit, difference=difference)
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from None


def positive(text: str | float, unit: str, where: str) -> float:
    """Value in an SI unit; raises InputError unless it is above 0."""
    value = quantity(text, unit, where)
    if value <= 0:
        raise InputError(f"{where}: {not_positive(text, unit)}")
    return value


def not_positive(text: str | float, unit: str) -> str:
    """Sentence that refuses a value which is not above 0."""
    return f"{shortened(str(text))} is not positive; give a value above 0 {unit}"


def in_si(text: str | float, unit: str, *, difference: bool = False) -> float:
    """Value in an SI unit, which is given in Modelica's notation, of `"22 degC"` or of a bare number in it.

    `difference` says that it is one of temperatures, so that 5 degC are 5 K. InputError is raised if the text
    is no number with a unit, the number is not finite, or the unit does not fit.
    """
    found = _QUANTITY.match((text if isinstance(text, str) else shown(text)).rstrip())
    if found is None:
        raise InputError(f'{shown(text)} is not a value; write it as "3.5 {unit}"')
    number, given = float(found.group(1)), found.group(2) or unit
    if not math.isfinite(number):
        raise InputError(f"{shown(text)} is not a finite number; give one in {unit}")
    if given == unit:
        return number
    return converter(given, unit, difference=difference)(number)


def converter(given: str, unit: str, where: str = "", *, difference: bool = False) -> Conversion:
    """Conversion from a unit as written to an SI unit; raises InputError if the units do not fit."""
    try:
        return conversion(parse_unit(given), parse_unit(unit), difference)
    except InputError as fault:
        raise InputError(f"{where}{': ' if where else ''}{fault}; give it in {unit}") from None


def heading(header: str) -> tuple[str, str | None]:
    """Name and unit of a column headed `name [unit]`; None if the header has no unit in brackets."""
    text = header.strip()
    name, bracket, unit = text[:-1].rpartition("[") if text.endswith("]") else ("", "", "")
    if not (bracket and name.strip()) or "]" in unit:
        return text, None
    return name.strip(), unit.strip()
