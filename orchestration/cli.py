"""The command `warmlink`: parse, call, print."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError

app = typer.Typer(
    name="warmlink",
    help="How far off a robot's tool point is while its link warms up, and what a controller takes out.",
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


@app.command()
def build(
    fmus: Annotated[str, typer.Option(help="`native`, `python` or `all`.")] = "all",
    platforms: Annotated[
        str | None,
        typer.Option(
            help="Native platforms, as `x86_64-linux,x86_64-windows`, or `all`. Default: this machine's."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to build into.")] = Path("dist"),
    json: Json = False,
) -> None:
    """Build the FMUs and the systems (SSP) for other tools, and validate each."""
    from warmlink.orchestration.commands.build import build_command

    build_command(fmus, platforms, out, json)


@app.command()
def simulate(
    system: Annotated[Path, typer.Argument(help="An .ssp file, anybody's.")],
    stop: Annotated[str | None, typer.Option(help='Stop time, as "1 h". Default: the system\'s own.')] = None,
    step: Annotated[
        str | None, typer.Option(help='Communication step size, as "1 s". Default: its own.')
    ] = None,
    master: Annotated[str, typer.Option(help="Master algorithm (`warmlink list`).")] = "jacobi",
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/SYSTEM.")] = None,
    json: Json = False,
) -> None:
    """Run a system of FMUs and write its outputs as CSV and Parquet."""
    from warmlink.orchestration.commands.simulate import simulate_command

    raise SystemExit(simulate_command(system, stop, step, master, out, json))


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="An .fmu or .ssp file, anybody's.")], json: Json = False
) -> None:
    """Check an FMU or a system as an integrator would; exit code 1 where a check fails."""
    from warmlink.orchestration.commands.check import check_command

    raise SystemExit(check_command(file, json))


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("out/reproduce"),
    json: Json = False,
) -> None:
    """Compute the paper's tables and figures: Eq. (4), the 1-D link and 3-D finite elements beside them."""
    from warmlink.orchestration.commands.reproduce import reproduce_command

    reproduce_command(out, json)


@app.command(name="list")
def list_(json: Json = False) -> None:
    """List what warmlink knows: scenarios, controllers, systems, components, master algorithms."""
    from warmlink.orchestration.commands.catalogue import list_command

    list_command(json)


if __name__ == "__main__":
    main()
