"""Values with units as people write them: `"22 degC"`, `"2.5 Nm"`, or a bare number in the SI unit."""

from __future__ import annotations

import math
import re

from warmlink.fmus.component.quantities import TEMPERATURES
from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.units import Conversion, conversion, parse_unit, spelled
from warmlink.orchestration.text_files import shortened, shown

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf|nan)\s*+(.*)$", re.DOTALL)


def positive(text: str | float, unit: str, where: str) -> float:
    """Value in an SI unit; raises InputError unless it is above 0."""
    value = quantity(text, unit, where)
    if value <= 0:
        raise InputError(f"{where}: {not_positive(text, unit)}")
    return value


def not_positive(text: str | float, unit: str) -> str:
    """Sentence that refuses a value which is not above 0."""
    above = "0" if unit == "1" else f"0 {unit}"
    return f"{shortened(str(text))} is not positive; give a value above {above}"


def quantity(text: str | float, unit: str, where: str = "", *, difference: bool = False) -> float:
    """Value in an SI unit, which is given in Modelica's notation, of `"22 degC"` or of a bare number in it.

    `where` says what the value is for in an error message; `difference`, that it is one of temperatures, so
    that 5 degC are 5 K. InputError is raised if the text is no number with a unit, the number is not finite,
    or the unit does not fit.
    """
    number, given = number_and_unit(text, unit, where)
    return number if given in ("", unit) else converter(given, unit, where, difference=difference)(number)


def number_and_unit(text: str | float, unit: str, where: str = "") -> tuple[float, str]:
    """Number and unit of `"22 degC"`; the unit is empty where none is given. Raises as `quantity`."""
    found = _QUANTITY.match((text if isinstance(text, str) else shown(text)).rstrip())
    place = f"{where}: " if where else ""
    if found is None:
        raise InputError(f'{place}{shown(text)} is not a value; write it as "{f"3.5 {unit}".strip()}"')
    number = float(found.group(1))
    if not math.isfinite(number):
        raise InputError(f"{place}{shown(text)} is not a finite number; give one in {unit or 'digits'}")
    return number, found.group(2)


def refuse_bare(value: str | float, unit: str, where: str = "") -> None:
    """Raise InputError if a number has no unit and is hardly meant in the SI unit.

    That is so of every length but 0, which people give in um, mm or m, and of temperatures too cold for any
    plant.
    """
    text = value.strip() if isinstance(value, str) else shown(value)
    found = _QUANTITY.match(text)
    if found is None or found.group(2):
        return
    number = float(found.group(1))
    if (unit == "m" and number != 0) or (unit == "K" and number < TEMPERATURES.low):
        place, other = f"{where}: " if where else "", {"m": "um", "K": "degC"}[unit]
        told = f'write "{text} {other}" or "{text} {unit}", whichever is meant'
        raise InputError(f"{place}{text} has no unit; {told}")


def bare(text: str | float) -> float:
    """Number that stands before the unit in what `quantity` takes."""
    found = _QUANTITY.match(str(text))
    return float(found.group(1)) if found else math.nan


def converter(given: str, unit: str, where: str = "", *, difference: bool = False) -> Conversion:
    """Conversion from a unit as people write it to an SI unit; raises InputError if the units do not fit."""
    try:
        return conversion(parse_unit(spelled(given, unit)), parse_unit(unit), difference)
    except InputError as fault:
        raise InputError(f"{where}{': ' if where else ''}{fault}; give it in {unit}") from None


def heading(header: str) -> tuple[str, str | None]:
    """Name and unit of a column headed `name [unit]`; None if the header has no unit in brackets."""
    text = header.strip()
    name, bracket, unit = text[:-1].rpartition("[") if text.endswith("]") else ("", "", "")
    if not (bracket and name.strip()) or "]" in unit:
        return text, None
    return name.strip(), unit.strip()
