"""`warmlink list`: the names that the other commands accept."""

from __future__ import annotations

from typing import Annotated

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import Json
from warmlink.orchestration.console import answer_json, print_table


def list_(
    what: Annotated[
        list[str] | None,
        typer.Argument(help="`interface COMPONENT`: what may stand in place of a component."),
    ] = None,
    json: Json = False,
) -> None:
    """List the scenarios, controllers, systems, components, mismatches, studies, effects and masters."""
    found = _interface(what) if what else _descriptions()
    if json:
        answer_json(found)
        return
    for kind, entries in found.items():
        print_table(kind, (), entries.items())


def _interface(what: list[str]) -> dict[str, dict[str, str]]:
    """Inputs and outputs of a component with units: what an FMU in its place may be asked for."""
    from warmlink.fmus.names import instead
    from warmlink.orchestration.catalogue import components

    if len(what) != 2 or what[0] != "interface":
        raise InputError(f"list {' '.join(what)}: nothing to list; write `list interface ThermalLink`")
    if what[1] not in components():
        raise InputError(f"{what[1]}: no such component; {instead(what[1], components())}")
    chosen = components()[what[1]]
    return {
        kind: {f"{name} [{each.unit}]": each.description for each in variables for name in each.scalar_names}
        for kind, variables in (("inputs", chosen.inputs), ("outputs", chosen.outputs))
    }


def _descriptions() -> dict[str, dict[str, str]]:
    """One line about each thing, by its kind and its name."""
    from warmlink.orchestration.arm.blueprint import ABOUT as ARM_ABOUT
    from warmlink.orchestration.arm.geometry import NAME as ARM
    from warmlink.orchestration.catalogue import components, controllers
    from warmlink.orchestration.closed_loop.load import load_scenario, scenario_names
    from warmlink.orchestration.diagnosis.practice.effects import about_effects
    from warmlink.orchestration.master.algorithms.table import ALGORITHMS, about
    from warmlink.orchestration.scenarios import mismatch
    from warmlink.orchestration.studies import study
    from warmlink.orchestration.system.shipped import SHIPPED

    return {
        "scenarios": {name: load_scenario(name).title for name in scenario_names()},
        "controllers": {name: law.description for name, law in controllers().items()},
        "systems": {**{name: blueprint.about for name, blueprint in SHIPPED.items()}, ARM: ARM_ABOUT},
        "components": {name: component.description for name, component in components().items()},
        "mismatches": {name: mismatch.load(name).about for name in mismatch.names()},
        "studies": {name: study.load_study(name).title for name in study.names()},
        "effects to hide": about_effects(),
        "masters": {name: about(name) for name in ALGORITHMS},
    }
