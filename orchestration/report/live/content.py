"""What the page knows of a scenario: its variables and values, what is scored, drawn, changed and read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from warmlink.fmus.component import Component, Parameter, Scalar, limits
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.fmus.pose_sequence.equations import AXES, POSES
from warmlink.orchestration.arm.blueprint import POSES as POSE_SEQUENCE
from warmlink.orchestration.closed_loop.belief import judged
from warmlink.orchestration.report.closed_loop import QUANTITIES, Plots, plots_of
from warmlink.orchestration.scenarios.duties.duty_files import MEASURED, RECORDED
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS
from warmlink.orchestration.scenarios.own_system import DRIVER
from warmlink.orchestration.scenarios.quantity import converter
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.scenarios.setup import THERMOMETERS
from warmlink.orchestration.system.units import conversion, parse_unit
from warmlink.orchestration.text_files import read_toml

SPAN = 3.0
"""A slider goes from a value divided by this to the value times this."""

ROOM = 20.0
"""K by which the slider of a temperature goes up and down."""

IDEAL = (
    "the thermometers are perfect and the cell is exactly the one that the law was designed for, as no real "
    "cell is; move a slider, or give the thermometers noise"
)

UNITS = {
    "s": ("s", "min", "h", "ms"),
    "K": ("K", "degC", "°C", "degF"),
    "m": ("m", "mm", "um", "µm", "nm"),
    "rad/s": ("rad/s", "deg/s", "rpm"),
    "N.m": ("N.m", "N*m"),
    "W": ("W", "kW"),
}
"""Spellings of units that the page knows in a measured run, by SI unit; the command knows more."""


class Whole(NamedTuple):
    """A scenario with one controller, its system as one component without start values, and compiled."""

    scenario: Scenario
    component: Component
    module: bytes


@dataclass(frozen=True)
class Asked:
    """How a reader names the scenario in a command, the start values given beside it, and other options."""

    scenario: str
    given: Mapping[str, str | float]
    options: Sequence[tuple[str, str]] = ()


def content(systems: Sequence[Whole], asked: Asked) -> dict[str, Any]:
    """Content of the page, to be written as JSON.

    Parameters
    ----------
    systems : one for each controller; what the page begins with is the first one's
    asked : how the command was called

    Raises
    ------
    InputError
        If a controller refuses a start value of the scenario.
    """
    scenario, first, _ = systems[0]
    roles, setup = scenario.setup.roles, scenario.setup
    drivers = [instance for instance, kind in setup.blueprint.components.items() if kind == DRIVER]
    plots = plots_of(setup.name, {v.name: v.unit for v in first.outputs if v.size is None})
    watched = {*roles.score.variables, *roles.uncompensated.variables}
    watched |= {name for of in plots.values() for name in of.values()}
    changed = list(_parameters(scenario, first, drivers))
    names = {*watched, *(each["name"] for each in changed)}
    for driver in drivers:  # the first elements of the vectors of segments
        names |= {f"{driver}.{name}[1]" for name in ("duration", *(f"segment_{each}" for each in DEMANDS))}
        names.add(f"{driver}.repeat")
    important = [name.split(".") for name in (*THERMAL_PARAMETERS, EXPANSION)]
    return {
        "name": scenario.name,
        "asked": asked.scenario,
        "given": asked.given,
        "options": asked.options,
        "mismatched": bool(scenario.mismatches),
        "scenario": _file_content(scenario),
        "stop": scenario.stop_time,
        "step": scenario.step_size,
        "tolerance": scenario.tolerance,
        "score": roles.score.javascript,
        "uncompensated": roles.uncompensated.javascript,
        "watched": sorted(watched),
        "columns": columns(plots),
        "controllers": setup.controllers,
        "plots": [
            {
                "heading": heading,
                "lines": lines,
                **dict(zip(("label", "factor", "zero"), QUANTITIES[unit], strict=True)),
            }
            for (heading, unit), lines in plots.items()
        ],
        "parameters": changed,
        # These have sliders until the page has ranked all by their effect.
        "important": [f"{part}.{name}" for kind, name in important for part in setup.called(kind)],
        "thermometers": list(_thermometers(scenario)),
        "duty": _duty([scenario.values()[driver] for driver in drivers], drivers),
        "notes": {each.scenario.controller.name: _note(each.scenario) for each in systems},
        "laws": {each.scenario.controller.name: _law(each, names) for each in systems},
    }


def _law(system: Whole, names: set[str]) -> dict[str, Any]:
    """Value references of what the page names, and the start values of the scenario by value reference."""
    references = {scalar.name: scalar.reference for scalar in system.component.scalars()}
    given = [
        (references[f"{instance}.{name}"], float(value))
        for instance, of in system.scenario.values().items()
        for name, value in of.items()
    ]
    return {"references": {name: references[name] for name in sorted(names)}, "values": given}


def _note(scenario: Scenario) -> str:
    """What a reader should know before trusting a law's figures; empty where there is nothing."""
    advice, ideal = judged(scenario)
    return advice or (IDEAL if ideal else "")


def _parameters(scenario: Scenario, whole: Component, drivers: Sequence[str]) -> Iterator[dict[str, Any]]:
    """The numbers that a reader may change: those of plant and instruments."""
    kept = (*drivers, *scenario.setup.controllers)
    values = scenario.values()
    for scalar in whole.scalars():
        instance, _, name = scalar.name.rpartition(".")
        variable = scalar.variable
        if isinstance(variable, Parameter) and instance not in kept:
            value = float(values.get(instance, {}).get(name, scalar.start or 0.0))
            low, high, by_factors = _range(scalar, value)
            unit = variable.display or variable.unit
            shown = conversion(parse_unit(variable.unit), parse_unit(unit), False)
            yield {
                "name": scalar.name,
                "about": variable.description,
                "value": value,
                "low": low,
                "high": high,
                "byFactors": by_factors,
                "si": variable.unit,
                "unit": unit,
                "factor": shown.factor,
                "offset": shown.offset,
            }


def _range(scalar: Scalar, value: float) -> tuple[float, float, bool]:
    """Ends of a slider, and whether it goes by factors."""
    variable = scalar.variable
    lowest = -float("inf") if scalar.lower is None else scalar.lower
    highest = float("inf") if variable.maximum is None else variable.maximum
    if variable.display == "degC":
        return max(value - ROOM, lowest), min(value + ROOM, highest), False
    if value > 0 and variable.type == "Real":
        return value / SPAN, min(value * SPAN, highest), True
    size = limits.ordinary_size(variable)
    most = highest if highest < float("inf") else max(size, SPAN * abs(value))
    return max(lowest, -most), most, False


def _thermometers(scenario: Scenario) -> Iterator[dict[str, str]]:
    """The thermometers that controllers read: their instance, their channel, and what they measure."""
    blueprint = scenario.setup.blueprint
    for source, target in blueprint.wires:
        instance, _, variable = source.rpartition(".")
        reader, _, sensed = target.rpartition(".")
        if reader in scenario.setup.controllers and blueprint.components[instance] == THERMOMETERS:
            label = f"{instance.removesuffix('sensors')}{sensed.removesuffix('_temperature')}"
            yield {"instance": instance, "channel": variable.removeprefix("reading"), "label": label}


def _duty(values: Sequence[Mapping[str, Any]], drivers: Sequence[str]) -> dict[str, Any]:
    """Segments with the demands on each of the drivers, whose segments are of the same length."""
    first = values[0]
    segments = [
        {
            "duration": first[f"duration[{i}]"],
            **{name: [float(each[f"segment_{name}[{i}]"]) for each in values] for name in DEMANDS},
        }
        for i in range(1, SEGMENTS + 1)
        if first[f"duration[{i}]"] > 0
    ]
    return {"drivers": drivers, "most": SEGMENTS, "repeat": bool(first["repeat"]), "segments": segments}


def columns(plots: Plots) -> dict[str, dict[str, Any]]:
    """Columns of a measured run by name: units with factor and offset into SI, and what they measure."""
    lines: dict[str, tuple[str, str]] = {}
    for (_, unit), of in plots.items():
        lines |= {name.removeprefix("link, "): (unit, variable) for name, variable in of.items()}
    known: dict[str, dict[str, Any]] = {n: {"units": _units(u)} for n, u in RECORDED.items()}
    for name in MEASURED:
        line = lines.get(name.removesuffix("_temperature"))
        if line is not None:
            known[name] = {"units": _units(line[0]), "variable": line[1]}
    return known


def _units(unit: str) -> dict[str, tuple[float, float]]:
    found = {spelled: converter(spelled, unit) for spelled in UNITS[unit]}
    return {spelled: (each.factor, each.offset) for spelled, each in found.items()}


def _file_content(scenario: Scenario) -> dict[str, Any]:
    """What a scenario's file says besides its duty cycle, with which the page writes one."""
    tables: dict[str, Any] = {}
    top: dict[str, Any] = {
        "title": scenario.title,
        "step_size": f"{scenario.step_size!r} s",
        "master": scenario.master,
        "tolerance": f"{scenario.tolerance!r} m",
    }
    written = {} if scenario.file is None else read_toml(scenario.file)
    if "roles" in written:
        top["system"], tables["roles"] = written["system"], written["roles"]
    held = scenario.values().get(POSE_SEQUENCE, {})
    if held:
        top["system"] = scenario.setup.name
    sensors = {"noise": scenario.sensors.noise, "used": scenario.sensors.used}
    tables["sensors"] = {name: value for name, value in sensors.items() if value is not None}
    poses = [
        {
            "hold": held[f"duration[{i}]"],
            "joints": [held[f"joint_{joint}[{i}]"] for joint in range(1, AXES + 1)],
        }
        for i in range(1, POSES + 1)
        if held.get(f"duration[{i}]")
    ]
    return {"top": top, "tables": tables, "parameters": scenario.parameters, "poses": poses}
