"""Running systems and scenarios: run, build, simulate, check, list."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line import names
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


def simulate(
    system: Annotated[Path, typer.Argument(help="An .ssp file, anybody's.")],
    stop: Annotated[str | None, typer.Option(help='Stop time, as "1 h". Default: the system\'s own.')] = None,
    step: Annotated[
        str | None, typer.Option(help='Communication step size, as "1 s". Default: its own.')
    ] = None,
    master: Annotated[
        str, typer.Option(help="Master algorithm (`warmlink list`).", autocompletion=names.masters)
    ] = "jacobi",
    stepping: Annotated[
        str, typer.Option(help="`plain` (Python), `compiled` (Numba), or `auto`: compiled where it pays.")
    ] = "auto",
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/SYSTEM.")] = None,
    isolate: Annotated[
        bool,
        typer.Option("--isolate", help="One process for each FMU: a crash there ends the run, no more."),
    ] = False,
    time_limit: Annotated[
        str | None, typer.Option(help='How long one call of an isolated FMU may take. Default: "60 s".')
    ] = None,
    memory_limit: Annotated[
        str | None, typer.Option(help='How much memory an isolated FMU may take. Default: "4 GB".')
    ] = None,
    checkpoint: Annotated[
        int | None,
        typer.Option(help="Stream values to disk and leave a checkpoint every so many steps."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the checkpoint in the folder, where there is one.")
    ] = False,
    real_time: Annotated[
        float | None,
        typer.Option(help="Keep to the clock: 1 is real time, 10 goes ten times as fast."),
    ] = None,
    error_budget: Annotated[
        bool | None,
        typer.Option(
            "--error-budget/--no-error-budget",
            help="Bound the coupling error by a run with half the step. Default: yes, unless --checkpoint, "
            "--resume or --real-time is given.",
        ),
    ] = None,
    watch: Annotated[
        list[str] | None,
        typer.Option(help="Variable whose coupling error is asked for. Repeatable. Default: every output."),
    ] = None,
    json: Json = False,
) -> None:
    """Run a system of FMUs and write its outputs as CSV and Parquet.

    Ctrl-C ends the run early and keeps what was computed, as does an FMU that fails (exit code 1).
    """
    from warmlink.orchestration.commands.simulate import SimulateOptions, simulate_command

    options = SimulateOptions(
        system,
        stop,
        step,
        master,
        stepping,
        out,
        isolate,
        time_limit,
        memory_limit,
        checkpoint,
        resume,
        real_time,
        error_budget,
        tuple(watch or ()),
    )
    raise SystemExit(simulate_command(options, json))


def check(
    file: Annotated[Path, typer.Argument(help="An .fmu or .ssp file, anybody's.")], json: Json = False
) -> None:
    """Check an FMU or a system as an integrator would; exit code 1 where a check fails."""
    from warmlink.orchestration.commands.check import check_command

    raise SystemExit(check_command(file, json))


def list_(json: Json = False) -> None:
    """List what warmlink knows: scenarios, controllers, systems, components, mismatches, studies, masters."""
    from warmlink.orchestration.commands.catalogue import list_command

    list_command(json)
