"""What several commands take: the explanations, the names that the shell proposes, and how it is read."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Statistics
    from warmlink.orchestration.scenarios.overrides import StartValueSet
    from warmlink.orchestration.scenarios.scenario import Scenario

EXPLAINED = {
    "scenario": "Name of a shipped scenario (`warmlink list`), or a TOML or CSV file of your own.",
    "study": "A study file (TOML), or the name of a shipped study: `lag_law`.",
    "set_": 'Change a start value, for example --set "motor.joint_conductance=2 W/K". Repeatable.',
    "parameters": "A parameter set (SSV) written by `design`, `tune` or `diagnose`. Repeatable.",
    "replace": "An FMU of your own in place of a part, as --replace link=My.fmu. Repeatable.",
    "map_": "What the FMU that replaces a part calls a variable, as --map link.heat_flow=Q. Repeatable.",
    "fmus": "`native` (C) or `python` FMUs. Default: native if there is a C compiler.",
    "master": "Master algorithm (`warmlink list`).",
    "tolerance": 'Largest coupling error, such as "0.1 um". The step is then as long as --step and the '
    "sample times allow, or shorter where the error asks for it.",
    "statistics": "Count and time the calls of each FMU; the steps then go plainly.",
    "record": "Variables to write, separated by commas, as --record link.*,controller.correction. "
    "Default: every one.",
    "csv": "Write results.csv beside results.parquet.",
    "scheduler": "Dask scheduler, such as tcp://10.0.0.1:8786. Default: processes on this machine.",
    "jobs": "How many processes run at the same time.",
    "exact": "Run the FMUs, not the joined system, which is many times faster.",
    "report": "Write report.html.",
    "json": "Print the result as JSON, for other programs.",
}
"""What the docstrings of commands leave out, by the names of their parameters."""


_NAMES = {
    "scenario": "closed_loop.load:scenario_names",
    "study": "studies.study:names",
    "controller": "catalogue:controllers",
    "law": "catalogue:controllers",
    "mismatch": "scenarios.mismatch:names",
    "master": "master.algorithms.table:ALGORITHMS",
}
"""Where the names are that the shell proposes, by the names of parameters."""


def proposals(parameter: str) -> Callable[[str], list[str]] | None:
    """What the shell proposes for a parameter; None where there are no names to choose from."""
    if parameter not in _NAMES:
        return None

    def beginning(incomplete: str) -> list[str]:
        module, _, attribute = _NAMES[parameter].partition(":")
        found = getattr(import_module(f"warmlink.orchestration.{module}"), attribute)
        return [name for name in (found() if callable(found) else found) if name.startswith(incomplete)]

    return beginning


def settings_given(settings: Iterable[str] | None, option: str = "--set") -> dict[str, str]:
    """Read texts `NAME=VALUE` as values by name; raise InputError where a name or a value is missing."""
    parameters = {}
    for setting in settings or ():
        variable, equals, value = map(str.strip, setting.partition("="))
        if not equals or not variable:
            missing = "no name" if equals else "no value"
            raise InputError(f'{option} {setting}: {missing}; write --set "motor.joint_conductance=2 W/K"')
        parameters[variable] = value
    return parameters


def sets_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> list[StartValueSet]:
    """Collect the start values of each `--parameters` and then of each `--set`, which take precedence."""
    from warmlink.orchestration.scenarios.overrides import StartValueSet, parameters_of

    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in files or ()]
    return [*sets, *(StartValueSet(f"--set {each}", settings_given([each])) for each in settings or ())]


def values_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> dict[str, str | float]:
    """Start values of all `--parameters` and `--set` together."""
    return {name: value for each in sets_given(files, settings) for name, value in each.values.items()}


def listed(text: str | None) -> list[str] | None:
    """Split names at their commas, and drop repetitions; None if the option was not given."""
    if text is None:
        return None
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def advise(scenario: Scenario) -> None:
    """Remark where a scenario's controller was not designed for its system."""
    from warmlink.orchestration.closed_loop.belief import judged
    from warmlink.orchestration.console import remark

    advice, _ = judged(scenario)
    if advice is not None:
        remark(advice)


def print_statistics(statistics: Statistics) -> None:
    """Print what each FMU was asked for, and how long it took."""
    from warmlink.orchestration.console import answer, print_table

    headings, rows = statistics.table()
    print_table("calls of each FMU", headings, rows, texts=1, width=120)
    answer(statistics.summary())
