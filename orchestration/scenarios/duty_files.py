"""Duty cycles in TOML files: those that warmlink ships, and anybody's.

A duty cycle file holds `title`, `reason`, `stop_time`, perhaps `repeat`, and either `[[segment]]` tables or
one `[random]` table from whose seed the segments are drawn. A segment has `duration`, `speed`, `torque`,
`ambient_temperature` and, for a heating pad, `pad_temperature` or `pad_power`; `ambient_temperature_end` and
`steps` make it a ramp. Values are strings with a unit, as `"3.43 rad/s"`; what is left out is 0, or 22 degC.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.duty import (
    NO_PAD,
    PAD_POWER,
    PAD_TEMPERATURE,
    UNITS,
    Duty,
    Segment,
)
from warmlink.orchestration.scenarios.duty_csv import read_csv
from warmlink.orchestration.scenarios.quantity import positive, quantity
from warmlink.orchestration.scenarios.toml_file import is_file, read_tables, text

LIBRARY = Path(__file__).parent / "duty_cycles"

KEYS = {"title", "reason", "stop_time", "repeat", "segment", "random"}

MOST_SEGMENTS = 100_000
"""A day in segments of a second each has 86,400."""

_TOO_MANY = f"more than {MOST_SEGMENTS} segments, which is a day in segments of a second each"

_RAMP_END = "ambient_temperature_end"


def names() -> list[str]:
    """Names of the duty cycles in the library."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def load(source: str | Path) -> Duty:
    """Duty cycle from the library by name, or from a .toml or .csv file by path.

    Raises
    ------
    InputError
        There is no such duty cycle, or its file cannot be used.
    """
    path = Path(source)
    if path.suffix not in {".toml", ".csv"}:
        path = LIBRARY / f"{source}.toml"
        if not is_file(path):
            raise InputError(f"{source}: no such duty cycle; choose {', '.join(names())}")
    if not is_file(path):
        raise InputError(f"{path}: no such file; give an existing .toml or .csv")
    return read_csv(path) if path.suffix == ".csv" else read_toml(path)


def read_toml(path: Path) -> Duty:
    """Duty cycle from a TOML file; the module's docstring says what it holds.

    Raises
    ------
    InputError
        The file is not TOML, misses or misspells something, or a value is out of range.
    """
    return parsed(read_tables(path), path.stem)


def parsed(given: Mapping[str, Any], name: str) -> Duty:
    """Duty cycle from the tables of a file.

    Raises
    ------
    InputError
        Something is missing, misspelt or out of range.
    """
    known_entries(given, KEYS, name)
    stop_time = _required(given, "stop_time", name)
    if ("segment" in given) == ("random" in given):
        raise InputError(f"{name}: give either [[segment]] tables or one [random] table")
    _tables(given.get("segment", []), name)
    if "random" in given:
        segments = tuple(_drawn(given["random"], stop_time, f"{name}: random"))
    else:
        segments = tuple(
            piece
            for i, table in enumerate(given["segment"])
            for piece in _segments(table, f"{name}: segment {i + 1}")
        )
    if len(segments) > MOST_SEGMENTS:
        raise InputError(f"{name}: {_TOO_MANY}; use longer ones, or repeat")
    repeat = given.get("repeat", False)
    if not isinstance(repeat, bool):
        raise InputError(f"{name}: repeat: {repeat!r} says neither yes nor no; write true or false")
    return Duty(
        name=name,
        title=text(given.get("title", name), f"{name}: title"),
        reason=text(given.get("reason", ""), f"{name}: reason").strip(),
        stop_time=stop_time,
        segments=segments,
        repeat=repeat,
    )


def library() -> Sequence[Duty]:
    """Every duty cycle of the library."""
    return [load(name) for name in names()]


def _segments(table: Mapping[str, Any], where: str) -> Iterator[Segment]:
    known_entries(table, {*UNITS, _RAMP_END, "steps"}, where)
    values = {
        key: quantity(table[key], unit, f"{where}.{key}") for key, unit in UNITS.items() if key in table
    }
    end = quantity(table[_RAMP_END], "K", f"{where}.{_RAMP_END}") if _RAMP_END in table else None
    _required(table, "duration", where)
    if "pad_temperature" in values and "pad_power" in values:
        raise InputError(f"{where}: pad_temperature and pad_power exclude each other; give one")
    mode = PAD_TEMPERATURE if "pad_temperature" in values else PAD_POWER if "pad_power" in values else NO_PAD
    segment = Segment(**values, pad_mode=mode)
    _in_range(segment, where)
    if end is None:
        yield segment
        return
    _in_range(replace(segment, ambient_temperature=end), where)
    steps = table.get("steps", 10)
    if isinstance(steps, bool) or not isinstance(steps, int) or not 1 <= steps <= MOST_SEGMENTS:
        raise InputError(
            f"{where}.steps: {steps!r:.60} is no number of steps; give a whole number, 1 to {MOST_SEGMENTS}"
        )
    for i in range(steps):
        share = (i + 0.5) / steps
        ambient = segment.ambient_temperature + share * (end - segment.ambient_temperature)
        yield replace(segment, duration=segment.duration / steps, ambient_temperature=ambient)


def _drawn(table: Mapping[str, Any], stop_time: float, where: str) -> Iterator[Segment]:
    """Segments drawn evenly between bounds until the stop time is filled."""
    known_entries(table, {"seed", "duration", "speed", "torque"}, where)
    seed = table.get("seed")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"{where}.seed: {seed!r} is no seed; give a whole number, 0 or above")
    bounds: dict[str, tuple[float, float]] = {}
    for key in ("duration", "speed", "torque"):
        pair = table.get(key)
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"{where}.{key}: {pair!r} is no pair of bounds; give [lowest, highest]")
        low, high = (quantity(each, UNITS[key], f"{where}.{key}") for each in pair)
        if not 0 <= low <= high:
            raise InputError(
                f"{where}.{key}: from {low:g} to {high:g} {UNITS[key]} is no range; mend the bounds"
            )
        bounds[key] = (low, high)
    shortest = bounds["duration"][0]
    if shortest < 1:
        raise InputError(
            f"{where}.duration: {shortest:g} s is too short, durations being drawn in whole seconds; "
            "give 1 s or more"
        )
    if stop_time / shortest > MOST_SEGMENTS:
        raise InputError(
            f"{where}.duration: a stop time of {stop_time:g} s may take {_TOO_MANY}; give longer ones, or an "
            "earlier stop"
        )
    generator = np.random.default_rng(seed)
    time = 0.0
    while time < stop_time:
        # Whole seconds, so that the segments fall on communication points.
        duration = float(round(generator.uniform(*bounds["duration"])))
        speed, torque = (round(float(generator.uniform(*bounds[key])), 3) for key in ("speed", "torque"))
        yield Segment(duration, speed, torque)
        time += duration


def _tables(entries: Any, name: str) -> None:
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{name}: segment is not a list of tables; write [[segment]] above each")


def known_entries(table: Any, allowed: set[str], where: str) -> None:
    """Raise InputError where a table of a file is none, or has an entry that it may not have."""
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: {table!r} is no table; give {', '.join(sorted(allowed))}")
    unknown = sorted(set(table) - allowed)
    if unknown:
        raise InputError(f"{where}: unknown entry {unknown[0]!r}; it may have {', '.join(sorted(allowed))}")


def _required(table: Mapping[str, Any], key: str, where: str) -> float:
    if key not in table:
        raise InputError(f'{where}: {key} is missing; add it, for example {key} = "2 h"')
    return positive(table[key], "s", f"{where}.{key}")


def _in_range(segment: Segment, where: str) -> None:
    for name in ("speed", "torque", "pad_power", "ambient_temperature", "pad_temperature"):
        value = getattr(segment, name)
        if value < 0:
            raise InputError(f"{where}.{name}: {value:g} {UNITS[name]} is negative; give 0 or above")
