"""The effects that a run may hide: the change that each makes to the cell or to its recorded readings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.practice.hidden import COLD, Truth

TEMPERATURES = ("shaft", "winding", "base", "middle", "tip")
CHANNELS = tuple(f"{name}_temperature" for name in TEMPERATURES)
"""Temperature columns of a made-up run, of the fields of `Course`; the elongation follows."""

Readings = dict[str, Array]
OnTruth = Callable[[Truth, float, float], Truth]
OnReadings = Callable[[Array, Readings, float, str], Array]


@dataclass(frozen=True)
class Effect:
    """An effect that a run may hide, of an ordinary size in SI; 1 stands for nothing where `neutral` is 1.

    `on_truth` gives the changed cell, of the cell, the strength and the duration of the run in s;
    `on_readings` what a channel records, of time, readings, strength and channel: that of one thermometer
    or the camera where it acts per channel, else the elongation. `about` is what it is, where no cause of
    the catalogue explains it.
    """

    size: float
    on_truth: OnTruth | None = None
    on_readings: OnReadings | None = None
    both_signs: bool = False
    neutral: float = 0.0
    per_channel: bool = False
    about: str = ""


def _with(truth: Truth, name: str, value: Any) -> Truth:
    return replace(truth, **{name: value})


def _set(name: str, size: float, both_signs: bool = False, about: str = "") -> Effect:
    """The strength is the value of a field of the cell."""
    return Effect(size, lambda truth, size, _: _with(truth, name, size), both_signs=both_signs, about=about)


def _times(name: str, size: float) -> Effect:
    """The strength is a factor on the nominal value of a field of the cell."""
    nominal: Any = getattr(Truth(), name)
    return Effect(size, lambda truth, size, _: _with(truth, name, size * nominal), both_signs=True, neutral=1)


def _beside(truth: Truth, name: str, course: Callable[[float], float]) -> Truth:
    """The cell with a function of time added to that of a field."""
    before: Callable[[float], float] = getattr(truth, name)
    return _with(truth, name, lambda time: before(time) + course(time))


def _while(name: str, begin: float, end: float, size: float, about: str) -> Effect:
    """The strength is the value of a field that is a function of time, for a part of the run."""

    def change(truth: Truth, size: float, duration: float) -> Truth:
        return _beside(truth, name, lambda time: size if begin * duration <= time < end * duration else 0.0)

    return Effect(size, change, about=about)


def _of_thermometer(size: float, change: OnReadings, about: str = "", both_signs: bool = False) -> Effect:
    return Effect(size, None, change, both_signs, per_channel=True, about=about)


def _bent(time: Array, readings: Readings, size: float, channel: str) -> Array:
    gradient = readings["base_temperature"] - readings["tip_temperature"]
    return readings[channel] + size * gradient * np.abs(gradient)


def _stuck(time: Array, readings: Readings, size: float, channel: str) -> Array:
    values = readings[channel].copy()
    held = (time > 0.25 * time[-1]) & (time < (0.25 + size) * time[-1])
    if not held.any():
        raise InputError(
            f"effect: stuck_sensor={size:g}: no reading falls into so small a share of the run; give 0.15"
        )
    values[held] = values[held][0]
    return values


def _followed(times: Array, signal: Array, lag: float) -> Array:
    """First-order lag by small exact steps over a dense signal."""
    result = np.empty_like(signal)
    result[0] = state = signal[0]
    for i in range(1, times.size):
        decay = np.exp(-(times[i] - times[i - 1]) / lag)
        state = decay * state + (1 - decay) * (signal[i] + signal[i - 1]) / 2
        result[i] = state
    return result


EFFECTS: Mapping[str, Effect] = {
    "radiation": _set("emissivity", 0.6),
    "still_air_convection": _times("still", 1.5),
    "forced_convection": _times("per_speed", 1.5),
    "mixed_convection": _set("mixing", 1.0),
    "conductivity": _times("conductivity", 0.8),
    "conductivity_temperature_dependence": _set("conductivity_slope", 0.003, both_signs=True),
    "heat_capacity": _times("capacity", 1.12),
    "hub_heat_capacity": _set("hub_capacity", 60.0),
    "tip_heat_capacity": _set("tip_capacity", 60.0),
    "tip_heat_loss": _set("tip_loss", 0.05),
    "expansion_coefficient": _times("expansion", 1.05),
    "elongation_scale": Effect(1.05, None, lambda _, seen, size, at: size * seen[at], True, neutral=1),
    "joint_resistance": Effect(0.3, lambda truth, size, _: replace(truth, joint=truth.joint + size)),
    "joint_conductance": Effect(
        1.3, lambda truth, size, _: replace(truth, joint=truth.joint + 1 / size - 1), neutral=1
    ),
    "hub_heat_loss": _set("hub_loss", 0.15),
    "copper_loss": _times("resistance", 1.15),
    "iron_loss": _times("iron", 1.5),
    "housing_heat_loss": _times("housing", 1.15),
    "winding_heat_path": _times("winding_path", 1.15),
    "winding_heat_capacity": _times("winding_capacity", 1.3),
    "shaft_heat_capacity": _times("shaft_capacity", 1.15),
    "start_temperature": Effect(
        3.0, lambda truth, size, _: replace(truth, start=COLD + size), both_signs=True
    ),
    "friction_level": _times("friction", 1.15),
    "free_convection": _set("free_exponent", 0.25),
    "coulomb_friction": _times("coulomb", 1.3),
    "viscous_friction": _times("viscous", 1.3),
    "friction_temperature_dependence": _set("friction_slope", 0.01, both_signs=True),
    "lubricant_thinning": _set("thinning", 0.02),
    "standby_heat": _set("standby", 3.0),
    "ambient_offset": _set("ambient_offset", 1.5, both_signs=True),
    "ambient_drift": _set("ambient_drift", 1.5 / 3600, both_signs=True),
    "radiant_heating": _set("flux", 30.0),
    "sensor_lag": _of_thermometer(60.0, lambda time, seen, size, at: _followed(time, seen[at], size)),
    "sensor_offset": _of_thermometer(
        0.5,
        lambda _, seen, size, at: seen[at] + (size * 1e-5 if at == "elongation" else size),
        both_signs=True,
    ),
    "sensor_stem_conduction": _of_thermometer(
        0.05, lambda _, seen, size, at: seen[at] - size * (seen[at] - seen["ambient"])
    ),
    "camera_drift": Effect(2e-6 / 3600, None, lambda time, seen, size, at: seen[at] + size * time, True),
    "clock_offset": Effect(30.0, both_signs=True),
    # From here on what no cause of the catalogue can explain.
    "draught": _while("draught", 0.28, 0.5, 2.0, "A draught cools the link for a while."),
    "open_door": _while("room", 0.2, 0.33, -4.0, "The room is colder for a while than its thermometer says."),
    "air_conditioning": Effect(
        2.0,
        lambda truth, size, _: _beside(truth, "room", lambda time: size * np.sin(2 * np.pi * time / 1500.0)),
        about="The room's temperature goes up and down every 25 minutes beside its thermometer.",
    ),
    "loosening_joint": _while("loosening", 0.35, 2.0, 0.5, "The joint conducts less from some moment on."),
    "brake_heat": _while("shaft_heat", 0.3, 0.42, 12.0, "A brake warms the shaft for a while."),
    "bracket": _while(
        "bracket", 0.25, 0.55, 1.5, "Something clamped to the link takes heat from its middle for a while."
    ),
    "churning": _set("drag", 0.25, about="Grease heats the shaft with the cube of the speed."),
    "creep": Effect(
        0.12,
        None,
        lambda time, seen, size, at: seen[at] + size * (_followed(time, seen[at], 1500.0) - seen[at]),
        about="The elongation follows its cause late.",
    ),
    "bending": Effect(0.08e-6, None, _bent, about="The link bends, and the camera sees it as elongation."),
    "slipped_sensor": _of_thermometer(
        -1.0,
        lambda time, seen, size, at: seen[at] + size * (time > 0.4 * time[-1]),
        "A thermometer slips and reads otherwise from some moment on.",
    ),
    "stuck_sensor": _of_thermometer(0.15, _stuck, "A thermometer stands still for a while."),
    "curved_sensor": _of_thermometer(
        0.008,
        lambda _, seen, size, at: seen[at] + size * (seen[at] - COLD) * (15.0 - (seen[at] - COLD)),
        "A thermometer's error grows and falls with the temperature.",
    ),
}


def with_changes(time: Array, true: Readings, changes: Iterable[tuple[OnReadings, float, str]]) -> Readings:
    """Readings after changes to channels, each with its strength, one after the other.

    What a change takes from other channels is the truth, whatever their instruments say.
    """
    found = dict(true)
    for change, size, channel in changes:
        found[channel] = change(time, {**true, channel: found[channel]}, size, channel)
    return found


def effect_of(name: str) -> Effect:
    """Effect by its name; raises InputError where it, or the channel that it needs, is not known."""
    stem, _, channel = name.partition(":")
    effect, channels = EFFECTS.get(stem), (*CHANNELS, "elongation")
    if effect is None:
        raise InputError(f"effect: {stem!r} is not known; {instead(stem, EFFECTS)}")
    if channel and not effect.per_channel:
        raise InputError(f"effect: {name!r} is no single thermometer's; write {stem}")
    if effect.per_channel and channel not in channels:
        known = f"as {stem}:tip_temperature; {instead(channel, channels)}"
        raise InputError(f"effect: {name!r} needs a channel, {known}")
    return effect


def about_effects() -> dict[str, str]:
    """What each effect is, by its name as `hide` takes it, with its ordinary strength in SI."""
    sentences = {cause.name: cause.sentence for cause in catalogue()}
    return {
        f"{name}:CHANNEL" if effect.per_channel else name: f"{sentences.get(name, effect.about)} "
        f"Ordinarily {effect.size:g} {'times the nominal' if effect.neutral else 'in SI units'}."
        for name, effect in EFFECTS.items()
    }
