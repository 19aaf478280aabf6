"""Attribute texts as values, with an error that says where the text stands."""

from __future__ import annotations

import math
from typing import Any

from warmlink.fmus.errors import InputError


def required(element: Any, name: str, where: str) -> str:
    """Give an attribute that the standard demands.

    Raises
    ------
    InputError
        If it is absent.
    """
    text = element.get(name)
    if text is None:
        raise InputError(f"{where}: {_tag(element)} lacks its attribute {name}")
    return str(text)


def any_number(text: str, where: str) -> float:
    """Give a number that may be NaN or infinite, as an xs:double may.

    Raises
    ------
    InputError
        If the text is no number.
    """
    try:
        if "_" not in text:
            return float(text)
    except ValueError:
        pass
    raise InputError(f"{where}: {text!r} is not a number")


def number(text: str, where: str) -> float:
    """Give a finite number.

    Raises
    ------
    InputError
        If the text is no number, or NaN or infinite.
    """
    value = any_number(text, where)
    if not math.isfinite(value):
        raise InputError(f"{where}: {text!r} is not a finite number")
    return value


def integer(text: str, where: str) -> int:
    """Give an integer of at most 64 bits.

    Raises
    ------
    InputError
        If the text is none.
    """
    try:
        value = int(text)
    except ValueError:
        value = 1 << 64
    if not -(1 << 63) <= value < 1 << 64 or "_" in text:
        raise InputError(f"{where}: {text!r} is not an integer of 64 bits")
    return value


def optional_number(element: Any, name: str, where: str) -> float | None:
    """Give an attribute as a finite number, or None where it is absent."""
    text = element.get(name)
    return None if text is None else number(text, f"{where}: {name}")


def optional_integer(element: Any, name: str, where: str) -> int | None:
    """Give an attribute as an integer, or None where it is absent."""
    text = element.get(name)
    return None if text is None else integer(text, f"{where}: {name}")


def boolean(element: Any, name: str, where: str, default: bool) -> bool:
    """Give an attribute as a truth value, or the default where it is absent.

    Raises
    ------
    InputError
        If it is neither true nor false (nor 1 nor 0).
    """
    text = element.get(name)
    if text is None:
        return default
    if text.strip() not in ("true", "false", "1", "0"):
        raise InputError(f"{where}: {name} is {text!r}, neither true nor false")
    return text.strip() in ("true", "1")


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
