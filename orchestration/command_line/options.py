"""Options that several commands have, and the names that the shell proposes as completions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from warmlink.fmus.errors import InputError

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Statistics as RunStatistics
    from warmlink.orchestration.scenarios.overrides import StartValueSet


class Option:
    """An option of a command, as an annotation: `stop: Annotated[str | None, Option(help="Stop time.")]`.

    Parameters
    ----------
    name : where it is not the parameter's, as `--set`
    help : a sentence or two
    propose : names for the shell that begin with what was typed
    """

    def __init__(
        self, name: str = "", *, help: str, propose: Callable[[str], list[str]] | None = None
    ) -> None:
        self.names = (name,) if name else ()
        self.help = help
        self.propose = propose


class Argument(Option):
    """An argument that is told by its place."""


def scenarios(incomplete: str) -> list[str]:
    """Scenarios of the cell and of the arm whose names begin with `incomplete`."""
    from warmlink.orchestration.closed_loop.load import scenario_names

    return _beginning(incomplete, scenario_names())


def controllers(incomplete: str) -> list[str]:
    """Shipped controllers whose names begin with `incomplete`."""
    from warmlink.orchestration.catalogue import controllers as shipped

    return _beginning(incomplete, shipped())


def mismatches(incomplete: str) -> list[str]:
    """Shipped mismatches whose names begin with `incomplete`."""
    from warmlink.orchestration.scenarios.mismatch import names

    return _beginning(incomplete, names())


def masters(incomplete: str) -> list[str]:
    """Master algorithms whose names begin with `incomplete`."""
    from warmlink.orchestration.master.algorithms.table import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def studies(incomplete: str) -> list[str]:
    """Shipped studies whose names begin with `incomplete`."""
    from warmlink.orchestration.studies.study import names

    return _beginning(incomplete, names())


def settings_given(settings: Iterable[str], option: str = "--set") -> dict[str, str]:
    """Read texts `NAME=VALUE` as values by name; raise InputError where a name or a value is missing."""
    parameters = {}
    for setting in settings:
        variable, equals, value = setting.partition("=")
        if not equals or not variable.strip():
            missing = "no name" if equals else "no value"
            raise InputError(f'{option} {setting}: {missing}; write --set "motor.joint_conductance=2 W/K"')
        parameters[variable.strip()] = value.strip()
    return parameters


def sets_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> list[StartValueSet]:
    """Collect the start values of each `--parameters` and then of each `--set`, which take precedence."""
    from warmlink.orchestration.scenarios.overrides import StartValueSet, parameters_of

    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in files or ()]
    return [*sets, *(StartValueSet(f"--set {each}", settings_given([each])) for each in settings or ())]


def listed(text: str | None) -> list[str] | None:
    """Split names at their commas, and drop repetitions; None if the option was not given."""
    if text is None:
        return None
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def print_statistics(statistics: RunStatistics) -> None:
    """Print what each FMU was asked for, and how long it took."""
    from warmlink.orchestration.console import answer, print_table

    headings, rows = statistics.table()
    print_table("calls of each FMU", headings, rows, texts=1, width=120)
    answer(statistics.summary())


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


Json = Annotated[bool, Option("--json", help="Print the result as JSON, for other programs.")]
Report = Annotated[bool, Option(help="Write report.html.")]
ScenarioName = Annotated[
    str,
    Argument(
        help="Name of a shipped scenario (`warmlink list`), or a TOML or CSV file of your own.",
        propose=scenarios,
    ),
]

Set = Annotated[
    list[str] | None,
    Option(
        "--set", help='Change a start value, for example --set "motor.joint_conductance=2 W/K". Repeatable.'
    ),
]
Parameters = Annotated[
    list[Path] | None,
    Option(help="A parameter set (SSV) written by `design`, `tune` or `diagnose`. Repeatable."),
]
Fmus = Annotated[
    str | None,
    Option(help="`native` (C) or `python` FMUs. Default: native if there is a C compiler."),
]
Jobs = Annotated[int, Option(help="How many processes run at the same time.")]
Statistics = Annotated[
    bool,
    Option("--statistics", help="Count and time the calls of each FMU; the steps then go plainly."),
]
Tolerance = Annotated[
    str | None,
    Option(
        help='Largest coupling error, such as "0.1 um". The step is then as long as --step and the sample '
        "times allow, or shorter where the error asks for it."
    ),
]
Record = Annotated[
    str | None,
    Option(
        help="Variables to write, separated by commas, as --record link.*,controller.correction. "
        "Default: every one."
    ),
]
Csv = Annotated[bool, Option(help="Write results.csv beside results.parquet.")]
Exact = Annotated[
    bool, Option("--exact", help="Run the FMUs, not the joined system, which is many times faster.")
]
Scheduler = Annotated[
    str | None,
    Option(help="Dask scheduler, such as tcp://10.0.0.1:8786. Default: processes on this machine."),
]
ScenarioFile = Annotated[
    Path | None,
    Option(help="A scenario (TOML) of a cell of your own: its parameters and sensors hold."),
]
Replace = Annotated[
    list[str] | None,
    Option(help="An FMU of your own in place of a part, as --replace link=My.fmu. Repeatable."),
]
Rename = Annotated[
    list[str] | None,
    Option(
        "--map",
        help="What the FMU that replaces a part calls a variable, as --map link.heat_flow=Q. Repeatable.",
    ),
]
StudyFile = Annotated[
    str,
    Argument(help="A study file (TOML), or the name of a shipped study: `lag_law`.", propose=studies),
]
