"""What the page knows of a scenario: its variables and values, what is scored, drawn and changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from warmlink.fmus.component import Component, Parameter, Scalar, limits
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.orchestration.closed_loop.belief import judged
from warmlink.orchestration.report.closed_loop import CELL_PLOTS, MOST_LINES, OWN_PLOTS, QUANTITIES
from warmlink.orchestration.report.live.files import columns, file_content
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS
from warmlink.orchestration.scenarios.own_system import DRIVER
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.scenarios.setup import CELL, THERMOMETERS
from warmlink.orchestration.system.units import conversion, parse_unit

Plots = Mapping[tuple[str, str], Mapping[str, str]]
"""Variables by the name of their line, by heading and unit."""

SPAN = 3.0
"""A slider goes from a value divided by this to the value times this."""

IDEAL = (
    "the thermometers are perfect and the cell is exactly the one that the law was designed for, as no real "
    "cell is; move a slider, or give the thermometers noise"
)

ROOM = 20.0
"""K by which the slider of a temperature goes up and down."""


class Whole(NamedTuple):
    """A scenario with one controller, and its system as one component, `scenario.joined({})`."""

    scenario: Scenario
    component: Component


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
    scenario, first = systems[0].scenario, systems[0].component
    roles, values = scenario.setup.roles, scenario.values()
    kinds = scenario.setup.blueprint.components
    drivers = [instance for instance, kind in kinds.items() if kind == DRIVER]
    plots = _plots(scenario, first)
    watched = [roles.score.variables, roles.uncompensated.variables, *(of.values() for of in plots.values())]
    changed = list(_parameters(scenario, first, drivers))
    names = {name for each in watched for name in each}
    names |= {each["name"] for each in changed} | set(_duty_vectors(drivers))
    return {
        "name": scenario.name,
        "asked": asked.scenario,
        "given": asked.given,
        "options": asked.options,
        "mismatched": bool(scenario.mismatches),
        "scenario": file_content(scenario),
        "stop": scenario.stop_time,
        "step": scenario.step_size,
        "tolerance": scenario.tolerance,
        "score": roles.score.javascript,
        "uncompensated": roles.uncompensated.javascript,
        "watched": sorted({name for each in watched for name in each}),
        "columns": columns(plots),
        "controllers": scenario.setup.controllers,
        "plots": [
            {"heading": heading, "lines": lines, **_quantity(unit)}
            for (heading, unit), lines in plots.items()
        ],
        "parameters": changed,
        "important": _important(scenario),
        "thermometers": _thermometers(scenario),
        "duty": _duty(drivers, values),
        "notes": {each.scenario.controller.name: _note(each.scenario) for each in systems},
        "laws": {each.scenario.controller.name: _law(each, names) for each in systems},
    }


def _law(system: Whole, names: set[str]) -> dict[str, Any]:
    """Value references of what the page names, and the start values of the scenario by value reference."""
    references = {scalar.name: scalar.reference for scalar in system.component.scalars()}
    given = (
        (references[f"{instance}.{name}"], float(value))
        for instance, of in system.scenario.values().items()
        for name, value in of.items()
    )
    return {"references": {name: references[name] for name in sorted(names)}, "values": list(given)}


def _note(scenario: Scenario) -> str:
    """What a reader should know before trusting a law's figures; empty where there is nothing."""
    advice, ideal = judged(scenario)
    return advice or (IDEAL if ideal else "")


def _plots(scenario: Scenario, whole: Component) -> Plots:
    if scenario.setup.name == CELL.name:
        return CELL_PLOTS
    outputs = [v for v in whole.outputs if v.size is None]
    return {
        (heading, unit): {v.name: v.name for v in [v for v in outputs if v.unit == unit][:MOST_LINES]}
        for heading, unit in OWN_PLOTS
    }


def _quantity(unit: str) -> dict[str, Any]:
    label, factor, zero = QUANTITIES[unit]
    return {"label": label, "factor": factor, "zero": zero}


def _important(scenario: Scenario) -> list[str]:
    """Parameters that have sliders until the page has ranked all by their effect."""
    named = [name.split(".") for name in (*THERMAL_PARAMETERS, EXPANSION)]
    return [f"{part}.{name}" for kind, name in named for part in scenario.setup.called(kind)]


def _parameters(scenario: Scenario, whole: Component, drivers: Sequence[str]) -> Iterator[dict[str, Any]]:
    """The numbers that a reader may change: those of plant and instruments."""
    kept = (*drivers, *scenario.setup.controllers)
    values = scenario.values()
    for scalar in whole.scalars():
        instance, _, variable = scalar.name.rpartition(".")
        if isinstance(scalar.variable, Parameter) and instance not in kept:
            value = float(values.get(instance, {}).get(variable, scalar.start or 0.0))
            low, high, by_factors = _range(scalar, value)
            unit = scalar.variable.display or scalar.variable.unit
            shown = conversion(parse_unit(scalar.variable.unit), parse_unit(unit), False)
            yield {
                "name": scalar.name,
                "about": scalar.variable.description,
                "value": value,
                "low": low,
                "high": high,
                "byFactors": by_factors,
                "si": scalar.variable.unit,
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


def _thermometers(scenario: Scenario) -> list[dict[str, str]]:
    """The thermometers that controllers read: their instance, their channel, and what they measure."""
    blueprint = scenario.setup.blueprint
    read = (
        (source.rpartition("."), target.rpartition("."))
        for source, target in blueprint.wires
        if target.rpartition(".")[0] in scenario.setup.controllers
    )
    return [
        {
            "instance": instance,
            "channel": variable.removeprefix("reading"),
            "label": f"{instance.removesuffix('sensors')}{sensed.removesuffix('_temperature')}",
        }
        for (instance, _, variable), (_, _, sensed) in read
        if blueprint.components[instance] == THERMOMETERS
    ]


def _duty_vectors(drivers: Sequence[str]) -> Iterator[str]:
    """First elements of the vectors of segments, and whether they repeat."""
    for driver in drivers:
        yield f"{driver}.repeat"
        yield from (f"{driver}.{name}[1]" for name in ("duration", *(f"segment_{each}" for each in DEMANDS)))


def _duty(drivers: Sequence[str], values: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Segments with the demands on each of the drivers, whose segments are of the same length."""
    of = [values[driver] for driver in drivers]
    lasting = [i for i in range(1, SEGMENTS + 1) if of[0][f"duration[{i}]"] > 0]
    return {
        "drivers": list(drivers),
        "most": SEGMENTS,
        "repeat": bool(of[0]["repeat"]),
        "segments": [
            {
                "duration": of[0][f"duration[{i}]"],
                **{name: [float(each[f"segment_{name}[{i}]"]) for each in of] for name in DEMANDS},
            }
            for i in lasting
        ],
    }
