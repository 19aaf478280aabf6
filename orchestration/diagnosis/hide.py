"""Runs with a hidden effect, for teaching and for tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.hidden import COLD, Course, Segment, Truth, simulate

Vector = NDArray[np.float64]

KELVIN_ZERO = 273.15
CHANNELS = (
    "shaft_temperature",
    "winding_temperature",
    "base_temperature",
    "middle_temperature",
    "tip_temperature",
)
"""Temperature columns of a made-up run, as the fields of `Course` in order; the elongation follows."""

Readings = dict[str, Vector]


@dataclass(frozen=True)
class Effect:
    """An effect that a run may hide.

    Attributes
    ----------
    size : an ordinary strength, in SI; 1 stands for nothing where `neutral` is 1
    both_signs : whether it may act either way
    on_truth : changes the cell, given the strength and the duration of the run in s
    on_readings : changes what was recorded, given time, readings, strength and channel
    known : whether the catalogue has a cause for it
    """

    size: float
    on_truth: Callable[[Truth, float, float], Truth] | None = None
    on_readings: Callable[[Vector, Readings, float, str], None] | None = None
    both_signs: bool = False
    neutral: float = 0.0
    known: bool = True
    per_channel: bool = False


def _field(name: str, factor: bool = False) -> Callable[[Truth, float, float], Truth]:
    nominal = {f.name: f.default for f in fields(Truth)}[name]

    def apply(truth: Truth, size: float, duration: float) -> Truth:
        # The fields are all numbers here; mypy cannot tell which name it is.
        value = float(nominal) * size if factor else size  # type: ignore[arg-type]
        return replace(truth, **{name: value})  # type: ignore[arg-type]

    return apply


def _window(name: str, begin: float, end: float) -> Callable[[Truth, float, float], Truth]:
    def apply(truth: Truth, size: float, duration: float) -> Truth:
        def course(time: float) -> float:
            return size if begin * duration <= time < end * duration else 0.0

        return replace(truth, **{name: course})  # type: ignore[arg-type]

    return apply


def _waves(truth: Truth, size: float, duration: float) -> Truth:
    return replace(truth, room=lambda time: size * np.sin(2 * np.pi * time / 1500.0))


def _offset(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] + (size * 1e-5 if channel == "elongation" else size)


def _scale(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings["elongation"] = size * readings["elongation"]


def _camera_drift(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings["elongation"] = readings["elongation"] + size * time


def _lag(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = _followed(time, readings[channel], size)


def _stem(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] - size * (readings[channel] - readings["ambient"])


def _creep(time: Vector, readings: Readings, size: float, channel: str) -> None:
    late = _followed(time, readings["elongation"], 1500.0)
    readings["elongation"] = readings["elongation"] + size * (late - readings["elongation"])


def _bending(time: Vector, readings: Readings, size: float, channel: str) -> None:
    gradient = readings["base_temperature"] - readings["tip_temperature"]
    readings["elongation"] = readings["elongation"] + size * gradient * np.abs(gradient)


def _jump(time: Vector, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] + size * (time > 0.4 * time[-1])


def _stick(time: Vector, readings: Readings, size: float, channel: str) -> None:
    values = readings[channel].copy()
    held = (time > 0.25 * time[-1]) & (time < (0.25 + size) * time[-1])
    values[held] = values[held][0]
    readings[channel] = values


def _curved(time: Vector, readings: Readings, size: float, channel: str) -> None:
    rise = readings[channel] - COLD
    readings[channel] = readings[channel] + size * rise * (15.0 - rise)


EFFECTS: Mapping[str, Effect] = {
    "radiation": Effect(0.6, _field("emissivity")),
    "still_air_convection": Effect(1.5, _field("still", True), neutral=1, both_signs=True),
    "forced_convection": Effect(1.5, _field("per_speed", True), neutral=1, both_signs=True),
    "conductivity": Effect(0.8, _field("conductivity", True), neutral=1, both_signs=True),
    "conductivity_temperature_dependence": Effect(0.003, _field("conductivity_slope"), both_signs=True),
    "heat_capacity": Effect(1.12, _field("capacity", True), neutral=1, both_signs=True),
    "tip_heat_capacity": Effect(60.0, _field("tip_capacity")),
    "tip_heat_loss": Effect(0.05, _field("tip_loss")),
    "expansion_coefficient": Effect(1.05, _field("expansion", True), neutral=1, both_signs=True),
    "elongation_scale": Effect(1.05, on_readings=_scale, neutral=1, both_signs=True),
    "joint_resistance": Effect(0.3, _field("joint")),
    "hub_heat_loss": Effect(0.15, _field("hub_loss")),
    "copper_loss": Effect(1.15, _field("resistance", True), neutral=1, both_signs=True),
    "friction_level": Effect(1.15, _field("friction"), neutral=1, both_signs=True),
    "friction_temperature_dependence": Effect(0.01, _field("friction_slope"), both_signs=True),
    "standby_heat": Effect(3.0, _field("standby")),
    "ambient_offset": Effect(1.5, _field("ambient_offset"), both_signs=True),
    "ambient_drift": Effect(1.5 / 3600, _field("ambient_drift"), both_signs=True),
    "radiant_heating": Effect(30.0, _field("flux")),
    "sensor_lag": Effect(60.0, on_readings=_lag, per_channel=True),
    "sensor_offset": Effect(0.5, on_readings=_offset, per_channel=True, both_signs=True),
    "sensor_stem_conduction": Effect(0.05, on_readings=_stem, per_channel=True),
    "camera_drift": Effect(2e-6 / 3600, on_readings=_camera_drift, both_signs=True),
    "clock_offset": Effect(30.0, both_signs=True),
    # From here on what no cause of the catalogue can explain.
    "draught": Effect(2.0, _window("draught", 0.28, 0.5), known=False),
    "open_door": Effect(-4.0, _window("room", 0.2, 0.33), known=False),
    "air_conditioning": Effect(2.0, _waves, known=False),
    "loosening_joint": Effect(0.5, _window("loosening", 0.35, 2.0), known=False),
    "brake_heat": Effect(12.0, _window("shaft_heat", 0.3, 0.42), known=False),
    "bracket": Effect(1.5, _window("bracket", 0.25, 0.55), known=False),
    "churning": Effect(0.25, _field("drag"), known=False),
    "creep": Effect(0.12, on_readings=_creep, known=False),
    "bending": Effect(0.08e-6, on_readings=_bending, known=False),
    "slipped_sensor": Effect(-1.0, on_readings=_jump, known=False, per_channel=True),
    "stuck_sensor": Effect(0.15, on_readings=_stick, known=False, per_channel=True),
    "curved_sensor": Effect(0.008, on_readings=_curved, known=False, per_channel=True),
}


@dataclass(frozen=True)
class Noise:
    """What the instruments add.

    Attributes
    ----------
    temperature, elongation : 1 sigma in K and m
    correlated : share of the variance that is correlated over `minute` s
    quantum : step to which temperatures are rounded, in K, and the elongation in um; 0: none
    spikes : share of readings that are spikes of 10 to 30 sigma
    """

    temperature: float = 0.08
    elongation: float = 0.4e-6
    correlated: float = 0.0
    minute: float = 60.0
    quantum: float = 0.0
    spikes: float = 0.0


WHITE = Noise()
REAL = Noise(correlated=0.3, quantum=0.1, spikes=0.002)

INFORMATIVE: tuple[Segment, ...] = (
    Segment(300, 0.0, 0.0),
    Segment(1200, 3.43, 2.5),
    Segment(480, 0.0, 0.0, ambient=COLD + 2),
    Segment(720, 0.0, 0.0, pad=COLD + 25, ambient=COLD + 2),
    Segment(480, 1.2, 5.0, ambient=COLD + 1),
    Segment(600, 0.0, 0.0, ambient=COLD + 1),
    Segment(720, 4.5, 0.5, ambient=COLD - 1),
    Segment(600, 0.0, 4.0, ambient=COLD - 1),
    Segment(900, 2.2, 3.2),
    Segment(600, 0.0, 0.0),
    Segment(600, 3.43, 2.5, ambient=COLD + 1),
)
"""Two hours in which every cause shows: rest, pad, torque without speed, speed without torque."""

STILL: tuple[Segment, ...] = (Segment(3600, 0.0, 0.0, pad=36 + KELVIN_ZERO),)
MOVING: tuple[Segment, ...] = (Segment(3600, 3.43, 2.5, pad=42 + KELVIN_ZERO),)
"""The paper's hours, which show little apart."""


def hide(
    effects: Mapping[str, float],
    duty: Sequence[Segment] = INFORMATIVE,
    noise: Noise = WHITE,
    interval: float = 10.0,
    seed: int = 0,
    solver: Callable[[Truth, list[Segment], Vector], Course] = simulate,
) -> dict[str, Vector]:
    """Make a run that hides effects.

    Parameters
    ----------
    effects : strength in SI by effect; an instrument's effect bears its channel, as
        `sensor_lag:tip_temperature`
    duty : the duty cycle
    noise : what the instruments add
    interval : s between rows
    seed : of the noise
    solver : gives the true course of a cell over a duty cycle at times in s

    Returns
    -------
    dict
        Columns by header as in a CSV file; NaN where a cell is empty.

    Raises
    ------
    InputError
        An effect is not known.
    """
    duration = sum(segment.duration for segment in duty)
    truth, late = Truth(), 0.0
    for name, size in effects.items():
        effect = effect_of(name)
        if effect.on_truth is not None:
            truth = effect.on_truth(truth, size, duration)
        late += size if name == "clock_offset" else 0.0
    rows = np.arange(0.0, duration + interval / 2, interval)
    lagging = any(name.split(":")[0] in ("sensor_lag", "creep") for name in effects)
    seen = np.clip(rows - late, 0.0, duration)
    dense = np.union1d(np.arange(0.0, duration, 2.0), seen) if lagging else np.unique(seen)
    course = solver(truth, list(duty), dense)
    readings = _true_readings(course, duty)
    for name, size in effects.items():
        effect, channel = effect_of(name), name.partition(":")[2]
        if effect.on_readings is not None:
            effect.on_readings(dense, readings, size, channel)
    picked = {channel: values[np.searchsorted(dense, seen)] for channel, values in readings.items()}
    return _columns(rows, duty, noisy(rows, picked, noise, np.random.default_rng(seed)))


def effect_of(name: str) -> Effect:
    """Look an effect up by name, with or without a channel.

    Raises
    ------
    InputError
        There is none, its channel is missing or not known.
    """
    stem, _, channel = name.partition(":")
    if stem not in EFFECTS:
        raise InputError(f"effect: {stem!r} is not known; {instead(stem, EFFECTS)}")
    if EFFECTS[stem].per_channel and channel not in (*CHANNELS, "elongation"):
        raise InputError(
            f"effect: {name!r} needs a channel, as {stem}:tip_temperature; "
            f"{instead(channel, (*CHANNELS, 'elongation'))}"
        )
    return EFFECTS[stem]


def ordinary(names: Sequence[str]) -> dict[str, float]:
    """Ordinary strengths in SI of effects by name.

    Raises
    ------
    InputError
        An effect is not known.
    """
    return {name: effect_of(name).size for name in names}


def write_csv(columns: Mapping[str, Vector], path: Path) -> None:
    """Write a run, whole or not at all."""
    import pandas as pd

    scratch = path.with_name(path.name + ".part")
    pd.DataFrame(dict(columns)).to_csv(scratch, index=False, float_format="%.6g")
    scratch.replace(path)


def _true_readings(course: Course, duty: Sequence[Segment]) -> Readings:
    true = (course.shaft, course.winding, course.base, course.middle, course.tip)
    _, ambient = _held(course.time, duty, lambda s: s.ambient)
    return {**dict(zip(CHANNELS, true, strict=True)), "elongation": course.elongation, "ambient": ambient}


def _held(times: Vector, duty: Sequence[Segment], value: Callable[[Segment], float]) -> tuple[Vector, Vector]:
    starts = np.concatenate([[0.0], np.cumsum([s.duration for s in duty])[:-1]])
    which = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(duty) - 1)
    return starts, np.array([value(s) for s in duty])[which]


def noisy(rows: Vector, readings: Readings, noise: Noise, random: np.random.Generator) -> Readings:
    """Readings at rows in s, in SI, with what the instruments add; shape (rows,) each."""
    result = {}
    step = float(rows[1] - rows[0])
    for channel, values in readings.items():
        if channel == "ambient":
            continue
        length = channel == "elongation"
        sigma = noise.elongation if length else noise.temperature
        added = np.sqrt(1 - noise.correlated) * random.standard_normal(rows.size)
        added += np.sqrt(noise.correlated) * _correlated(rows.size, np.exp(-step / noise.minute), random)
        spiky = random.random(rows.size) < noise.spikes
        added += spiky * random.uniform(10, 30, rows.size) * random.choice([-1, 1], rows.size)
        noisy = values + sigma * added
        if noise.quantum:
            quantum = noise.quantum * (1e-6 if length else 1.0)
            zero = 0.0 if length else KELVIN_ZERO
            noisy = np.round((noisy - zero) / quantum) * quantum + zero
        result[channel] = noisy
    return result


def _correlated(count: int, decay: float, random: np.random.Generator) -> Vector:
    from scipy.signal import lfilter

    start = random.standard_normal()
    drive = np.sqrt(1 - decay**2) * random.standard_normal(count)
    drive[0] = start
    return np.asarray(lfilter([1.0], [1.0, -decay], drive))


def _columns(rows: Vector, duty: Sequence[Segment], readings: Readings) -> dict[str, Vector]:
    def of(value: Callable[[Segment], float]) -> Vector:
        return _held(rows, duty, value)[1]

    columns = {
        "time [s]": rows,
        "speed [rad/s]": of(lambda s: s.speed),
        "torque [N.m]": of(lambda s: s.torque),
        "pad_temperature [degC]": of(lambda s: np.nan if s.pad is None else s.pad - KELVIN_ZERO),
        "ambient_temperature [degC]": of(lambda s: s.ambient - KELVIN_ZERO),
    }
    columns |= {f"{channel} [degC]": readings[channel] - KELVIN_ZERO for channel in CHANNELS}
    return columns | {"elongation [um]": readings["elongation"] * 1e6}


def _followed(times: Vector, signal: Vector, lag: float) -> Vector:
    """First-order lag by small exact steps over a dense signal."""
    result = np.empty_like(signal)
    result[0] = state = signal[0]
    for i in range(1, times.size):
        decay = np.exp(-(times[i] - times[i - 1]) / lag)
        state = decay * state + (1 - decay) * (signal[i] + signal[i - 1]) / 2
        result[i] = state
    return result
