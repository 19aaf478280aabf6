"""What a command takes: declared in its signature, read here or, with help and every message, by typer.

Typer and what it imports take longer than the simulation of an hour. Arguments of the simplest kind, nearly
all, are therefore read without it; whatever is unusual, wrong, or asks for help goes to typer.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, get_args, get_origin

from warmlink.orchestration.command_line.options import Argument

Command = Callable[..., None]
Reader = tuple[str, Any]
"""Name of a parameter, and its type."""


def for_typer(command: Command, call: Callable[[dict[str, Any]], None] | None = None) -> Command:
    """A command as typer takes it; `call` takes the values of its parameters in its place."""
    import typer

    parameters = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        kind, declared = get_args(parameter.annotation)
        made = typer.Argument if isinstance(declared, Argument) else typer.Option
        told = made(*declared.names, help=declared.help, autocompletion=declared.propose)
        parameters.append(parameter.replace(annotation=Annotated[kind, told]))

    @wraps(command)
    def called(**values: Any) -> None:
        command(**values) if call is None else call(values)

    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    return called


def plain_values(command: Command, given: Sequence[str]) -> dict[str, Any] | None:
    """Values of a command's parameters; None where the arguments are not of the simplest kind.

    That is `VALUE`, `--name VALUE`, `--name=VALUE`, `--flag` and `--no-flag`.
    """
    parameters = inspect.signature(command, eval_str=True).parameters.values()
    found = {each.name: each.default for each in parameters if each.default is not each.empty}
    places, options = _readers(parameters)
    left = list(given)
    try:
        while left:
            text = left.pop(0)
            option, equals, value = text.partition("=")
            if not text.startswith("-"):
                name, kind, value = *places[0], text
                places = places if get_origin(kind) is list else places[1:]
            else:
                name, kind = options[option]
                value = value if equals else left.pop(0) if kind not in (True, False) else ""
            found[name] = _value(kind, value, found.get(name))
    except (LookupError, ValueError):
        return None
    return found if len(found) == len(parameters) else None


def _readers(
    parameters: Iterable[inspect.Parameter],
) -> tuple[list[Reader], dict[str, Reader]]:
    """Names of parameters with their types: of those told by their places, and by option of the others.

    For an option without a value, the value that it stands for takes the place of the type.
    """
    places: list[Reader] = []
    options: dict[str, Reader] = {}
    for each in parameters:
        kind, declared = get_args(each.annotation)
        kinds = [one for one in get_args(kind) if one is not NoneType]
        kind = kinds[0] if isinstance(kind, UnionType) else kind
        option = f"--{each.name.replace('_', '-')}"
        if isinstance(declared, Argument):
            places.append((each.name, kind))
        elif kind is bool and not declared.names:
            options |= {option: (each.name, True), f"--no-{option[2:]}": (each.name, False)}
        else:
            options[(declared.names or (option,))[0]] = (each.name, True if kind is bool else kind)
    return places, options


def _value(kind: Any, text: str, before: Any) -> Any:
    """Value that a text stands for, added to those before it in a list; ValueError where it is unusual."""
    if isinstance(kind, bool) and not text:
        return kind
    if get_origin(kind) is list:
        return [*(before or ()), _value(get_args(kind)[0], text, None)]
    if text.startswith("-") or kind not in (str, int, Path):
        raise ValueError
    return kind(text)
