"""The command `warmlink`: parse, call, print."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError

app = typer.Typer(
    name="warmlink",
    help="How far off is a robot's tool point while its link warms up, and how well a controller takes that out.",
    epilog="Begin with: warmlink run",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)

BAD_INPUT, FAILED = 2, 1

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, for machines.")]


def main() -> None:
    """Entry point of the command: bad input ends in one sentence and exit code 2."""
    try:
        app()
    except InputError as fault:
        print(f"warmlink: {fault}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None
    except BrokenPipeError:
        raise SystemExit(0) from None


@app.command()
def run(
    scenario: Annotated[
        str, typer.Argument(help="Name of a shipped scenario (`warmlink list`), or a TOML file of your own.")
    ] = "windshield_wiper",
    controller: Annotated[
        str | None, typer.Option(help="Controller to hold against none. Default: the scenario's.")
    ] = None,
    fmus: Annotated[
        str | None, typer.Option(help="`native` (C) or `python` FMUs. Default: native where a C compiler is.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/SCENARIO.")] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help='Another start value, as --set "motor.joint_conductance=2 W/K". Repeatable.'
        ),
    ] = None,
    step: Annotated[str | None, typer.Option(help='Communication step size, as "1 s".')] = None,
    stop: Annotated[str | None, typer.Option(help='Stop time, as "2 h".')] = None,
    master: Annotated[str | None, typer.Option(help="Master algorithm (`warmlink list`).")] = None,
    report: Annotated[bool, typer.Option(help="Write report.html.")] = True,
    json: Json = False,
) -> None:
    """Run a scenario with a controller and without, and say how far off the tool point is.

    Writes metrics.json, results.csv, results.parquet and report.html.
    """
    from warmlink.orchestration.commands.run import run_command

    raise SystemExit(
        run_command(scenario, controller, fmus, out, set_ or [], step, stop, master, report, json)
    )


@app.command(name="list")
def list_(json: Json = False) -> None:
    """List what warmlink knows: scenarios, controllers, systems, components, master algorithms."""
    from warmlink.orchestration.commands.catalogue import list_command

    list_command(json)


if __name__ == "__main__":
    main()
