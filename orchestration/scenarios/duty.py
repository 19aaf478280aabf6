"""Duty cycles: what the cell is asked to do, read from TOML or from a recorded CSV.

A duty cycle file holds `title`, `reason`, `stop_time`, perhaps `repeat`, and either `[[segment]]` tables or one
`[random]` table from whose seed the segments are drawn. A segment has `duration`, `speed`, `torque`,
`ambient_temperature` and, for a heating pad, `pad_temperature` or `pad_power`; `ambient_temperature_end` and
`steps` make it a ramp. Values are strings with a unit, as `"3.43 rad/s"`; what is left out is 0, or 22 degC.
"""

from __future__ import annotations

import csv
import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS, EARLY
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.quantities import ROOM_TEMPERATURE

LIBRARY = Path(__file__).parent / "duty_cycles"

UNITS = {
    "stop_time": "s",
    "duration": "s",
    "speed": "rad/s",
    "torque": "N*m",
    "ambient_temperature": "K",
    "ambient_temperature_end": "K",
    "pad_temperature": "K",
    "pad_power": "W",
}
"""SI unit of every quantity in a duty cycle file."""

NO_PAD, PAD_POWER, PAD_TEMPERATURE = 0, 1, 2
"""Values of `pad_mode`."""

_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*$")
_COLUMN = re.compile(r"^\s*(\w+)\s*(?:\[(.*)\])?\s*$")


@dataclass(frozen=True)
class Segment:
    """Constant demands over a time: s, rad/s, N.m, K, pad mode, K, W."""

    duration: float
    speed: float = 0.0
    torque: float = 0.0
    ambient_temperature: float = ROOM_TEMPERATURE
    pad_mode: int = NO_PAD
    pad_temperature: float = ROOM_TEMPERATURE
    pad_power: float = 0.0

    @property
    def demands(self) -> tuple[float, ...]:
        """Demands in the order of `DEMANDS`."""
        return tuple(float(getattr(self, name)) for name in DEMANDS)


@dataclass(frozen=True)
class Duty:
    """A duty cycle.

    Attributes
    ----------
    name, title, reason : what it is called, in short and in a line, and why it is as it is
    stop_time : in s
    segments : one after the other; the last one holds, or all begin again where `repeat` is set
    """

    name: str
    title: str
    reason: str
    stop_time: float
    segments: tuple[Segment, ...]
    repeat: bool = False

    @property
    def fits_component(self) -> bool:
        """Whether the DutyCycle component can hold it; a finer one is fed by the master as a table."""
        return len(self.segments) <= SEGMENTS

    def component_parameters(self) -> dict[str, float]:
        """Parameters of the DutyCycle component, by scalar name.

        Raises
        ------
        InputError
            There are more segments than the component has.
        """
        if not self.fits_component:
            raise InputError(
                f"{self.name}: {len(self.segments)} segments are more than the DutyCycle component's {SEGMENTS}; "
                "feed it as a table"
            )
        values = {"repeat": float(self.repeat)}
        for i in range(SEGMENTS):
            segment = self.segments[i] if i < len(self.segments) else Segment(0.0)
            values[f"duration[{i + 1}]"] = segment.duration
            for name, value in zip(DEMANDS, segment.demands, strict=True):
                values[f"segment_{name}[{i + 1}]"] = value
        return values

    def table(self, step: float, stop_time: float | None = None) -> NDArray[np.float64]:
        """Demands at the communication points, as the DutyCycle component gives them.

        Parameters
        ----------
        step : communication step size in s
        stop_time : in s, that of the duty cycle by default

        Returns
        -------
        numpy.ndarray
            One row of `DEMANDS` a communication point, the start included, shape (n + 1, 6).
        """
        count = round((self.stop_time if stop_time is None else stop_time) / step)
        time = step * np.arange(count + 1) + EARLY
        ends = np.cumsum([segment.duration for segment in self.segments])
        if self.repeat:
            time = time % ends[-1]
        which = np.minimum(np.searchsorted(ends, time, side="right"), len(self.segments) - 1)
        return np.array([segment.demands for segment in self.segments])[which]


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
        if not path.is_file():
            raise InputError(f"duty cycle {str(source)!r} is not in the library; it has {', '.join(names())}")
    if not path.is_file():
        raise InputError(f"duty cycle file {path} is not there; give an existing .toml or .csv")
    return read_csv(path) if path.suffix == ".csv" else read_toml(path)


def read_toml(path: Path) -> Duty:
    """Duty cycle from a TOML file; the module's docstring says what it holds.

    Raises
    ------
    InputError
        The file is not TOML, misses or misspells something, or a value is out of range.
    """
    try:
        given = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as fault:
        raise InputError(f"{path.name}: not readable as TOML ({fault}); mend the file") from None
    return parsed(given, path.stem)


def parsed(given: Mapping[str, Any], name: str) -> Duty:
    """Duty cycle from the tables of a file.

    Raises
    ------
    InputError
        Something is missing, misspelt or out of range.
    """
    _known(given, {"title", "reason", "stop_time", "repeat", "segment", "random"}, name)
    stop_time = _positive(given, "stop_time", name)
    if ("segment" in given) == ("random" in given):
        raise InputError(f"{name}: give either [[segment]] tables or one [random] table")
    if "random" in given:
        segments = tuple(_drawn(given["random"], stop_time, f"{name}: random"))
    else:
        segments = tuple(
            piece
            for i, table in enumerate(given["segment"])
            for piece in _segments(table, f"{name}: segment {i + 1}")
        )
    return Duty(
        name=name,
        title=str(given.get("title", name)),
        reason=str(given.get("reason", "")).strip(),
        stop_time=stop_time,
        segments=segments,
        repeat=bool(given.get("repeat", False)),
    )


def read_csv(path: Path) -> Duty:
    """Recorded duty cycle from a CSV file with a header of `name [unit]`, `time [s]` first among them.

    Inputs hold until the next row, an empty cell holds the last value, an empty pad cell switches the pad off.

    Raises
    ------
    InputError
        A column or unit is unknown, a cell is no number, or time does not increase.
    """
    with path.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise InputError(f"{path.name}: no rows; give a header and at least two times")
    columns = [_column(cell, path.name) for cell in rows[0]]
    labels = [name for name, _ in columns]
    if "time" not in labels:
        raise InputError(f"{path.name}: no column 'time [s]'; add it")
    times: list[float] = []
    segments: list[Segment] = []
    last = Segment(0.0)
    for number, row in enumerate(rows[1:], start=2):
        where = f"{path.name}: line {number}"
        cells = {
            name: convert(_number(cell, where, name), where) if cell.strip() else None
            for (name, convert), cell in zip(columns, row, strict=False)
        }
        time = cells.pop("time", None)
        if time is None or (times and time <= times[-1]):
            raise InputError(f"{where}: time is missing or does not increase; give increasing times")
        times.append(time)
        last = replace(last, **_held(cells))
        segments.append(last)
    durations = np.diff(times)
    segments = [replace(s, duration=float(d)) for s, d in zip(segments, durations, strict=False)]
    if len(segments) < 1 or not len(durations):
        raise InputError(f"{path.name}: only one time; give at least two")
    return Duty(path.stem, path.stem, f"recorded, {path.name}", float(times[-1] - times[0]), tuple(segments))


def quantity(text: Any, unit: str, where: str) -> float:
    """Value in an SI unit of a string with a unit, as `"22 degC"`.

    Raises
    ------
    InputError
        It is no number with a unit, or the unit does not fit.
    """
    match = _QUANTITY.match(text) if isinstance(text, str) else None
    if match is None or match[2] is None:
        raise InputError(f"{where}: {text!r} is no number with a unit; write for example '1 {unit}' in quotes")
    return float(_converter(match[2], unit, where)(float(match[1])))


def _held(cells: Mapping[str, float | None]) -> dict[str, Any]:
    """What a row changes: given cells, and the pad's mode by its temperature."""
    changes: dict[str, Any] = {
        name: value for name, value in cells.items() if value is not None and name in UNITS
    }
    if "pad_temperature" in cells:
        changes["pad_mode"] = NO_PAD if cells["pad_temperature"] is None else PAD_TEMPERATURE
    return changes


def _segments(table: Mapping[str, Any], where: str) -> Iterator[Segment]:
    allowed = {*UNITS, "steps"} - {"stop_time"}
    _known(table, allowed, where)
    values = {key: quantity(value, UNITS[key], f"{where}.{key}") for key, value in table.items() if key != "steps"}
    end = values.pop("ambient_temperature_end", None)
    _positive(table, "duration", where)
    if "pad_temperature" in values and "pad_power" in values:
        raise InputError(f"{where}: pad_temperature and pad_power exclude each other; give one")
    mode = PAD_TEMPERATURE if "pad_temperature" in values else PAD_POWER if "pad_power" in values else NO_PAD
    segment = Segment(**values, pad_mode=mode)
    _in_range(segment, where)
    if end is None:
        yield segment
        return
    steps = table.get("steps", 10)
    if not isinstance(steps, int) or steps < 1:
        raise InputError(f"{where}.steps: {steps!r} is no number of steps; give a whole number above 0")
    for i in range(steps):
        share = (i + 0.5) / steps
        ambient = segment.ambient_temperature + share * (end - segment.ambient_temperature)
        yield replace(segment, duration=segment.duration / steps, ambient_temperature=ambient)


def _drawn(table: Mapping[str, Any], stop_time: float, where: str) -> Iterator[Segment]:
    """Segments drawn evenly between bounds until the stop time is filled."""
    _known(table, {"seed", "duration", "speed", "torque"}, where)
    seed = table.get("seed")
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"{where}.seed: {seed!r} is no seed; give a whole number, 0 or above")
    bounds: dict[str, tuple[float, float]] = {}
    for key in ("duration", "speed", "torque"):
        pair = table.get(key)
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"{where}.{key}: {pair!r} is no pair of bounds; give [lowest, highest]")
        low, high = (quantity(each, UNITS[key], f"{where}.{key}") for each in pair)
        if not 0 <= low <= high or (key == "duration" and low <= 0):
            raise InputError(f"{where}.{key}: from {low:g} to {high:g} {UNITS[key]} is no range; mend the bounds")
        bounds[key] = (low, high)
    generator = np.random.default_rng(seed)
    time = 0.0
    while time < stop_time:
        # Whole seconds, so that the segments fall on communication points.
        duration = float(round(generator.uniform(*bounds["duration"])))
        speed, torque = (round(float(generator.uniform(*bounds[key])), 3) for key in ("speed", "torque"))
        yield Segment(duration, speed, torque)
        time += duration


def _known(table: Any, allowed: set[str], where: str) -> None:
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: {table!r} is no table; give {', '.join(sorted(allowed))}")
    unknown = sorted(set(table) - allowed)
    if unknown:
        raise InputError(f"{where}: unknown entry {unknown[0]!r}; it may have {', '.join(sorted(allowed))}")


def _positive(table: Mapping[str, Any], key: str, where: str) -> float:
    if key not in table:
        raise InputError(f"{where}: {key} is missing; add it, for example {key} = \"2 h\"")
    value = quantity(table[key], UNITS[key], f"{where}.{key}")
    if not value > 0:
        raise InputError(f"{where}.{key}: {value:g} {UNITS[key]} is not positive; give one above 0")
    return value


def _in_range(segment: Segment, where: str) -> None:
    for name in ("speed", "torque", "pad_power", "ambient_temperature", "pad_temperature"):
        value = getattr(segment, name)
        if value < 0:
            raise InputError(f"{where}.{name}: {value:g} {UNITS[name]} is negative; give 0 or above")


def _column(cell: str, where: str) -> tuple[str, Callable[[float], float]]:
    match = _COLUMN.match(cell)
    if match is None:
        raise InputError(f"{where}: column {cell!r} is not of the form 'name [unit]'; rename it")
    name, unit = match[1], match[2]
    target = "s" if name == "time" else UNITS.get(name)
    if target is None:  # measured channels may stand beside the duty; they are not part of it
        return name, lambda value: value
    if not unit:
        raise InputError(f"{where}: column {name!r} has no unit; write '{name} [{target}]'")
    return name, _converter(unit, target, f"{where}: column {name!r}")


def _number(cell: str, where: str, name: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {cell.strip()!r} in column {name!r} is no number; mend or empty the cell")
    return value


def _converter(unit: str, target: str, where: str) -> Callable[[float], float]:
    registry = _registry()
    try:
        source = registry.Unit(unit)
        registry.Quantity(1.0, source).to(target)
    except Exception as fault:  # pint's parser raises many kinds
        raise InputError(f"{where}: unit {unit!r} does not convert to {target} ({type(fault).__name__})") from None
    return lambda value: float(registry.Quantity(value, source).to(target).magnitude)


@lru_cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def library() -> Sequence[Duty]:
    """Every duty cycle of the library."""
    return [load(name) for name in names()]
