"""What a command takes: its signature says what, its docstring explains it, and the arguments are read.

Parameters before the `*` of a signature are told by their places, those after it by options: `time_limit` by
`--time-limit`, `set_` by `--set`. A Boolean is a flag; one that is not False by default has a `--no-report`
too. The section Parameters of the docstring explains them; what it leaves out is in `options`.

Typer and what it imports take longer than the simulation of an hour. Arguments of the simplest kind, nearly
all, are therefore read without it; whatever is unusual, wrong, or asks for help goes to typer.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from warmlink.orchestration.console import interrupted

Command = Callable[..., None]


class Taken(NamedTuple):
    """One parameter of a command: its type without None, and its options, none for one told by its place."""

    name: str
    kind: Any
    default: Any
    options: tuple[str, ...]


def taken(command: Command) -> list[Taken]:
    """Parameters of a command."""
    found = []
    for name, each in inspect.signature(command, eval_str=True).parameters.items():
        kind = each.annotation
        if isinstance(kind, UnionType):
            kind = next(one for one in get_args(kind) if one is not NoneType)
        word = name.strip("_").replace("_", "-")
        options = [f"--{word}"] * (each.kind is each.KEYWORD_ONLY)
        if kind is bool and each.default is not False:
            options.append(f"--no-{word}")
        found.append(Taken(name, kind, each.default, tuple(options)))
    return found


def for_typer(command: Command, call: Callable[[dict[str, Any]], None] | None = None) -> Command:
    """A command as typer takes it; `call` takes the values of its parameters in its place."""
    import typer

    from warmlink.orchestration.command_line.options import EXPLAINED, proposals

    about, _, section = inspect.cleandoc(command.__doc__ or "").partition("\nParameters\n----------\n")
    entries = re.findall(r"^(\w+) : (.*(?:\n +.*)*)", section, re.MULTILINE)
    explained = {**EXPLAINED, **{name: " ".join(text.split()) for name, text in entries}}
    signature, parameters = inspect.signature(command, eval_str=True), []
    for each in taken(command):
        made = typer.Option if each.options else typer.Argument
        names = ["/".join(each.options)] if each.options else []
        told = made(*names, help=explained[each.name], autocompletion=proposals(each.name))
        parameter = signature.parameters[each.name]
        parameters.append(parameter.replace(annotation=Annotated[parameter.annotation, told]))

    @wraps(command)
    def called(**values: Any) -> None:
        try:
            command(**values) if call is None else call(values)
        except KeyboardInterrupt:  # which typer would make an exit without a word
            raise interrupted() from None

    called.__doc__ = about
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    return called


def plain_values(command: Command, given: Sequence[str]) -> dict[str, Any] | None:
    """Values of a command's parameters; None where the arguments are not of the simplest kind.

    That is `VALUE`, `--name VALUE`, `--name=VALUE`, `--flag` and `--no-flag`.
    """
    parameters = taken(command)
    found = {each.name: each.default for each in parameters if each.default is not inspect.Parameter.empty}
    places = [each for each in parameters if not each.options]
    options = {option: each for each in parameters for option in each.options}
    left = list(given)
    try:
        while left:
            text = left.pop(0)
            if not text.startswith("-"):
                asked = places[0]
                if get_origin(asked.kind) is not list:
                    del places[0]
            else:
                option, equals, text = text.partition("=")
                asked = options[option]
                if asked.kind is bool and not equals:
                    found[asked.name] = option == asked.options[0]
                    continue
                text = text if equals else left.pop(0)
            found[asked.name] = _value(asked.kind, text, found.get(asked.name))
    except (LookupError, ValueError):
        return None
    return found if len(found) == len(parameters) else None


def _value(kind: Any, text: str, before: Any) -> Any:
    """Value that a text stands for, added to those before it in a list; ValueError where it is unusual."""
    if get_origin(kind) is list:
        return [*(before or ()), _value(get_args(kind)[0], text, None)]
    if text.startswith("-") or kind not in (str, int, Path):
        raise ValueError
    return kind(text)
