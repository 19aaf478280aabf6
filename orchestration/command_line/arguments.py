"""What a command takes: its signature says what, its docstring explains it, and the arguments are read.

Parameters before the `*` of a signature are told by their places, those after it by options: `time_limit` by
`--time-limit`, `set_` by `--set`. A Boolean is a flag; one that is not False by default has a `--no-report`
too. The section Parameters of the docstring explains them; what it leaves out is in `options`.

Typer and what it imports take a tenth of the processor time of `warmlink run`, more than the simulation of an
hour takes. Arguments of the simplest kind, nearly all, are therefore read without it; whatever is unusual,
wrong, or asks for help goes to typer.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from functools import wraps
from getopt import GetoptError, gnu_getopt
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_args, get_origin

from warmlink.fmus.arguments import speaking_of_options
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import FAILED, answer, interrupted, print_table, remark
from warmlink.orchestration.progress import without_progress_lines
from warmlink.orchestration.shell import command as shell_command
from warmlink.orchestration.shell import quoted
from warmlink.orchestration.text_files import pair

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Statistics
    from warmlink.orchestration.scenarios.overrides import StartValueSet
    from warmlink.orchestration.scenarios.scenario import Scenario

Command = Callable[..., None]

EXPLAINED = {
    "scenario": "Name of a shipped scenario (`warmlink list`), or a TOML or CSV file of your own.",
    "study": "A study file (TOML), or the name of a shipped study: `lag_law`.",
    "set_": 'Change a start value, for example --set "motor.joint_conductance=2 W/K". Repeatable.',
    "parameters": "A parameter set (SSV) written by `design`, `tune` or `diagnose`. Repeatable.",
    "variant": "Which system, of several in one SSP (`warmlink list FILE` names them). "
    "Default: SystemStructure.",
    "replace": "An FMU of your own in place of a part, as --replace link=My.fmu. Repeatable.",
    "map_": "What the FMU that replaces a part calls a variable, as --map link.heat_flow=Q. Repeatable.",
    "fmus": "`native` (C) or `python` FMUs. Default: native if there is a C compiler.",
    "master": "Master algorithm (`warmlink list`).",
    "tolerance": 'Largest coupling error, such as "0.1 um". The step is then as long as --step and the '
    "sample times allow, or shorter where the error asks for it.",
    "statistics": "Count and time the calls of each FMU; the steps then go plainly.",
    "record": "Variables to write, separated by commas, as --record link.*,compensator.correction. "
    "Default: every one.",
    "csv": "Write results.csv beside results.parquet.",
    "scheduler": "Dask scheduler, such as tcp://10.0.0.1:8786. Default: processes on this machine.",
    "jobs": "How many processes run at the same time.",
    "exact": "Run the FMUs, not the joined system, which is many times faster.",
    "report": "Write report.html.",
    "json": "Print the result as JSON, for other programs.",
}
"""What the docstrings of commands leave out, by the names of their parameters."""

OPTIONS: dict[str | tuple[str, type], str] = {
    "controller_parameters": "--parameters",
    "heat_faces": "--heat-face",
    "long_run": "--checkpoint",
    "long_run.every": "--checkpoint",
    "mismatches": "--mismatch",
    "names": "--map",
    "only_calibrated": "--calibrate-only",
    "pacing": "--real-time",
    "parameters": "--set",
    ("parameters", Path): "--parameters",
    "replaced": "--replace",
    "sensor_points": "--sensor",
    "solver": "--with",
    "terms": "--term",
    "tool_faces": "--tool-face",
    "units": "--unit",
}
"""Options of the arguments of the library's functions that are not called alike."""

_NAMES = {
    "scenario": "closed_loop.load:scenario_names",
    "study": "studies.study:names",
    "controller": "catalogue:controllers",
    "law": "catalogue:controllers",
    "mismatch": "scenarios.mismatch:names",
    "master": "master.algorithms.named:masters",
}
"""Where the names are that the shell proposes, by the names of parameters."""


class Taken(NamedTuple):
    """A parameter of a command, its type without None, and its options, none for one told by its place."""

    parameter: inspect.Parameter
    kind: Any
    options: tuple[str, ...]


def parameters_of(command: Command) -> list[Taken]:
    """Parameters of a command."""
    found = []
    for name, each in inspect.signature(command, eval_str=True).parameters.items():
        optional, word = isinstance(each.annotation, UnionType), name.strip("_").replace("_", "-")
        kind = get_args(each.annotation)[0] if optional else each.annotation  # `str | None`
        options = [f"--{word}"] * (each.kind is each.KEYWORD_ONLY)
        if kind is bool and each.default is not False:
            options.append(f"--no-{word}")
        found.append(Taken(each, kind, tuple(options)))
    return found


def for_typer(command: Command) -> Command:
    """A command as typer takes it."""
    import typer

    about, _, section = inspect.cleandoc(command.__doc__ or "").partition("\nParameters\n----------\n")
    entries = re.findall(r"^(\w+) : (.*(?:\n +.*)*)", section, re.MULTILINE)
    explained = {**EXPLAINED, **{name: " ".join(text.split()) for name, text in entries}}
    parameters = []
    for each, kind, options in parameters_of(command):
        made, names = (typer.Option, ["/".join(options)]) if options else (typer.Argument, [])
        metavar = "" if kind is bool else None  # a flag takes no value
        told = made(*names, help=explained[each.name], autocompletion=proposals(each.name), metavar=metavar)
        parameters.append(each.replace(annotation=Annotated[each.annotation, told]))

    @wraps(command)
    def called(**values: Any) -> None:
        try:
            carry_out(command, values)
        except KeyboardInterrupt as fault:  # which typer would make an exit without a word
            raise interrupted(fault) from None

    called.__doc__ = about
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called


_MATTERS_NOT = ("--json", "--quiet", "--resume", "--no-report", "--no-csv")
"""Options that do not change what is computed."""


def carry_out(command: Command, values: Mapping[str, Any]) -> None:
    """Run a command, whose sentences speak of options meanwhile; for another program it shows no progress."""
    unwatched = values.get("json") or values.get("quiet")
    line = shell_command("warmlink", *(word for word in sys.argv[1:] if word not in _MATTERS_NOT))
    with speaking_of_options(OPTIONS, quoted, line), without_progress_lines() if unwatched else nullcontext():
        command(**values)


def refuse_values_of_flags(command: Command, given: Sequence[str]) -> None:
    """Raise InputError where a flag is given a value, as `--isolate true` or `--isolate=1`."""
    flags = {
        name: each.options for each in parameters_of(command) if each.kind is bool for name in each.options
    }
    for word, after in zip_longest(given, given[1:], fillvalue=""):
        if word == "--":
            return
        name, equals, _ = word.partition("=")
        if name in flags and (equals or after.lower() in _TRUTHS):
            shown = word if equals else f"{word} {after}"
            rule = " or ".join(flags[name]) if len(flags[name]) > 1 else f"{name}, or leave it out"
            raise InputError(f"{shown}: {name} is a flag, which takes no value; write {rule}")


def plain_values(command: Command, given: Sequence[str]) -> dict[str, Any] | None:
    """Values of a command's parameters; None where the arguments are not of the simplest kind.

    That is `VALUE`, `--name VALUE`, `--name=VALUE`, `--flag` and `--no-flag`.
    """
    parameters = parameters_of(command)
    found = {each.name: each.default for each, *_ in parameters if each.default is not each.empty}
    options = {option: each for each in parameters for option in each.options}
    places = [each for each in parameters if not each.options]
    known = [name[2:] + "=" * (each.kind is not bool) for name, each in options.items()]
    try:
        told, words = gnu_getopt(given, "", known)
        if not {name for name, _ in told} <= {text.partition("=")[0] for text in given}:  # a name cut short
            return None
        for name, text in told:
            asked, kind, (positive, *_) = options[name]
            found[asked.name] = name == positive if kind is bool else _value(kind, text, found[asked.name])
        for text in words:
            asked, kind, _ = places[0] if get_origin(places[0].kind) is list else places.pop(0)
            found[asked.name] = _value(kind, text, found.get(asked.name))
    except (GetoptError, LookupError, ValueError):
        return None
    return found if len(found) == len(parameters) else None


def _value(kind: Any, text: str, before: Any) -> Any:
    """Value that a text stands for, added to those before it in a list; ValueError where it is unusual."""
    if get_origin(kind) is list:
        return [*(before or ()), _value(get_args(kind)[0], text, None)]
    if text.startswith("-") or kind not in (str, int, Path):
        raise ValueError
    return kind(text)


def loaded(place: str) -> Any:
    """Load what a place names, as `closed_loop.load:scenario_names`."""
    module, _, name = place.partition(":")
    return getattr(import_module(f"warmlink.orchestration.{module}"), name)


def proposals(parameter: str) -> Callable[[str], list[str]] | None:
    """What the shell proposes for a parameter; None where there are no names to choose from."""
    if parameter not in _NAMES:
        return None

    def beginning(incomplete: str) -> list[str]:
        found = loaded(_NAMES[parameter])
        return [name for name in (found() if callable(found) else found) if name.startswith(incomplete)]

    return beginning


def settings_given(settings: Iterable[str] | None, option: str = "--set") -> dict[str, str]:
    """Read texts `NAME=VALUE` as values by name; raise InputError where a name or a value is missing."""
    examples = {"--set": '"motor.joint_conductance=2 W/K"', "--noise": '"tip_temperature=0.1 K"'}
    return dict(pair(each, option, examples[option]) for each in settings or ())


def sets_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> list[StartValueSet]:
    """Collect the start values of each `--parameters` and then of each `--set`, which take precedence."""
    from warmlink.orchestration.scenarios.overrides import StartValueSet, parameters_of

    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in files or ()]
    return [*sets, *(StartValueSet(f"--set {each}", settings_given([each])) for each in settings or ())]


def values_given(files: Iterable[Path] | None, settings: Iterable[str] | None) -> dict[str, str | float]:
    """Start values of all `--parameters` and `--set` together."""
    return {name: value for each in sets_given(files, settings) for name, value in each.values.items()}


_TRUTHS = ("true", "false", "yes", "no", "on", "off", "1", "0")
"""Words that people write after a flag."""

_COMMA = re.compile(r",(?![^\[]*\])")
"""A comma between names, none between the indices of `A[1,2]`."""


def listed(text: str | None) -> list[str] | None:
    """Split names at their commas, and drop repetitions; None if the option was not given."""
    if text is None:
        return None
    return list(dict.fromkeys(name.strip() for name in _COMMA.split(text) if name.strip()))


def advise(scenario: Scenario) -> None:
    """Remark where a scenario's controller was not designed for its system."""
    from warmlink.orchestration.closed_loop.belief import design_check

    advice, _ = design_check(scenario)
    if advice is not None:
        remark(advice)


def finish(folder: Path, lost: str | None, stopped: str | None, *more: str) -> None:
    """Remark on files that were lost and on a run that stopped early; either ends the command with FAILED."""
    if lost is not None:
        remark(f"{folder}: {lost}")
    if stopped is not None:
        for told in (f"stopped early: {stopped}; what was computed up to there is kept", *more):
            remark(told)
    if lost is not None or stopped is not None:
        raise SystemExit(FAILED)


def print_statistics(statistics: Statistics) -> None:
    """Print what each FMU was asked for, and how long it took."""
    headings, rows = statistics.table()
    print_table("calls of each FMU", headings, rows, texts=1, width=120)
    answer(statistics.summary())
