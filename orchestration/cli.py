"""The command `warmlink`: parse, call, print."""

from __future__ import annotations

import os
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

bench = typer.Typer(help="Time things side by side, on this machine in this run.", no_args_is_help=True)
app.add_typer(bench, name="bench")

BAD_INPUT = 2

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, for machines.")]


def main() -> None:
    """Entry point of the command: bad input ends in one sentence and exit code 2."""
    # The matrices are small: threads of one product wait for each other longer than they work. NumPy
    # reads this once, when it is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
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
        checkpoint,
        resume,
        real_time,
        error_budget,
        tuple(watch or ()),
    )
    raise SystemExit(simulate_command(options, json))


@app.command()
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

    Writes compare.csv and report.html. Differences within the error budget count as equal; where a duty cycle
    defeats a law, the table says so.

    Example: `warmlink compare --controllers lag,observer --duty-cycles stop_and_go --mismatch nominal`
    """
    from warmlink.orchestration.commands.compare import compare_command

    raise SystemExit(
        compare_command(
            system, controllers, duty_cycles, mismatch, with_ or [], fmus, out, jobs, report, as_json=json
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
_StudyOut = Annotated[Path | None, typer.Option(help="Folder for results. Default: out/STUDY.")]
_Report = Annotated[bool, typer.Option(help="Write report.html.")]


@app.command()
def tune(
    study: Annotated[str, typer.Argument(help=_STUDY_HELP)],
    trials: Annotated[int | None, typer.Option(help="How many trials. Default: the study's.")] = None,
    scheduler: _Scheduler = None,
    jobs: _Jobs = 2,
    fmus: _Fmus = None,
    out: _StudyOut = None,
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


@app.command()
def sweep(
    study: Annotated[str, typer.Argument(help=_STUDY_HELP)],
    scheduler: _Scheduler = None,
    jobs: _Jobs = 2,
    fmus: _Fmus = None,
    out: _StudyOut = None,
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


@app.command()
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
    out: Annotated[Path | None, typer.Option(help="Parameter set to write. Default: LAW.ssv.")] = None,
    json: Json = False,
) -> None:
    """Work out a controller's gains for a system, as a parameter set (SSV) for the controller's FMU.

    The plant's parameters are those of the system's motor and link.

    Example: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`
    """
    from warmlink.orchestration.commands.design import design_command

    design_command(system, law, sensors, sensor_std, camera_std, sample_time, out, json)


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="An .fmu or .ssp file, anybody's.")], json: Json = False
) -> None:
    """Check an FMU or a system as an integrator would; exit code 1 where a check fails."""
    from warmlink.orchestration.commands.check import check_command

    raise SystemExit(check_command(file, json))


@app.command()
def diagnose(
    data: Annotated[
        Path, typer.Argument(help="A measured run (CSV) of the warm-up cell, or an experiment (TOML).")
    ],
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/NAME.")] = None,
    json: Json = False,
) -> None:
    """Show what the simulation gets wrong, name the cause, extend the model, measure the improvement.

    Writes diagnosis.json, report.html and the extended model as .ssv and .ssp. Any verdict is exit code 0.
    """
    from warmlink.orchestration.commands.diagnose import diagnose_command

    diagnose_command(data, out, json)


@app.command()
def hide(
    effects: Annotated[
        list[str] | None,
        typer.Argument(
            help="Effects to hide, as radiation, joint_resistance=0.3, sensor_lag:tip_temperature."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="CSV file to write.")] = Path("run.csv"),
    seed: Annotated[int, typer.Option(help="Seed of the noise.")] = 0,
    noise: Annotated[
        str, typer.Option(help="`white`, or `real`: correlated, rounded, with spikes.")
    ] = "white",
) -> None:
    """Make a measured run with a hidden effect, from a solver of its own, to practise `diagnose` on."""
    from warmlink.orchestration.commands.diagnose import hide_command

    hide_command(effects or [], out, seed, noise)


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("out/reproduce"),
    json: Json = False,
) -> None:
    """Compute the paper's tables and figures: Eq. (4), the 1-D link and 3-D finite elements beside them."""
    from warmlink.orchestration.commands.reproduce import reproduce_command

    reproduce_command(out, json)


@bench.command(name="study")
def bench_study(
    hours: Annotated[float, typer.Option(help="Closed-loop hours to simulate.")] = 2000,
    controller: Annotated[str, typer.Option(help="Controller in the loop.")] = "lag",
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    dask: Annotated[bool, typer.Option(help="Also on one and two workers of a local Dask cluster.")] = False,
    json: Json = False,
) -> None:
    """Print how many closed-loop hours a second a study does on this machine."""
    from warmlink.orchestration.commands.bench import bench_study_command

    bench_study_command(hours, controller, jobs, dask, json)


@app.command(name="list")
def list_(json: Json = False) -> None:
    """List what warmlink knows: scenarios, controllers, systems, components, mismatches, studies, masters."""
    from warmlink.orchestration.commands.catalogue import list_command

    list_command(json)


@bench.command(name="diagnosis")
def bench_diagnosis(
    share: Annotated[float, typer.Option(help="Share of the full counts, 400 runs of a kind at most.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    out: Annotated[Path, typer.Option(help="Folder for the tables.")] = Path("out/bench_diagnosis"),
    json: Json = False,
) -> None:
    """Hide effects in fresh runs and count how often the diagnosis is right: shares and confusion matrix."""
    from warmlink.orchestration.commands.bench import bench_diagnosis_command

    bench_diagnosis_command(share, seed, jobs, out, json)


@bench.command(name="scale")
def bench_scale(json: Json = False) -> None:
    """Time arms of 1, 2, 6, 12 and 24 axes a macro step, and an 8-hour shift of six axes."""
    from warmlink.orchestration.commands.bench import bench_scale_command

    bench_scale_command(json)


@bench.command(name="fmus")
def bench_fmus(json: Json = False) -> None:
    """Time one communication step of each component: native FMU, Python FMU, bare C loop."""
    from warmlink.orchestration.commands.bench import bench_fmus_command

    bench_fmus_command(json)


@bench.command(name="masters")
def bench_masters(
    rounds: Annotated[int, typer.Option(help="Runs of each; the best counts.")] = 2, json: Json = False
) -> None:
    """Time our master beside FMPy's loop, libcosim, Ecos and what else is installed, on the same FMUs.

    Three trivial FMUs of C with five connections, then an hour of the warm-up cell with native and with
    Python FMUs: time of a communication step and of the whole process, elongation, and what it is off by.
    """
    from warmlink.orchestration.commands.bench import bench_masters_command

    bench_masters_command(rounds, json)


if __name__ == "__main__":
    main()
