"""The command `warmlink`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line import (
    build,
    check,
    diagnose,
    hide,
    init,
    live,
    plot,
    reproduce,
    run,
    save,
    schema,
    simulate,
)
from warmlink.orchestration.command_line import list as list_
from warmlink.orchestration.command_line.laws import design, export
from warmlink.orchestration.command_line.studies import compare, sweep, tune
from warmlink.orchestration.console import BAD_INPUT, FAILED, INTERRUPTED
from warmlink.orchestration.master.slaves.slave import SlaveError

app = typer.Typer(
    name="warmlink",
    help="How far off a robot's tool point is while a link warms up, and how well a controller corrects it.",
    epilog="Begin with: warmlink run",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
COMMANDS: dict[str, Callable[..., None]] = {
    "run": run.run,
    "live": live.live,
    "build": build.build,
    "save": save.save,
    "plot": plot.plot,
    "simulate": simulate.simulate,
    "compare": compare.compare,
    "tune": tune.tune,
    "sweep": sweep.sweep,
    "design": design.design,
    "export": export.export,
    "check": check.check,
    "diagnose": diagnose.diagnose,
    "hide": hide.hide,
    "reproduce": reproduce.reproduce,
    "init": init.init,
    "schema": schema.schema,
    "list": list_.list_,
}
for name, command in COMMANDS.items():
    app.command(name)(command)


def _say_version(asked: bool) -> None:
    if asked:
        from warmlink.fmus.packaging.release import version

        print(f"warmlink {version()}")
        raise typer.Exit


@app.callback()
def _before_any_command(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_say_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None: ...


def main() -> None:
    """Entry point of the command."""
    guarded(lambda: app(prog_name="warmlink"))


def guarded(command: Callable[[], None]) -> None:
    """Run a command; bad input ends in one sentence and exit code 2."""
    # The matrices are small, and several threads for one product would spend their time waiting for each
    # other. NumPy reads this setting when it is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        command()
    except InputError as fault:
        print(f"warmlink: {fault}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None
    except SlaveError as fault:
        print(f"warmlink: {fault}; there are no results", file=sys.stderr)
        raise SystemExit(FAILED) from None
    except BrokenPipeError:
        raise SystemExit(0) from None
    except SystemExit as ended:
        # Commands that end in order on Ctrl-C print their own remark, and raise SystemExit `from None`.
        if ended.code == INTERRUPTED and ended.__context__ is not None and not ended.__suppress_context__:
            print("warmlink: interrupted; there are no results", file=sys.stderr)
        raise


if __name__ == "__main__":
    main()
