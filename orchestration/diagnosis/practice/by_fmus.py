"""Runs of any machine with a hidden effect, from its FMUs, to practise diagnosing on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.causes.catalogue import Cause, catalogue
from warmlink.orchestration.diagnosis.causes.parts import freed_in_parts
from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, OnReadings, with_changes
from warmlink.orchestration.diagnosis.practice.hide import WHITE, Noise, noisy, refuse_too_few
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import value_of, with_values
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.duties.duty import PAD_POWER, PAD_TEMPERATURE
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.assemble import owner_of
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.units import ZERO_CELSIUS

INTERVAL = 10.0
"""s between rows."""

STEP = 0.25
"""s, longest communication step: what exchanging values at its ends only does stays below the noise."""

CLOCK, AMBIENT, PAD = "clock_offset", "ambient_temperature", "pad_temperature"

Hidden = Callable[[System], Mapping[str, float]]
"""Function that returns the values, in SI units by full name, that differ in a system."""


@dataclass(frozen=True)
class HiddenEffect:
    """What hides under a name in a machine: another value of `variables`, or a `change` of what is read.

    `size` is the usual strength in SI units, None for a variable, which has none. The value of a variable is
    the strength itself, `relative` to the value that it has, or `added` to it. `change` acts on `channel`.
    """

    size: float | None
    variables: tuple[str, ...] = ()
    relative: bool = False
    added: bool = False
    change: OnReadings | None = None
    channel: str = ""

    def values(
        self, system: System, size: float, before: Mapping[str, float] = MappingProxyType({})
    ) -> dict[str, float]:
        """Values of the variables in SI units, for a strength; some have others `before` it."""
        if not self.relative and not self.added:
            return dict.fromkeys(self.variables, size)
        own = {name: before[name] if name in before else value_of(system, name) for name in self.variables}
        return {name: size * v if self.relative else size + v for name, v in own.items()}


def values_together(
    system: System, hidden: Mapping[str, HiddenEffect], sizes: Mapping[str, float]
) -> dict[str, float]:
    """Values of variables in SI units for several effects by name, with their strengths.

    What is added to one variable adds up, and factors multiply; InputError where two set it otherwise.
    """
    found: dict[str, float] = {}
    first: dict[str, str] = {}
    for name, effect in hidden.items():
        for variable in effect.variables:
            one = hidden[first.setdefault(variable, name)]
            alike = (one.added and effect.added) or (one.relative and effect.relative)
            if one is not effect and not alike:
                told = f"{first[variable]!r} and {name!r} both set {variable}"
                raise InputError(f"effect: {told}; give one of them")
        found |= effect.values(system, sizes[name], found)
    return found


def of_cause(cause: Cause, variables: Sequence[str]) -> HiddenEffect:
    """A cause of the catalogue, hidden in these variables, with its usual strength if there is one."""
    usual = EFFECTS.get(cause.name)
    size = None if usual is None else usual.size
    return HiddenEffect(size, tuple(variables), cause.relative, cause.added)


def effects_in(rig: Rig) -> dict[str, HiddenEffect]:
    """What can hide in a machine, by name: causes of its parts, and faults of its clock and instruments."""
    found = {
        name: of_cause(cause, variables)
        for cause in catalogue()
        if cause.kind == "plant"
        for name, variables in freed_in_parts(cause, rig).items()
    }
    read = {rig.column_of(name): rig.unit(name) for name in measured_in(rig)}
    lengths = [column for column, unit in read.items() if unit == "m"]
    room = AMBIENT in rig.demanded
    for name, effect in EFFECTS.items():
        if effect.on_readings is None or name == "bending" or (name == "sensor_stem_conduction" and not room):
            continue  # what bends is a link between two thermometers that have these names
        channels = lengths if not effect.per_channel else [c for c in read if c not in lengths]
        for channel in channels:
            alone = not effect.per_channel and len(lengths) == 1
            called = name if alone else f"{name}:{channel}"
            found[called] = HiddenEffect(effect.size, change=effect.on_readings, channel=channel)
    return found | {CLOCK: HiddenEffect(EFFECTS[CLOCK].size)}


def effect_in(rig: Rig, name: str) -> HiddenEffect:
    """What a name hides in a machine, which may be a parameter's; InputError if nothing has that name."""
    possible = effects_in(rig)
    if name in possible:
        return possible[name]
    if name in rig.parameters:
        return HiddenEffect(None, (name,))
    several = [each for each in possible if each.partition(":")[0] == name]
    known = instead(name, several or possible, "or the full name of a parameter, with its value in SI units")
    raise InputError(f"effect: {name!r} cannot be hidden in {rig.name}; {known}")


def measured_in(rig: Rig) -> list[str]:
    """Outputs of a machine that a made-up run reads, temperatures and lengths."""
    outputs = [name for name in rig.columns.values() if name not in rig.externals]
    return [name for name in dict.fromkeys(outputs) if rig.unit(name) in ("K", "m")]


def hide_in_machine(
    effects: Mapping[str, float],
    scenario: Scenario,
    rig: Rig,
    store: FmuStore,
    noise: Noise = WHITE,
    seed: int = 0,
) -> dict[str, Array]:
    """Make a run of a scenario's machine that hides effects: columns by header as in a CSV file.

    Columns are called as `diagnose` expects them for this machine. `effects` are strengths in SI units, by
    names of `effects_in` or of parameters; `rig` is that of the scenario's file. InputError is raised if an
    effect cannot be hidden in the machine, a value is refused, or nothing is measured in it.
    """
    hidden = {name: effect_in(rig, name) for name in effects}
    outputs = measured_in(rig)
    if not outputs:
        raise InputError(
            f"{rig.name}: no temperature or length of it is measured; wire a thermometer to its controller, "
            "or score the growth of a link"
        )
    random = np.random.default_rng(seed)
    inputs = {name: demand for demand, names in rig.demanded.items() for name in names}
    sources = {name: rig.machine.fed[name] for name in inputs}

    def values(system: System) -> dict[str, float]:
        found = values_together(system, hidden, effects)
        _check_limits(rig, found)
        return found

    result = recorded(scenario, store, [*sources.values(), *outputs], values, STEP)
    rows = rows_of(result, random)
    seen = np.searchsorted(result.times, np.maximum(result.times[rows] - effects.get(CLOCK, 0.0), 0.0))
    readings = {rig.column_of(name): np.array(result[name]) for name in outputs}
    for name in rig.demanded.get(AMBIENT, ())[:1]:
        readings["ambient"] = result[sources[name]]
    changes = [(each.change, effects[name], each.channel) for name, each in hidden.items() if each.change]
    readings = with_changes(result.times, readings, changes)
    last = result.times.size - 1
    true = {name: readings[rig.column_of(name)][np.minimum(seen, last)] for name in outputs}
    read = noisy(result.times[rows], true, noise, random, [name for name in outputs if rig.unit(name) == "m"])
    logged = {name: result[sources[name]][rows] for name in inputs if not _steers_pad(inputs[name])}
    _empty_without_pad(rig, logged, inputs, result, sources, rows)
    columns = {"time [s]": result.times[rows]}
    return columns | dict(_column(rig, name, values) for name, values in {**logged, **read}.items())


def recorded(
    scenario: Scenario, store: FmuStore, names: Sequence[str], hidden: Hidden, step: float
) -> Result:
    """Run the FMUs of a scenario in which some values differ, by steps of at most `step` s.

    InputError is raised if the run does not come to its end, or its values are beyond all bounds.
    """
    system = scenario.system(scenario.files(store))
    changed = with_values(system, hidden(system))
    parts = max(1, int(np.ceil(scenario.step_size / step - 1e-9)))
    stop, step = scenario.stop_time, scenario.step_size / parts
    # By Jacobi a step goes by what the duty cycle says at its beginning, as the row there says it.
    result = guarded(lambda line: simulate(changed, stop, step, Jacobi(), record=names, line=line))
    if result.status != "completed":
        raise InputError(f"{scenario.name}: stopped early: {result.reason}")
    if not all(np.isfinite(result[name]).all() for name in names):
        raise InputError(
            f"effects: temperatures of {scenario.machine.name} grow beyond all bounds; give weaker effects, "
            "or of the other sign"
        )
    return result


def rows_of(result: Result, random: np.random.Generator) -> Array:
    """Communication points that a logger writes down: it does not know when a duty cycle changes.

    InputError is raised where the run is too short for two.
    """
    times = np.asarray(result.times)
    every = max(1, round(INTERVAL / float(times[1] - times[0])))
    rows = np.append(0, np.arange(random.integers(every, 2 * every), times.size, every))
    refuse_too_few(times[rows], INTERVAL)
    return rows


def _steers_pad(demand: str) -> bool:
    return demand in ("pad_mode", "pad_power")


def _empty_without_pad(
    rig: Rig,
    logged: dict[str, Any],
    inputs: Mapping[str, str],
    result: Result,
    sources: Mapping[str, str],
    rows: Array,
) -> None:
    """Empty the cells of a pad's temperature while it is not held; InputError for a pad of given power."""
    for name in (name for name, demand in inputs.items() if demand == "pad_mode"):
        mode = result[sources[name]]
        if np.any(mode == PAD_POWER):
            raise InputError("duty: a run is made with a pad held at a temperature; give pad_temperature")
        held = f"{rig.part_of(name)}.{PAD}"
        if held in logged:
            logged[held] = np.where(mode[rows] == PAD_TEMPERATURE, logged[held], np.nan)


def _check_limits(rig: Rig, values: Mapping[str, float]) -> None:
    """Raise InputError if a component refuses a value."""
    for instance, part in rig.components.items():
        own = {
            n[len(instance) + 1 :]: v for n, v in values.items() if owner_of(rig.components, n) == instance
        }
        limits.checked(part, instance, own)


def _column(rig: Rig, name: str, values: Array) -> tuple[str, Array]:
    """Header and values of a variable's column, in the units that people read."""
    unit, called = rig.unit(name), rig.column_of(name)
    if unit == "K" and rig.variables[name].is_temperature:
        return f"{called} [degC]", values - ZERO_CELSIUS
    return (f"{called} [um]", 1e6 * values) if unit == "m" else (f"{called} [{unit}]", values)
