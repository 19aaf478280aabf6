"""Options that several commands have, and what the shell proposes for a name that is half typed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer


def scenarios(incomplete: str) -> list[str]:
    """Scenarios of the cell and of the arm."""
    from warmlink.orchestration.scenarios.load import scenario_names

    return _beginning(incomplete, scenario_names())


def controllers(incomplete: str) -> list[str]:
    """Controllers that warmlink ships."""
    from warmlink.orchestration.catalogue import controllers as known

    return _beginning(incomplete, known())


def mismatches(incomplete: str) -> list[str]:
    """Mismatches that warmlink ships."""
    from warmlink.orchestration.studies.mismatch import names as known

    return _beginning(incomplete, known())


def masters(incomplete: str) -> list[str]:
    """Master algorithms."""
    from warmlink.orchestration.master.algorithms.table import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def studies(incomplete: str) -> list[str]:
    """Studies that warmlink ships."""
    from warmlink.orchestration.studies.study import names as known

    return _beginning(incomplete, known())


def _beginning(incomplete: str, known: Iterable[str]) -> list[str]:
    return [name for name in known if name.startswith(incomplete)]


Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, for other programs.")]
Report = Annotated[bool, typer.Option(help="Write report.html.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help='Another start value, as --set "motor.joint_conductance=2 W/K". Repeatable.'),
]
Parameters = Annotated[
    list[Path] | None,
    typer.Option(help="A parameter set (SSV) written by `design`, `tune` or `diagnose`. Repeatable."),
]
Fmus = Annotated[
    str | None,
    typer.Option(help="`native` (C) or `python` FMUs. Default: native where there is a C compiler."),
]
Jobs = Annotated[int, typer.Option(help="How many processes run at the same time.")]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Dask scheduler, as tcp://10.0.0.1:8786. Default: processes on this machine."),
]
StudyFile = Annotated[
    str,
    typer.Argument(
        help="A study file (TOML), or a shipped study by name: `lag_law`.", autocompletion=studies
    ),
]
