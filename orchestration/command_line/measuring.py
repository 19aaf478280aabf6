"""Holding models against measurements: diagnose, hide, reproduce."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line.options import Json


def diagnose(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Runs (CSV) of a warm-up cell, to be judged together; a run of the six-axis arm; or an "
            "experiment (TOML)."
        ),
    ],
    assume: Annotated[
        list[str] | None,
        typer.Option(
            help='Input that was not logged, as --assume torque=0, "ambient_temperature=22 degC" or '
            "pad_temperature=off. Repeatable."
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help='Parameter that is known to differ, as --set "link.length=800 mm". Repeatable.',
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for results. Default: out/RUN, out/RUN+NEXT for two.")
    ] = None,
    json: Json = False,
) -> None:
    """Show what the simulation gets wrong, name the cause, extend the model, measure the improvement.

    Writes diagnosis.json, report.html and the extended model as .ssv and .ssp. Any verdict is exit code 0.
    """
    from warmlink.orchestration.commands.diagnose import diagnose_command

    diagnose_command(data, assume or [], set_ or [], out, json)


def hide(
    effects: Annotated[
        list[str] | None,
        typer.Argument(
            help="Effects to hide, as radiation, joint_resistance=0.3, sensor_lag:tip_temperature."
        ),
    ] = None,
    duty: Annotated[
        str | None,
        typer.Option(help="Duty cycle (CSV) or scenario (TOML) as `run` takes it. Default: two rich hours."),
    ] = None,
    out: Annotated[Path, typer.Option(help="CSV file to write.")] = Path("run.csv"),
    seed: Annotated[int, typer.Option(help="Seed of the noise.")] = 0,
    noise: Annotated[
        str, typer.Option(help="`white`, or `real`: correlated, rounded, with spikes.")
    ] = "white",
    solver: Annotated[
        str,
        typer.Option("--with", help="What computes the run: `grid`, a rod, or `fea`, 3-D finite elements."),
    ] = "grid",
    axis: Annotated[
        int | None, typer.Option(help="Hide it in this axis of the six-axis arm; the run is all the arm's.")
    ] = None,
) -> None:
    """Make a measured run with a hidden effect, from a solver of its own, to practise `diagnose` on."""
    from warmlink.orchestration.commands.diagnose import hide_command

    hide_command(effects or [], duty, out, seed, noise, solver, axis)


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("out/reproduce"),
    json: Json = False,
) -> None:
    """Compute the paper's tables and figures: Eq. (4), the 1-D link and 3-D finite elements beside them."""
    from warmlink.orchestration.commands.reproduce import reproduce_command

    reproduce_command(out, json)
