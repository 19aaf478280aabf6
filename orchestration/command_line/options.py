"""Options that several commands have, and what the shell proposes for a name that is half typed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warmlink.fmus.errors import InputError

if TYPE_CHECKING:
    from warmlink.orchestration.scenarios.overrides import StartValueSet


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
    from warmlink.orchestration.scenarios.mismatch import names as known

    return _beginning(incomplete, known())


def masters(incomplete: str) -> list[str]:
    """Master algorithms."""
    from warmlink.orchestration.master.algorithms.table import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def studies(incomplete: str) -> list[str]:
    """Studies that warmlink ships."""
    from warmlink.orchestration.studies.study import names as known

    return _beginning(incomplete, known())


def settings_given(settings: Iterable[str], option: str = "--set") -> dict[str, str]:
    """Values by name, as `--set` has them; raises InputError where one has no value."""
    parameters = {}
    for setting in settings:
        variable, equals, value = setting.partition("=")
        if not equals or not variable.strip():
            missing = "no name" if equals else "no value"
            raise InputError(f'{option} {setting}: {missing}; write --set "motor.joint_conductance=2 W/K"')
        parameters[variable.strip()] = value.strip()
    return parameters


def sets_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> list[StartValueSet]:
    """Start values of each `--parameters` and of each `--set`, which come last."""
    from warmlink.orchestration.scenarios.overrides import StartValueSet, parameters_of

    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in files or ()]
    return [*sets, *(StartValueSet(f"--set {each}", settings_given([each])) for each in settings or ())]


def listed(text: str | None) -> list[str] | None:
    """Names with commas between them, each once; None where none were asked for."""
    if text is None:
        return None
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


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
