"""The effects that a run may hide: the change that each makes to the cell or to its recorded readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.practice.hidden import COLD, Truth

CHANNELS = (
    "shaft_temperature",
    "winding_temperature",
    "base_temperature",
    "middle_temperature",
    "tip_temperature",
)
"""Temperature columns of a made-up run, as the fields of `Course` in order; the elongation follows."""

Readings = dict[str, Array]


@dataclass(frozen=True)
class Effect:
    """An effect that a run may hide.

    Attributes
    ----------
    size : an ordinary strength, in SI; 1 stands for nothing where `neutral` is 1
    both_signs : whether it may act either way
    on_truth : changes the cell, given the strength and the duration of the run in s
    on_readings : changes what was recorded, given time, readings, strength and channel
    about : what it is, where no cause of the catalogue explains it
    """

    size: float
    on_truth: Callable[[Truth, float, float], Truth] | None = None
    on_readings: Callable[[Array, Readings, float, str], None] | None = None
    both_signs: bool = False
    neutral: float = 0.0
    per_channel: bool = False
    about: str = ""


def _field(name: str, factor: bool = False) -> Callable[[Truth, float, float], Truth]:
    nominal: Any = {f.name: f.default for f in fields(Truth)}[name]

    def apply(truth: Truth, size: float, duration: float) -> Truth:
        changed: dict[str, Any] = {name: nominal * size if factor else size}
        return replace(truth, **changed)

    return apply


def _window(name: str, begin: float, end: float) -> Callable[[Truth, float, float], Truth]:
    def apply(truth: Truth, size: float, duration: float) -> Truth:
        def course(time: float) -> float:
            return size if begin * duration <= time < end * duration else 0.0

        changed: dict[str, Any] = {name: course}
        return replace(truth, **changed)

    return apply


def _waves(truth: Truth, size: float, duration: float) -> Truth:
    return replace(truth, room=lambda time: size * np.sin(2 * np.pi * time / 1500.0))


def _offset(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] + (size * 1e-5 if channel == "elongation" else size)


def _scale(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings["elongation"] = size * readings["elongation"]


def _camera_drift(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings["elongation"] = readings["elongation"] + size * time


def _lag(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = _followed(time, readings[channel], size)


def _stem(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] - size * (readings[channel] - readings["ambient"])


def _creep(time: Array, readings: Readings, size: float, channel: str) -> None:
    late = _followed(time, readings["elongation"], 1500.0)
    readings["elongation"] = readings["elongation"] + size * (late - readings["elongation"])


def _bending(time: Array, readings: Readings, size: float, channel: str) -> None:
    gradient = readings["base_temperature"] - readings["tip_temperature"]
    readings["elongation"] = readings["elongation"] + size * gradient * np.abs(gradient)


def _jump(time: Array, readings: Readings, size: float, channel: str) -> None:
    readings[channel] = readings[channel] + size * (time > 0.4 * time[-1])


def _stick(time: Array, readings: Readings, size: float, channel: str) -> None:
    values = readings[channel].copy()
    held = (time > 0.25 * time[-1]) & (time < (0.25 + size) * time[-1])
    values[held] = values[held][0]
    readings[channel] = values


def _curved(time: Array, readings: Readings, size: float, channel: str) -> None:
    rise = readings[channel] - COLD
    readings[channel] = readings[channel] + size * rise * (15.0 - rise)


EFFECTS: Mapping[str, Effect] = {
    "radiation": Effect(0.6, _field("emissivity")),
    "still_air_convection": Effect(1.5, _field("still", True), neutral=1, both_signs=True),
    "forced_convection": Effect(1.5, _field("per_speed", True), neutral=1, both_signs=True),
    "mixed_convection": Effect(1.0, _field("mixing")),
    "conductivity": Effect(0.8, _field("conductivity", True), neutral=1, both_signs=True),
    "conductivity_temperature_dependence": Effect(0.003, _field("conductivity_slope"), both_signs=True),
    "heat_capacity": Effect(1.12, _field("capacity", True), neutral=1, both_signs=True),
    "hub_heat_capacity": Effect(60.0, _field("hub_capacity")),
    "tip_heat_capacity": Effect(60.0, _field("tip_capacity")),
    "tip_heat_loss": Effect(0.05, _field("tip_loss")),
    "expansion_coefficient": Effect(1.05, _field("expansion", True), neutral=1, both_signs=True),
    "elongation_scale": Effect(1.05, on_readings=_scale, neutral=1, both_signs=True),
    "joint_resistance": Effect(0.3, _field("joint")),
    "joint_conductance": Effect(
        1.3, lambda truth, size, duration: replace(truth, joint=1 / size - 1), neutral=1
    ),
    "hub_heat_loss": Effect(0.15, _field("hub_loss")),
    "copper_loss": Effect(1.15, _field("resistance", True), neutral=1, both_signs=True),
    "iron_loss": Effect(1.5, _field("iron", True), neutral=1, both_signs=True),
    "housing_heat_loss": Effect(1.15, _field("housing", True), neutral=1, both_signs=True),
    "winding_heat_path": Effect(1.15, _field("winding_path", True), neutral=1, both_signs=True),
    "winding_heat_capacity": Effect(1.3, _field("winding_capacity", True), neutral=1, both_signs=True),
    "shaft_heat_capacity": Effect(1.15, _field("shaft_capacity", True), neutral=1, both_signs=True),
    "start_temperature": Effect(
        3.0, lambda truth, size, duration: replace(truth, start=COLD + size), both_signs=True
    ),
    "friction_level": Effect(1.15, _field("friction"), neutral=1, both_signs=True),
    "free_convection": Effect(0.25, _field("free_exponent")),
    "coulomb_friction": Effect(1.3, _field("coulomb", True), neutral=1, both_signs=True),
    "viscous_friction": Effect(1.3, _field("viscous", True), neutral=1, both_signs=True),
    "friction_temperature_dependence": Effect(0.01, _field("friction_slope"), both_signs=True),
    "lubricant_thinning": Effect(0.02, _field("thinning")),
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
    "draught": Effect(2.0, _window("draught", 0.28, 0.5), about="A draught cools the link for a while."),
    "open_door": Effect(
        -4.0, _window("room", 0.2, 0.33), about="The room is colder for a while than its thermometer says."
    ),
    "air_conditioning": Effect(
        2.0, _waves, about="The room's temperature goes up and down every 25 minutes beside its thermometer."
    ),
    "loosening_joint": Effect(
        0.5, _window("loosening", 0.35, 2.0), about="The joint conducts less from some moment on."
    ),
    "brake_heat": Effect(
        12.0, _window("shaft_heat", 0.3, 0.42), about="A brake warms the shaft for a while."
    ),
    "bracket": Effect(
        1.5,
        _window("bracket", 0.25, 0.55),
        about="Something clamped to the link takes heat from its middle for a while.",
    ),
    "churning": Effect(0.25, _field("drag"), about="Grease heats the shaft with the cube of the speed."),
    "creep": Effect(0.12, on_readings=_creep, about="The elongation follows its cause late."),
    "bending": Effect(
        0.08e-6, on_readings=_bending, about="The link bends, and the camera sees it as elongation."
    ),
    "slipped_sensor": Effect(
        -1.0,
        on_readings=_jump,
        per_channel=True,
        about="A thermometer slips and reads otherwise from some moment on.",
    ),
    "stuck_sensor": Effect(
        0.15, on_readings=_stick, per_channel=True, about="A thermometer stands still for a while."
    ),
    "curved_sensor": Effect(
        0.008,
        on_readings=_curved,
        per_channel=True,
        about="A thermometer's error grows and falls with the temperature.",
    ),
}


def _followed(times: Array, signal: Array, lag: float) -> Array:
    """First-order lag by small exact steps over a dense signal."""
    result = np.empty_like(signal)
    result[0] = state = signal[0]
    for i in range(1, times.size):
        decay = np.exp(-(times[i] - times[i - 1]) / lag)
        state = decay * state + (1 - decay) * (signal[i] + signal[i - 1]) / 2
        result[i] = state
    return result


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
    if channel and not EFFECTS[stem].per_channel:
        raise InputError(f"effect: {name!r} is no single thermometer's; write {stem}")
    if EFFECTS[stem].per_channel and channel not in (*CHANNELS, "elongation"):
        raise InputError(
            f"effect: {name!r} needs a channel, as {stem}:tip_temperature; "
            f"{instead(channel, (*CHANNELS, 'elongation'))}"
        )
    return EFFECTS[stem]


def about_effects() -> dict[str, str]:
    """What each effect is, by its name as `hide` takes it, with its ordinary strength in SI."""
    sentences = {cause.name: cause.sentence for cause in catalogue()}
    return {
        f"{name}:CHANNEL" if effect.per_channel else name: f"{sentences.get(name, effect.about)} "
        f"Ordinarily {effect.size:g}."
        for name, effect in EFFECTS.items()
    }
