"""`warmlink compare`: its arguments and options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line.options import Json, Parameters, Set


def compare(
    controllers: Annotated[
        str | None, typer.Option(help="Controllers, as `lag,observer`. Default: all (`warmlink list`).")
    ] = None,
    duty_cycles: Annotated[
        str | None,
        typer.Option(
            help="Duty cycles by name, or TOML or CSV files of your own, with commas between. Default: all."
        ),
    ] = None,
    mismatch: Annotated[
        str | None,
        typer.Option(
            help="How the cell differs from what the laws believe: `nominal`, `thermal_high`, `thermal_low`, "
            "`insulated`, `ventilated`, `losses_high`, `losses_low`, `noisy_sensors`, `camera_absent`, "
            "`draw_1`, `draw_2` and so on (the number is the seed), or TOML files. Default: nine of them."
        ),
    ] = None,
    with_: Annotated[
        list[str] | None,
        typer.Option("--with", help="A law of your own, as `my_law.py:MyLaw`. Repeatable."),
    ] = None,
    parameters: Parameters = None,
    set_: Set = None,
    fmus: Annotated[
        str | None, typer.Option(help="`native` (C) or `python` FMUs. Default: native where a C compiler is.")
    ] = None,
    system: Annotated[
        str, typer.Option(help="`WarmupCell`, or `SixAxisArm`, whose duty cycles are its programs.")
    ] = "WarmupCell",
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/compare.")] = None,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    report: Annotated[bool, typer.Option(help="Write report.html.")] = True,
    json: Json = False,
) -> None:
    """Hold controllers against each other and against none, over duty cycles and mismatches.

    What is set of the compensator goes to the controllers that have it; mismatches come on top of it all.
    Writes compare.csv and report.html. Interrupted or killed, the same command goes on. Differences within
    the error budget count as equal; where a duty cycle defeats a law, the table says so.

    Example: `warmlink compare --controllers lag,observer --duty-cycles stop_and_go --mismatch nominal`
    """
    from warmlink.orchestration.commands.compare import compare_command

    raise SystemExit(
        compare_command(
            system,
            controllers,
            duty_cycles,
            mismatch,
            with_ or [],
            parameters or [],
            set_ or [],
            fmus,
            out,
            jobs,
            report,
            as_json=json,
        )
    )
