"""Studies of controllers: compare, tune, sweep, design."""

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


_STUDY_HELP = "A study file (TOML), or a shipped one by name: `lag_law`."
_Scheduler = Annotated[
    str | None,
    typer.Option(help="Dask scheduler, as tcp://10.0.0.1:8786. Default: processes of this machine."),
]
_Jobs = Annotated[int, typer.Option(help="Processes that run at once.")]
_Fmus = Annotated[
    str | None, typer.Option(help="`native` (C) or `python` FMUs. Default: native where a C compiler is.")
]
_Report = Annotated[bool, typer.Option(help="Write report.html.")]


def tune(
    study: Annotated[str, typer.Argument(help=_STUDY_HELP)],
    trials: Annotated[int | None, typer.Option(help="How many trials. Default: the study's.")] = None,
    scheduler: _Scheduler = None,
    jobs: _Jobs = 2,
    fmus: _Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/tune.")] = None,
    report: _Report = True,
    json: Json = False,
) -> None:
    """Find a controller's best parameters with Optuna, judged in closed loop.

    The study file says what to vary between which bounds, over which duty cycles and mismatches, what to make
    small (the worst, the mean, or the mean of the worst share) and what not to exceed:

        controller = "lag"
        duty_cycles = ["windshield_wiper", "stop_and_go"]
        [parameters]
        "compensator.gain" = { min = "2 um/W", max = "8 um/W" }
        [objective]
        metric = "max_abs_um"
        over = "worst"

    Writes trials.csv, winner.ssv and report.html. Interrupted or killed, the same command goes on; its table
    is the same whatever the number of processes.
    """
    from warmlink.orchestration.commands.tune import tune_command

    raise SystemExit(tune_command(study, trials, scheduler, jobs, fmus, out, report, as_json=json))


def sweep(
    study: Annotated[str, typer.Argument(help=_STUDY_HELP)],
    scheduler: _Scheduler = None,
    jobs: _Jobs = 2,
    fmus: _Fmus = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY/sweep.")] = None,
    report: _Report = True,
    json: Json = False,
) -> None:
    """Run a grid or a Latin hypercube of parameters in closed loop.

    Takes the same study files as `warmlink tune`; their table [sweep] says `kind = "grid"` with so many
    `points` an axis, or `kind = "latin_hypercube"` with so many in all. Writes sweep.parquet, a row a run,
    and report.html. Interrupted or killed, the same command goes on.
    """
    from warmlink.orchestration.commands.sweep import sweep_command

    raise SystemExit(sweep_command(study, scheduler, jobs, fmus, out, report, as_json=json))


def design(
    system: Annotated[str, typer.Argument(help="`WarmupCell`, or an .ssp with one motor and one link.")],
    law: Annotated[str, typer.Option(help="`observer`, `observer_drift` or `regression`.")] = "observer",
    sensors: Annotated[
        str,
        typer.Option(help="Thermometers to go by: `shaft,winding,base,middle,tip`, any of them, or `none`."),
    ] = "base,tip",
    sensor_std: Annotated[str, typer.Option(help="Standard deviation of a thermometer's noise.")] = "0.1 K",
    camera_std: Annotated[
        str | None, typer.Option(help='That of the camera, as "0.2 um". Default: the DriftCamera\'s own.')
    ] = None,
    sample_time: Annotated[str, typer.Option(help="Time between two corrections.")] = "1 s",
    set_: Set = None,
    out: Annotated[Path | None, typer.Option(help="Parameter set to write. Default: LAW.ssv.")] = None,
    json: Json = False,
) -> None:
    """Work out a controller's gains for a system, as a parameter set (SSV) for the controller's FMU.

    The plant's parameters are those of the system's motor and link, and what --set says of these.

    Example: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`
    """
    from warmlink.orchestration.commands.design import design_command

    design_command(system, law, sensors, sensor_std, camera_std, sample_time, set_ or [], out, json)
