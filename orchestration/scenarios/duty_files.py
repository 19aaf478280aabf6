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
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios.duty import (
    NO_PAD,
    PAD_POWER,
    PAD_TEMPERATURE,
    UNITS,
    Duty,
    Segment,
)
from warmlink.orchestration.scenarios.duty_csv import read_csv
from warmlink.orchestration.scenarios.extent import MOST_SEGMENTS, check_segments
from warmlink.orchestration.scenarios.quantity import positive, quantity
from warmlink.orchestration.text_files import (
    flag_entry,
    known_entries,
    read_toml,
    shortened,
    shown,
    text_entry,
    whole_entry,
)

LIBRARY = Path(__file__).parent / "duty_cycles"

KEYS = {"title", "reason", "stop_time", "repeat", "segment", "random"}

_RAMP_END = "ambient_temperature_end"

SHORTEST_DRAWN = 1.0
"""Shortest segment in s that can be drawn, since drawn ones last whole seconds."""

MOST_SEED = 2**63 - 1


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
    path, name = Path(source), str(source)
    if path.suffix == ".csv":
        return read_csv(path)
    if path.suffix != ".toml":
        if name not in names():
            raise InputError(f"{shortened(name)}: no such duty cycle; {instead(name, names())}")
        path = LIBRARY / f"{name}.toml"
    return parsed(read_toml(path, "give an existing .toml or .csv"), path.stem)


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
    if "random" in given:
        segments = tuple(_drawn(given["random"], stop_time, f"{name}: random"))
    else:
        _tables(given["segment"], name)
        segments = tuple(
            piece
            for i, table in enumerate(given["segment"])
            for piece in _segments(table, f"{name}: segment {i + 1}")
        )
    check_segments(len(segments), name)
    return Duty(
        name=name,
        title=text_entry(given, "title", name, name),
        reason=text_entry(given, "reason", "", name).strip(),
        stop_time=stop_time,
        segments=segments,
        repeat=flag_entry(given, "repeat", False, name),
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
    steps = whole_entry(table.get("steps", 10), 1, MOST_SEGMENTS, f"{where}.steps")
    for i in range(steps):
        share = (i + 0.5) / steps
        ambient = segment.ambient_temperature + share * (end - segment.ambient_temperature)
        yield replace(segment, duration=segment.duration / steps, ambient_temperature=ambient)


def _drawn(table: Mapping[str, Any], stop_time: float, where: str) -> Iterator[Segment]:
    """Segments drawn evenly between bounds until the stop time is filled."""
    known_entries(table, {"seed", "duration", "speed", "torque"}, where)
    seed = whole_entry(table.get("seed"), 0, MOST_SEED, f"{where}.seed")
    bounds: dict[str, tuple[float, float]] = {}
    for key in ("duration", "speed", "torque"):
        pair = table.get(key)
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"{where}.{key}: {shown(pair)} is no pair of bounds; give [lowest, highest]")
        low, high = (quantity(each, UNITS[key], f"{where}.{key}") for each in pair)
        least = SHORTEST_DRAWN if key == "duration" else 0.0
        if not least <= low <= high:
            raise InputError(
                f"{where}.{key}: from {low:g} to {high:g} {UNITS[key]} is no range; give bounds of at least "
                f"{least:g} {UNITS[key]}, the lower first"
            )
        bounds[key] = (low, high)
    check_segments(stop_time / bounds["duration"][0], f"{where}.duration")
    generator = np.random.default_rng(seed)
    time = 0.0
    while time < stop_time:
        # Whole seconds, so that the segments fall on communication points.
        duration = float(round(generator.uniform(*bounds["duration"])))
        speed, torque = (round(float(generator.uniform(*bounds[key])), 3) for key in ("speed", "torque"))
        yield Segment(duration, speed, torque)
        time += duration


def _tables(entries: Any, name: str) -> None:
    if not isinstance(entries, list) or not entries or not all(isinstance(each, dict) for each in entries):
        raise InputError(f"{name}: segment is not a list of tables; write [[segment]] above each")


def _required(table: Mapping[str, Any], key: str, where: str) -> float:
    if key not in table:
        raise InputError(f'{where}: {key} is missing; add it, for example {key} = "2 h"')
    return positive(table[key], "s", f"{where}.{key}")


def _in_range(segment: Segment, where: str) -> None:
    for name in ("speed", "torque", "pad_power", "ambient_temperature", "pad_temperature"):
        value = getattr(segment, name)
        if value < 0:
            raise InputError(f"{where}.{name}: {value:g} {UNITS[name]} is negative; give 0 or above")
