"""Benches: masters, FMUs, studies, scale, laws, diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line.options import Json

bench = typer.Typer(help="Time things side by side, on this machine in this run.", no_args_is_help=True)


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


@bench.command(name="fmus")
def bench_fmus(json: Json = False) -> None:
    """Time one communication step of each component: native FMU, Python FMU, bare C loop."""
    from warmlink.orchestration.commands.bench import bench_fmus_command

    bench_fmus_command(json)


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


@bench.command(name="scale")
def bench_scale(json: Json = False) -> None:
    """Time arms of 1, 2, 6, 12 and 24 axes a macro step, and an 8-hour shift of six axes."""
    from warmlink.orchestration.commands.bench import bench_scale_command

    bench_scale_command(json)


@bench.command(name="laws")
def bench_laws(
    share: Annotated[
        float, typer.Option(help="Share of the full counts, 1,000 runs with a fault a law.")
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of all random choices; another one gives fresh runs.")] = 0,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    json: Json = False,
) -> None:
    """Count how far the observers can be trusted: wrong models, honest deviations, failing sensors."""
    from warmlink.orchestration.commands.bench import bench_laws_command

    bench_laws_command(share, seed, jobs, json)


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
