"""What can go wrong on a shop floor with each of a controller's signals, and with the controller's supply."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from benchmarks.rollout import Array
from benchmarks.told import STEP, Restart, Told

BASE, TIP, SHAFT, WINDING = (f"{place}_temperature" for place in ("base", "tip", "shaft", "winding"))
AMBIENT, SPEED, TORQUE = "ambient_temperature", "speed", "torque"

WHERE = {"base": (BASE,), "tip": (TIP,), "both": (BASE, TIP)}
"""Thermometers that fail together."""

ONSETS = ("from the start", "while it runs")

ALIKE = (
    *(f"both drifts {rate:+d} K/h" for rate in (-5, -1, 1, 5)),
    *(f"both delayed {minutes} min" for minutes in (10, 30, 60)),
    *("both rise x 0.5", "both rise x 1.5"),
)
"""How the kinds begin of which nothing but a camera tells."""

UNTOLD = (
    "all thermometers are wrong in the same way, and only the duty is left to say so, whose model may be "
    "wrong by as much"
)

Change = Callable[[Array, Told, Generator], Array]
"""Values of a signal in its place: of its sound values from the onset on, the run from then, and chance."""


@dataclass(frozen=True)
class Kind:
    """A kind of fault: what it is called, to which group it belongs, and what it does to a run."""

    group: str
    name: str
    apply: Callable[[Told, Generator], Told]

    @property
    def untold(self) -> bool:
        """Whether nothing but a camera can tell of it, for the reason of `UNTOLD`."""
        return self.name.startswith(ALIKE)


def kinds() -> list[Kind]:
    """All kinds, those of one signal, of several, and restarts."""
    return [*_thermometers(), *_duty(), *_ambient(), *_camera(), *_restarts()]


def _shift(by: float) -> Change:
    return lambda values, told, draw: values + by


def _ramp(per_hour: float) -> Change:
    return lambda values, told, draw: values + per_hour / 3600 * STEP * np.arange(len(values))


def _scale(factor: float, about: float = 0.0) -> Change:
    return lambda values, told, draw: about + factor * (values - about)


def _constant(value: float) -> Change:
    return lambda values, told, draw: np.full_like(values, value)


def _stuck(values: Array, told: Told, draw: Generator) -> Array:
    return np.full_like(values, values[0])


def _delayed(seconds: float) -> Change:
    count = round(seconds / STEP)
    return lambda values, told, draw: np.concatenate([np.full(count, values[0]), values])[: len(values)]


def _once(value: float, every: float | None = None) -> Change:
    def change(values: Array, told: Told, draw: Generator) -> Array:
        return _replaced(values, slice(0, None if every else 1, round((every or 1) / STEP)), value)

    return change


def _now_and_then(share: float, change: Change) -> Change:
    def changed(values: Array, told: Told, draw: Generator) -> Array:
        return np.where(draw.random(len(values)) < share, change(values, told, draw), values)

    return changed


def _noise(size: float) -> Change:
    return lambda values, told, draw: values + size * draw.normal(size=len(values))


def _quantised(quantum: float) -> Change:
    return lambda values, told, draw: quantum * np.floor((values - 273.15) / quantum + 0.5) + 273.15


def _reads(other: str) -> Change:
    return lambda values, told, draw: told[other]


def _replaced(values: Array, where: slice, value: float) -> Array:
    changed = values.copy()
    changed[where] = value
    return changed


def _applied(names: tuple[str, ...], change: Change, onset: str) -> Callable[[Told, Generator], Told]:
    def apply(told: Told, draw: Generator) -> Told:
        first = 0 if onset == ONSETS[0] else int(draw.uniform(0.02, 0.8) * len(told.rows))
        sound = replace(told, rows=told.rows[first:])
        found = told
        for name in names:
            found = found.changed(name, change(sound[name], sound, draw), slice(first, None))
        return found

    return apply


def _each(
    group: str,
    names: Mapping[str, tuple[str, ...]],
    changes: Mapping[str, Change],
    onsets: tuple[str, ...] = ONSETS,
) -> Iterator[Kind]:
    for who, signals in names.items():
        for what, change in changes.items():
            for onset in onsets:
                yield Kind(group, f"{who} {what} {onset}", _applied(signals, change, onset))


def _thermometers() -> Iterator[Kind]:
    lasting = {f"{by:+d} K": _shift(by) for by in (-20, -10, -5, -2, -1, 1, 2, 5, 10, 20)}
    lasting |= {"stuck": _stuck, "gone": _constant(np.nan)}
    yield from _each("thermometers", WHERE, lasting)
    later = {f"drifts {rate:+d} K/h": _ramp(rate) for rate in (-20, -5, -1, 1, 5, 20)}
    later |= {f"delayed {minutes} min": _delayed(60.0 * minutes) for minutes in (2, 10, 30, 60)}
    later |= {f"rise x {f:g}": _scale(f, 295.15) for f in (-1, 0.5, 1.5)}
    later |= {"in degC": _shift(-273.15), "in degF": lambda v, told, draw: 1.8 * (v - 273.15) + 32}
    later |= {"leaps 50 K once": _constant(345.0), "leaps each 30 s": _once(345.0, 30.0)}
    later |= {"missing now and then": _now_and_then(0.3, _constant(np.nan)), "noisy": _noise(1.0)}
    later |= {"rounded to 1 K": _quantised(1.0)}
    yield from _each("thermometers", WHERE, later, ONSETS[1:])
    places = {f"on {other.split('_')[0]}": _reads(other) for other in (SHAFT, WINDING, AMBIENT)}
    yield from _each("thermometers", WHERE, places, ONSETS)
    yield Kind("thermometers", "base and tip swapped", _swapped(BASE, TIP))


def _duty() -> Iterator[Kind]:
    torque = {f"x {f:g}": _scale(f) for f in (-1, 0, 0.5, 1.5, 2, 3, 10, 1000)}
    yield from _each("duty", {"torque": (TORQUE,)}, torque)
    speed = {f"x {f:g}": _scale(f) for f in (-1, 0, 0.5, 2, 3, 60 / (2 * np.pi), 180 / np.pi)}
    yield from _each("duty", {"speed": (SPEED,)}, speed)
    spikes = {f"one sample of {v:g}": _once(v) for v in (200, 1000, 1e6, np.nan)}
    spikes |= {f"{v:g} each 30 s": _once(v, 30.0) for v in (20, 1000, np.nan)}
    spikes |= {"stuck": _stuck, "delayed 10 min": _delayed(600), "missing": _constant(np.nan)}
    yield from _each("duty", {"torque": (TORQUE,), "speed": (SPEED,)}, spikes, ONSETS[1:])
    both = {"x 0": _scale(0), "x 2": _scale(2), "stuck": _stuck, "missing": _constant(np.nan)}
    both |= {"delayed 1 min": _delayed(60), "delayed 30 min": _delayed(1800), "10": _constant(10.0)}
    yield from _each("duty", {"torque and speed": (TORQUE, SPEED)}, both)
    yield Kind("duty", "torque and speed swapped", _swapped(TORQUE, SPEED))


def _ambient() -> Iterator[Kind]:
    name = {"ambient": (AMBIENT,)}
    lasting = {f"{by:+d} K": _shift(by) for by in (-40, -20, -10, -5, 5, 10, 20, 40)}
    yield from _each("ambient", name, {**lasting, "missing": _constant(np.nan), "in degC": _shift(-273.15)})
    later = {f"drifts {rate:+d} K/h": _ramp(rate) for rate in (-20, -5, -2, 2, 5, 20)}
    later |= {"stuck": _stuck, "noisy": _noise(2.0), "one sample of 500 K": _once(500.0)}
    later |= {"zero each 30 s": _once(0.0, 30.0), "in degF": lambda v, told, draw: 1.8 * (v - 273.15) + 32}
    later |= {"on the motor": _reads(SHAFT)}
    yield from _each("ambient", name, later, ONSETS[1:])


def _camera() -> Iterator[Kind]:
    scale, offset = {"camera": ("camera_scale",)}, {"camera": ("camera_offset",)}
    scales = {f"x {f:g}": _scale(f) for f in (-1, 0, 0.5, 2, 3, 1e6)}
    yield from _each("camera", scale, scales)
    drifts = {f"drifts {rate:+d} um/h": _ramp(1e-6 * rate) for rate in (-50, -10, 10, 50)}
    shifts = {f"{by:+d} um": _shift(1e-6 * by) for by in (-20, -5, 5, 20)}
    odd = {"outliers": _now_and_then(0.05, _noise(5e-5)), "gone": _constant(np.nan)}
    yield from _each("camera", offset, {**drifts, **shifts, **odd})
    frozen = {"frozen": _constant(0.0), "misses three in ten": _now_and_then(0.3, _constant(0.0))}
    yield from _each("camera", {"camera": ("picture",)}, frozen)
    yield from _each("camera", {"camera": ("drift_valid",)}, {"never valid": _constant(0.0)})


def _restarts() -> Iterator[Kind]:
    told: dict[str, bool | str] = {"what it retained": True, "nothing retained": False, "damage": "damaged"}
    for word, retained in told.items():
        kept = f"with {word}"
        for gone in (False, True):
            blind = ", thermometers gone" if gone else ""
            for off in (1.0, 60.0, 1200.0):
                for part in (0.05, 0.3, 0.7):
                    name = f"restart at {part:g} of the run after {off:g} s {kept}{blind}"
                    yield Kind("restarts", name, _restarted(part, off, retained, gone))
            for seconds in (5.0, 30.0):
                name = f"brown-outs each {seconds:g} s {kept}{blind}"
                yield Kind("restarts", name, _brown_outs(seconds, retained, gone))


def _restarted(
    part: float, off: float, retained: bool | str, gone: bool
) -> Callable[[Told, Generator], Told]:
    def apply(told: Told, draw: Generator) -> Told:
        first = round(part * len(told.rows)) + int(draw.integers(60))
        return _blinded(replace(told, restarts=(Restart(first * STEP, off, retained),)), first, gone)

    return apply


def _brown_outs(every: float, retained: bool | str, gone: bool) -> Callable[[Told, Generator], Told]:
    def apply(told: Told, draw: Generator) -> Told:
        first = int(draw.uniform(0.05, 0.7) * len(told.rows))
        times = [(first + k * every) * STEP for k in range(round(900 / every))]
        return _blinded(replace(told, restarts=[Restart(t, 1.0, retained) for t in times]), first, gone)

    return apply


def _blinded(told: Told, first: int, gone: bool) -> Told:
    for name in (BASE, TIP) if gone else ():
        told = told.changed(name, np.nan, slice(first, None))
    return told


def _swapped(one: str, other: str) -> Callable[[Told, Generator], Told]:
    return lambda told, draw: told.changed(one, told[other]).changed(other, told[one])
