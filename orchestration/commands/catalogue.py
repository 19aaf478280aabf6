"""`warmlink list`: everything that can be named on the command line."""

from __future__ import annotations

from warmlink.orchestration.arm.blueprint import ABOUT as ARM_ABOUT
from warmlink.orchestration.arm.library import NAME as ARM
from warmlink.orchestration.catalogue import components, controllers
from warmlink.orchestration.commands.console import answer_json
from warmlink.orchestration.diagnosis.practice.effects import about_effects
from warmlink.orchestration.master.algorithms.table import ALGORITHMS, about
from warmlink.orchestration.scenarios.load import load_scenario, scenario_names
from warmlink.orchestration.studies import mismatch
from warmlink.orchestration.studies.study import load_study
from warmlink.orchestration.studies.study import names as study_names
from warmlink.orchestration.system.shipped import SHIPPED


def list_command(as_json: bool) -> None:
    """Print the catalogue as tables, or as JSON."""
    found = {
        "scenarios": {name: load_scenario(name).title for name in scenario_names()},
        "controllers": {name: law.description for name, law in controllers().items()},
        "systems": {**{name: blueprint.about for name, blueprint in SHIPPED.items()}, ARM: ARM_ABOUT},
        "components": {name: component.description for name, component in components().items()},
        "mismatches": {name: mismatch.load(name).about for name in mismatch.names()},
        "studies": {name: load_study(name).title for name in study_names()},
        "effects to hide": about_effects(),
        "masters": {name: about(name) for name in ALGORITHMS},
    }
    if as_json:
        answer_json(found)
        return
    _print_tables(found)


def _print_tables(found: dict[str, dict[str, str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    for kind, entries in found.items():
        table = Table(title=kind, title_justify="left", title_style="bold", box=None, show_header=False)
        table.add_column(style="cyan", no_wrap=True)
        table.add_column()
        for name, text in entries.items():
            table.add_row(name, text)
        console.print(table)
        console.print()
