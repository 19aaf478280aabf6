"""`warmlink run`: its arguments and options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line import options as names
from warmlink.orchestration.command_line.options import Json, Parameters, Set


def run(
    scenario: Annotated[
        str,
        typer.Argument(
            help="Name of a shipped scenario (`warmlink list`), or a TOML or CSV file of your own.",
            autocompletion=names.scenarios,
        ),
    ] = "windshield_wiper",
    controller: Annotated[
        str | None,
        typer.Option(
            help="Controller to hold against none, or a law of your own, as `my_law.py:MyLaw`. "
            "Default: the scenario's.",
            autocompletion=names.controllers,
        ),
    ] = None,
    fmus: Annotated[
        str | None, typer.Option(help="`native` (C) or `python` FMUs. Default: native where a C compiler is.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/SCENARIO.")] = None,
    set_: Set = None,
    parameters: Parameters = None,
    mismatch: Annotated[
        list[str] | None,
        typer.Option(
            help="How the cell differs from what the controller may know of it: `thermal_high`, "
            "`noisy_sensors`, `draw_1` and so on (`warmlink list`), or a TOML file. Repeatable, one on "
            "top of the other.",
            autocompletion=names.mismatches,
        ),
    ] = None,
    step: Annotated[str | None, typer.Option(help='Communication step size, as "1 s".')] = None,
    stop: Annotated[str | None, typer.Option(help='Stop time, as "2 h".')] = None,
    master: Annotated[
        str | None, typer.Option(help="Master algorithm (`warmlink list`).", autocompletion=names.masters)
    ] = None,
    report: Annotated[bool, typer.Option(help="Write report.html.")] = True,
    json: Json = False,
) -> None:
    """Run a scenario with a controller and without, and say how far off the tool point is.

    Writes metrics.json, results.csv, results.parquet and report.html. Ctrl-C ends the run early and keeps
    what was computed, as does an FMU that fails (exit code 1).
    """
    from warmlink.orchestration.commands.run import RunOptions, run_command

    options = RunOptions(
        scenario,
        controller,
        fmus,
        out,
        tuple(set_ or ()),
        tuple(parameters or ()),
        tuple(mismatch or ()),
        step,
        stop,
        master,
        report,
    )
    raise SystemExit(run_command(options, json))
