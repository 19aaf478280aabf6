"""`warmlink list`: everything that can be named on the command line."""

from __future__ import annotations

from warmlink.fmus.packaging.build import catalogue, controller_catalogue
from warmlink.orchestration.commands.console import answer_json
from warmlink.orchestration.master.algorithms import ALGORITHMS
from warmlink.orchestration.scenarios.scenario import load_scenario, scenario_names
from warmlink.orchestration.system.shipped import SHIPPED


def list_command(as_json: bool) -> None:
    """Print the catalogue as tables, or as JSON."""
    found = {
        "scenarios": {name: load_scenario(name).title for name in scenario_names()},
        "controllers": {name: law.description for name, law in sorted(controller_catalogue().items())},
        "systems": {name: blueprint.about for name, blueprint in SHIPPED.items()},
        "components": {component.name: component.description for component in catalogue()},
        "masters": dict(ALGORITHMS),
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
        for name, about in entries.items():
            table.add_row(name, about)
        console.print(table)
        console.print()
