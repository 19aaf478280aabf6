"""Duty cycles: what a joint is made to do, segment by segment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.quantities import ROOM_TEMPERATURE
from warmlink.orchestration.scenarios.quantity import positive, quantity

LARGEST_COUNT = 32
"""Segments that the DutyCycle component holds."""

PAD_NONE, PAD_POWER, PAD_TEMPERATURE = 0, 1, 2


@dataclass(frozen=True)
class Segment:
    """A stretch of constant duty: s, rad/s, N.m, K and W; at most one of the pad's two values is given."""

    duration: float
    speed: float = 0.0
    torque: float = 0.0
    ambient_temperature: float = ROOM_TEMPERATURE
    pad_temperature: float | None = None
    pad_power: float | None = None

    @property
    def pad_mode(self) -> int:
        """The motor's `pad_mode`: 0 none, 1 a power, 2 held at a temperature."""
        if self.pad_temperature is not None:
            return PAD_TEMPERATURE
        return PAD_NONE if self.pad_power is None else PAD_POWER


@dataclass(frozen=True)
class DutyCycle:
    """Segments one after the other; the last one holds, or all of them begin anew."""

    segments: tuple[Segment, ...]
    repeat: bool = False

    def parameters(self) -> dict[str, float | bool]:
        """Start values of the DutyCycle component."""
        values: dict[str, float | bool] = {"repeat": self.repeat}
        for i, segment in enumerate(self.segments, start=1):
            values[f"duration[{i}]"] = segment.duration
            values[f"segment_speed[{i}]"] = segment.speed
            values[f"segment_torque[{i}]"] = segment.torque
            values[f"segment_ambient_temperature[{i}]"] = segment.ambient_temperature
            values[f"segment_pad_mode[{i}]"] = segment.pad_mode
            if segment.pad_temperature is not None:
                values[f"segment_pad_temperature[{i}]"] = segment.pad_temperature
            if segment.pad_power is not None:
                values[f"segment_pad_power[{i}]"] = segment.pad_power
        return values


_UNITS = {
    "speed": "rad/s",
    "torque": "N.m",
    "ambient_temperature": "K",
    "pad_temperature": "K",
    "pad_power": "W",
}


def read_duty(tables: Sequence[Mapping[str, Any]], repeat: bool, where: str) -> DutyCycle:
    """Duty cycle from the `[[segment]]` tables of a TOML file.

    Raises
    ------
    InputError
        If a segment has an unknown key, a value that does not fit, no duration, or two pads at once.
    """
    if not tables:
        raise InputError(f"{where}: no [[segment]]; give at least one with a duration")
    if len(tables) > LARGEST_COUNT:
        raise InputError(
            f"{where}: {len(tables)} segments; at most {LARGEST_COUNT} fit, so use repeat or longer ones"
        )
    return DutyCycle(
        tuple(_segment(table, f"{where}: segment {i}") for i, table in enumerate(tables, start=1)), repeat
    )


def _segment(table: Mapping[str, Any], where: str) -> Segment:
    known = {"duration", *_UNITS}
    unknown = sorted(set(table) - known)
    if unknown:
        raise InputError(f"{where}: {unknown[0]} is not known; use {', '.join(sorted(known))}")
    if "duration" not in table:
        raise InputError(f'{where}: no duration; give one, as duration = "30 min"')
    if "pad_temperature" in table and "pad_power" in table:
        raise InputError(f"{where}: pad_temperature and pad_power at once; give one of the two")
    values = {
        key: quantity(table[key], unit, f"{where}: {key}") for key, unit in _UNITS.items() if key in table
    }
    return Segment(positive(table["duration"], "s", f"{where}: duration"), **values)
