"""The command `warmlink`."""

from __future__ import annotations

import atexit
import gc
import os
import re
import signal
import sys
from ast import literal_eval
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import typer
    import typer.core

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import remembered
from warmlink.fmus.plugins import plugins
from warmlink.orchestration import command_line
from warmlink.orchestration.command_line.arguments import (
    Command,
    carry_out,
    for_typer,
    plain_values,
    refuse_values_of_flags,
)
from warmlink.orchestration.console import (
    BAD_INPUT,
    FAILED,
    end_as_interrupted,
    interrupted,
    print_plainly,
    remark,
)
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.threads import one_thread_from_the_start

COMMAND_LINE = Path(command_line.__file__).parent
_LISTED = re.compile(r"^COMMANDS = (\(.*\))$", re.MULTILINE)

HELP = "How far off a robot's tool point is while a link warms up, and how well a controller corrects it."

COMPLETES = "_WARMLINK_COMPLETE"
"""Environment variable with which the shell asks for completions."""

_HELP: tuple[list[str], ...] = (["--help"], [])
"""Arguments to which the answer is the list of commands."""


def app(arguments: Sequence[str] | None = None, prog_name: str = "warmlink") -> None:
    """Run the command that the arguments name; by default those of the process."""
    given = sys.argv[1:] if arguments is None else [*arguments]
    if given and given[0] in ours() and COMPLETES not in os.environ:
        command = command_named(given[0])
        refuse_values_of_flags(command, given[1:])
        values = plain_values(command, given[1:])
        if values is not None:
            carry_out(command, values)
            raise SystemExit(0)  # as typer does
    application(given)(given, prog_name=prog_name)


def application(arguments: Sequence[str] = ("",)) -> typer.Typer:
    """What some arguments need: the command that they name, else all; for the list of them, their outlines.

    Reading what every command takes, and drawing frames around it, is half of the time that help takes.
    """
    import typer

    listed = list(arguments) in _HELP and COMPLETES not in os.environ
    found = typer.Typer(
        name="warmlink",
        epilog="Begin with: warmlink run",
        no_args_is_help=True,
        rich_markup_mode=None if listed else "markdown",
        pretty_exceptions_enable=False,
    )
    found.callback(invoke_without_command=True, help=HELP)(for_typer(_before_any_command))
    named = [name for name in ours() if [name] == list(arguments[:1])]
    if listed:
        added = {name: _outline(command_named(name)) for name in commands() if name not in ours()}
        for name, sentence in (remembered("outlines", (), _outlines) | added).items():
            found.command(name, short_help=sentence)(lambda: None)
        return found
    for name in named or commands():
        found.command(name, cls=_with_help_as_flag())(for_typer(command_named(name)))
    return found


def _with_help_as_flag() -> type[typer.core.TyperCommand]:
    """Typer's command, whose help shows `--help` as the flag that it is, without a value."""
    from typer.core import TyperCommand

    class Told(TyperCommand):
        def get_help_option(self, ctx: Any) -> Any:
            found = super().get_help_option(ctx)
            if found is not None:
                found.metavar = ""
            return found

    return Told


def _outlines() -> dict[str, str]:
    """First sentence of each of warmlink's own commands."""
    return {name: _outline(command_named(name)) for name in ours()}


def _outline(command: Command) -> str:
    return cleandoc(command.__doc__ or "").partition("\n\n")[0].replace("\n", " ")


@cache
def ours() -> dict[str, str]:
    """Module of each of warmlink's own commands, as the files in `command_line/` list them as `COMMANDS`."""
    found: dict[str, str] = {}
    for path in sorted(COMMAND_LINE.glob("*.py")):  # which are read, as to import all of them takes long
        if listed := _LISTED.search(path.read_text("utf-8")):
            found |= dict.fromkeys(literal_eval(listed[1]), path.stem)
    return found


def commands() -> list[str]:
    """Names of all commands, those that other packages add too; InputError if two are alike."""
    for each in plugins("commands"):
        if each.name in ours():
            raise each.refused("warmlink has a command of this name")
    return [*ours(), *(each.name for each in plugins("commands"))]


def command_named(name: str) -> Command:
    """Function of a command: of the same name, or with a `_` after it."""
    if name not in ours():
        (added,) = (each for each in plugins("commands") if each.name == name)
        made: Command = added.load()
        return made
    module = import_module(f"warmlink.orchestration.command_line.{ours()[name]}")
    found: Command = getattr(module, f"{name}_", None) or getattr(module, name)
    return found


def _before_any_command(*, version: bool = False) -> None:
    """Do what is asked before any command.

    Parameters
    ----------
    version : Print the version.
    """
    if version:
        from warmlink.fmus.packaging.release import version as released

        print(f"warmlink {released()}")
        raise SystemExit


def main() -> None:
    """Run the command that the process's arguments name; it may end in SystemExit."""
    for number in range(3):  # which the caller may have closed: files would take their places
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:  # `print` would take standard output instead
        sys.stderr = os.fdopen(2, "w", closefd=False)
    print_plainly()
    signal.signal(signal.SIGTERM, end_as_interrupted)
    # What a run makes lasts to its end: to look for garbage in it takes a tenth of a short run.
    gc.set_threshold(50_000)
    atexit.register(gc.freeze)
    guarded(_answered)


def _answered() -> None:
    """Run the command, and write what it printed while a full disk can still be told."""
    try:
        app()
    finally:
        if sys.stdout is not None:  # which the caller may have closed
            sys.stdout.flush()


def guarded(command: Callable[[], None]) -> None:
    """Run a command; bad input ends in one sentence and exit code 2."""
    one_thread_from_the_start()
    try:
        command()
    except InputError as fault:
        for sentence in str(fault).split("\n"):
            remark(sentence)
        raise SystemExit(BAD_INPUT) from None
    except SlaveError as fault:
        remark(f"{fault}; there are no results")
        raise SystemExit(FAILED) from None
    except BrokenPipeError:
        sys.stdout = None  # lest Python tries again at its end
        raise SystemExit(0) from None
    except OSError as fault:
        from warmlink.orchestration.files import FULL_DISK

        if fault.errno not in FULL_DISK:
            raise
        sys.stdout = None
        told = os.strerror(fault.errno).lower()
        remark(f"the answer cannot be written ({told}); free space there, and run it again")
        raise SystemExit(FAILED) from None
    except KeyboardInterrupt as fault:
        raise interrupted(fault) from None


if __name__ == "__main__":
    main()
