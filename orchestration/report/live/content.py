"""What the page knows of a scenario: its values, what is scored, drawn and read, and how it is written."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product, starmap
from typing import Any, NamedTuple

from warmlink.fmus.component import Component, Output, Parameter
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.pose_sequence.equations import AXES, POSES
from warmlink.fmus.recorded_duty.component import COMPONENT as PLAYER
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.machine.machine import Plots
from warmlink.orchestration.report.closed_loop import QUANTITIES, plots_of
from warmlink.orchestration.report.figures import looks_of
from warmlink.orchestration.report.live.form import OWN, drivers_of, words_of
from warmlink.orchestration.scenarios.duties.recorded import MEASURED, RECORDED
from warmlink.orchestration.scenarios.logged.layout import conversion_to
from warmlink.orchestration.scenarios.plausible import shown_in
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.system.ssp.parameter_values import parameter_set_element
from warmlink.orchestration.system.xml import to_bytes
from warmlink.orchestration.text_files import read_toml

IDEAL = (
    "the thermometers are perfect and the cell is exactly the one that the law was designed for, as no real "
    "cell is; move a slider, or give the thermometers noise"
)

UNITS = {
    "s": ("s", "min", "h", "ms"),
    "K": ("K", "degC", "°C", "C", "degF", "°F", "F"),
    "m": ("m", "mm", "um", "µm", "nm"),
    "rad/s": ("rad/s", "deg/s", "rpm", "1/min"),
    "N.m": ("N.m", "N*m", "Nm", "mNm"),
    "W": ("W", "kW"),
}
"""Spellings of units that the page knows in a measured run, by SI unit; the command knows more."""


class WholeSystem(NamedTuple):
    """A scenario with one controller, its system as one component without start values, and compiled."""

    scenario: Scenario
    component: Component
    module: bytes


@dataclass(frozen=True)
class Asked:
    """How a reader names the scenario in a command, and what stands beside it there.

    Attributes
    ----------
    given : start values, one by one
    mismatches : their names
    options : others, as `--stop`
    parameters : files of start values (SSV), which the command names: it would be too long with each value
    """

    scenario: str
    given: Mapping[str, str | float]
    mismatches: Sequence[str] = ()
    options: Mapping[str, str] = field(default_factory=dict)
    parameters: Sequence[str] = ()

    @property
    def words(self) -> list[str]:
        """The words of the command that name a scenario, its mismatches and files of start values."""
        repeated = {"--mismatch": self.mismatches, "--parameters": self.parameters}
        options = (word for name, all_of in repeated.items() for each in all_of for word in (name, each))
        return [self.scenario, *options]


def content(systems: Sequence[WholeSystem], asked: Asked) -> dict[str, Any]:
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
    roles, machine, drivers = scenario.machine.roles, scenario.machine, drivers_of(scenario)
    plots = plots_of(machine, {v.name: v.unit for v in first.outputs if v.size is None})
    laws = [each.scenario.controller.name for each in systems]
    recorded = _recorded(scenario)
    drawn = {*recorded, *(name for of in plots.values() for name in of.values())}
    watched = sorted({*roles.score.variables, *roles.uncompensated.variables, *drawn})
    score, uncompensated = (f"1e6 * ({each.javascript})" for each in (roles.score, roles.uncompensated))
    errors = [_line(NO_CONTROLLER, uncompensated), *_of_laws("", score, laws)]
    band = 1e6 * scenario.tolerance
    return {
        "name": scenario.name,
        "asked": asked.words,
        "given": asked.given,
        "options": asked.options,
        "scenario": _file_content(scenario, asked),
        "ssv": to_bytes(parameter_set_element(scenario.name, {})).decode(),
        "step": scenario.step_size,
        "score": score,
        "watched": watched,
        "bands": _bands(first, watched),
        "columns": columns(plots),
        "plots": [
            _plot("Error of the tool point", "error [µm]", errors, band),
            *(_plot_of(*each, of, machine.controllers, laws) for each, of in plots.items()),
            *starmap(_recorded_plot, recorded.items()),
        ],
        "words": words_of(drivers),
        "repeat": "".join(f"{first}.repeat" for first in drivers[:1]),
        "most": SEGMENTS,
        "played": _played(first) if first.tables else None,
        "laws": {each.scenario.controller.name: _law(each, watched, drivers) for each in systems},
    }


def _recorded(scenario: Scenario) -> dict[str, Output]:
    """Outputs that play a recorded duty's columns, by their full names, but for those that never change."""
    return {
        f"{part}.{output.name}": output
        for part, table in scenario.machine.tables.items()
        for output, values in zip(PLAYER.outputs, table.columns, strict=True)
        if values.size > 1
    }


def _played(whole: Component) -> dict[str, Any]:
    """First line of the file of a table that the page may be given, and how it shows each column."""
    (played, *_) = whole.tables
    units = {output.name: output.unit for output in PLAYER.outputs}
    shown = {name: QUANTITIES.get(unit, ("", 1.0, 0.0))[1:] for name, unit in units.items()}
    return {"head": played.head.decode(), "columns": shown}


def _recorded_plot(name: str, output: Output) -> dict[str, Any]:
    """A plot of a column of a recorded duty."""
    unit, factor, zero = QUANTITIES.get(output.unit, (output.unit, 1.0, 0.0))
    word = output.name.replace("_", " ")
    label = unit if output.unit in QUANTITIES else f"{word} [{unit}]"
    return _plot(f"Recorded duty: {word}", label, [_line(word, f"{factor!r} * (v[{name!r}][i] - {zero!r})")])


def _bands(component: Component, watched: Sequence[str]) -> dict[str, list[float | str]]:
    """Lowest and highest value of what is watched at which the model holds, in SI, and both for people."""
    return {
        scalar.name: [band.low, band.high, f"{shown_in(scalar, band.low)} to {shown_in(scalar, band.high)}"]
        for scalar in component.scalars()
        if scalar.name in watched and (band := scalar.variable.plausible) is not None
    }


def _plot(heading: str, label: str, lines: Sequence[dict[str, str]], band: float = 0.0) -> dict[str, Any]:
    """A plot whose lines differ in colour and dashes, whichever of them are drawn."""
    looks = looks_of([line["law"] or line["name"] for line in lines])
    styled = [{**line, "style": look} for line, look in zip(lines, looks, strict=True)]
    return {"heading": heading, "label": label, "band": band, "lines": styled}


def _plot_of(
    heading: str, unit: str, drawn: Mapping[str, str], controllers: Sequence[str], laws: Sequence[str]
) -> dict[str, Any]:
    """A plot of variables; each law draws those of the controllers."""
    label, factor, zero = QUANTITIES[unit]
    lines = []
    for name, variable in drawn.items():
        shown = f"{factor!r} * (v[{variable!r}][i] - {zero!r})"
        own = variable.rpartition(".")[0] in controllers
        lines += _of_laws(f"{name}, ", shown, laws) if own else [_line(name, shown, column=_column(name))]
    return _plot(heading, label, lines)


def _line(name: str, expression: str, law: str = "", column: str = "") -> dict[str, str]:
    """A line of a plot: of a law, or of any; with the column of a measured run that is drawn over it."""
    return {"name": name, "expression": expression, "law": law, "column": column}


def _of_laws(name: str, expression: str, laws: Sequence[str]) -> list[dict[str, str]]:
    """Lines of an expression, one for each law that compensates."""
    return [_line(f"{name}{law}", expression, law) for law in laws if law != NO_CONTROLLER]


def _law(system: WholeSystem, watched: Sequence[str], drivers: Sequence[str]) -> dict[str, Any]:
    """What a reader should know of a law, its value references, and the scenario's start values by these.

    A variable has references by its place in the page's field; what all joints do has one in each of them.
    """
    scalars = {scalar.name: scalar for scalar in system.component.scalars()}
    given = [
        (scalars[f"{instance}.{name}"].reference, float(value))
        for instance, of in system.scenario.values().items()
        for name, value in of.items()
    ]
    references: dict[str, list[list[int]]] = {}
    for name, scalar in scalars.items():
        instance, _, variable = scalar.variable.name.rpartition(".")
        if instance in drivers and isinstance(scalar.variable, Parameter):
            holder = instance if variable.removeprefix("segment_") in OWN else drivers[0]
            places = references.setdefault(
                f"{holder}.{variable}", [[] for _ in range(scalar.variable.size or 1)]
            )
            places[scalar.element].append(scalar.reference)
        elif isinstance(scalar.variable, Parameter):
            references[name] = [[scalar.reference]]
    advice, ideal = design_check(system.scenario)
    told = advice or (IDEAL if ideal else "")
    note = f"{system.scenario.controller.name}: {told}." if told else ""
    shown = [scalars[name].reference for name in watched]
    return {"references": references, "values": given, "watched": shown, "note": note}


def columns(plots: Plots) -> dict[str, dict[str, tuple[float, float]]]:
    """Columns of a measured run by name: factor and offset of each unit into what is shown."""
    drawn = {_column(line): unit for (_, unit), of in plots.items() for line in of}
    known = {**RECORDED, **{name: drawn[name] for name in MEASURED if name in drawn}}
    return {name: _units(unit) for name, unit in known.items()}


def _column(line: str) -> str:
    """Column of a measured run that is drawn over a line; empty if there is none."""
    label = line.removeprefix("link, ")
    return next((name for name in MEASURED if name.removesuffix("_temperature") == label), "")


def _units(unit: str) -> dict[str, tuple[float, float]]:
    _, factor, zero = QUANTITIES.get(unit, ("", 1.0, 0.0))
    si = {each: conversion_to(each, unit, "", difference=False)[0] for each in UNITS[unit]}
    found = {each: read.then(factor, -factor * zero) for each, read in si.items()}
    return {spelled: (each.factor, each.offset) for spelled, each in found.items()}


def _file_content(scenario: Scenario, asked: Asked) -> dict[str, Any]:
    """What a scenario's file says besides its duty cycle: its head, its further tables, its parameters."""
    top: dict[str, Any] = {
        "title": scenario.title,
        "step_size": f"{scenario.step_size!r} s",
        "master": scenario.master,
        "tolerance": f"{scenario.tolerance!r} m",
    }
    sensors = {"noise": scenario.sensors.noise, "used": scenario.sensors.used}
    tables = _toml("[sensors]", {name: value for name, value in sensors.items() if value is not None})
    written = {} if scenario.file is None else read_toml(scenario.file)
    for table in scenario.machine.tables.values():
        top["duty"] = written.get("duty", asked.scenario)
        top |= {"linear": sorted(table.linear)} if table.linear else {}
    if "roles" in written:
        top["system"] = written["system"]
        tables += _toml("[roles]", written["roles"])
    if scenario.machine.program:
        top["system"] = scenario.machine.name
    values = scenario.values()
    for held, i in product((values[each] for each in scenario.machine.called("poses")), range(1, POSES + 1)):
        if held[f"duration[{i}]"]:
            joints = [held[f"joint_{joint}[{i}]"] for joint in range(1, AXES + 1)]
            tables += _toml("[[pose]]", {"hold": held[f"duration[{i}]"], "joints": joints})
    return {"top": _toml("", top), "tables": tables, "parameters": scenario.parameters}


def _toml(heading: str, table: Mapping[str, Any]) -> list[str]:
    """Lines of a table in a TOML file, whose strings, numbers and lists are written as in JSON."""
    written = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in table.items()]
    return ["", heading, *written] if heading else written
