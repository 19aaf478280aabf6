"""Headers as people write them, `T (degC)`, `T_degC`, `Shaft temperature [°C]`: a name and a unit."""

from __future__ import annotations

import re
from collections.abc import Iterator

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.quantity import converter, heading
from warmlink.orchestration.system.units import Conversion, parse_unit

TIME = "time"

TIMES = (TIME, "timestamp", "time_stamp", "datetime", "date_time", "date", "elapsed", "elapsed_time", "t")
"""Names of a column of times, the first of them before the others."""

_FORMS = (
    re.compile(r"(.+?)\s*\((.*)\)"),
    re.compile(r"(.+?)\s+(?:/|in)\s+(\S+)"),
)
_SPELLINGS = {
    "C": "degC",
    "ºC": "degC",
    "℃": "degC",
    "Â°C": "degC",
    "Celsius": "degC",
    "Deg C": "degC",
    "F": "degF",
    "Nm": "N.m",
    "NM": "N.m",
    "mNm": "mN.m",
    "1/min": "rpm",
    "U/min": "rpm",
    "rad_s": "rad/s",
    "rad_per_s": "rad/s",
    "rads": "rad/s",
    "S": "s",
    "Sec": "s",
    "seconds": "s",
    "hh:mm:ss": "s",
}
"""Spellings that would mean something else, or nothing, where a unit of this quantity is due."""


def plain(name: str) -> str:
    """Name as it is compared: `Shaft Temperature` is `shaft_temperature`."""
    return re.sub(r"[^\w.\[\]]+", "_", name.strip()).strip("_").lower()


def name_and_unit(header: str) -> tuple[str, str | None]:
    """Name and unit of a header; None where it has no unit, in brackets or behind `/` or `in`."""
    name, unit = heading(header)
    for form in _FORMS if unit is None else ():
        found = form.fullmatch(name)
        if found and is_unit(found[2]):
            return found[1].strip(), found[2].strip()
    return name, unit


def is_unit(text: str) -> bool:
    """Whether a text is a unit, with or without brackets."""
    bare = re.sub(r"^[\[(](.*)[\])]$", r"\1", text.strip()).strip()
    if not bare or bare in _SPELLINGS:
        return bool(bare)
    try:
        parse_unit(bare)
    except InputError:
        return False
    return not bare.isdigit()


def conversion_to(unit: str, si_unit: str, where: str, *, difference: bool) -> tuple[Conversion, str]:
    """Conversion of a unit as loggers spell it to an SI unit, and how we spell it; raises InputError."""
    try:
        return converter(unit, si_unit, where, difference=difference), unit
    except InputError:
        if unit not in _SPELLINGS:
            raise
        return converter(_SPELLINGS[unit], si_unit, where, difference=difference), _SPELLINGS[unit]


def with_suffix(name: str) -> Iterator[tuple[str, str]]:
    """Every way in which a name may end in a unit, as `T_degC` and `speed_rad_s` do."""
    parts = re.split(r"[_ ]", name)
    for i in range(1, len(parts)):
        unit = "_".join(parts[i:])
        if is_unit(unit):
            yield "_".join(parts[:i]), unit


def converts(unit: str, si_unit: str) -> bool:
    """Whether a unit measures the quantity of an SI unit."""
    try:
        conversion_to(unit, si_unit, "", difference=False)
    except InputError:
        return False
    return True
