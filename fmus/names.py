"""Remedies for a name that does not exist: the most similar names, or a choice that fits on a line."""

from collections.abc import Iterable
from difflib import SequenceMatcher
from os import PathLike

from warmlink.fmus.errors import InputError

MOST_LISTED = 12
"""Names that a sentence lists; the rest are counted."""

_NEAR = 0.6
_MOST_MEANT = 3
_SHORTEST_PART = 3


def listed(names: Iterable[str], joint: str = "and") -> str:
    """Join names as `a, b and c`; if there are many, the first ones and the number of the others."""
    every = list(names)
    more = len(every) - MOST_LISTED
    if more > 0:
        return f"{', '.join(every[:MOST_LISTED])} and {more} more"
    return f" {joint} ".join(part for part in (", ".join(every[:-1]), *every[-1:]) if part) or "none"


def several(given: str | PathLike[str] | Iterable[str | PathLike[str]]) -> list[str]:
    """The names, or paths, given: those of a list, or the only one; InputError if it is neither."""
    if not isinstance(given, Iterable | PathLike):
        raise InputError(f"{given!r}: is neither a name nor a list of names; give such, or leave it out")
    return [str(each) for each in ([given] if isinstance(given, str | PathLike) else given)]


def instead(name: object, known: Iterable[str], otherwise: str = "") -> str:
    """Remedy for a name that does not exist: `did you mean lag?` if a name is similar, else `choose a or b`.

    Then it ends with what else could be given, as "or give a TOML file".
    """
    name, every = str(name), list(known)
    near = _nearest(name, every)
    if near:
        return f"did you mean {listed(near, 'or')}?"
    ranked = every if len(every) <= MOST_LISTED else sorted(every, key=lambda each: -_likeness(name, each))
    choice = f"choose {listed(ranked, 'or')}" if ranked else "there are none"
    return f"{choice}, {otherwise}" if otherwise else choice


def _nearest(name: str, known: list[str]) -> list[str]:
    """The names that were probably meant: those that contain the given one, else the most similar one."""
    lower = name.lower()
    same = [each for each in known if each.lower() == lower]
    if same:
        return same[:1]
    holding = [each for each in known if lower in each.lower()] if len(name) >= _SHORTEST_PART else []
    if 0 < len(holding) <= _MOST_MEANT:
        return holding
    best = max(known, key=lambda each: _likeness(name, each), default="")
    return [best] if best and _likeness(name, best) >= _NEAR else []


def _likeness(name: str, other: str) -> float:
    return SequenceMatcher(None, name.lower(), other.lower()).ratio()
