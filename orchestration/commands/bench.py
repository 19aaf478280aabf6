"""`warmlink bench`: times side by side, as measured in this run on this machine."""

from __future__ import annotations

from warmlink.orchestration.commands.console import answer, answer_json


def bench_fmus_command(as_json: bool) -> None:
    """Print the time of a step of each component, native and Python."""
    from dataclasses import asdict

    from warmlink.orchestration.bench.fmus import bench_fmus, times_table

    times = list(bench_fmus())
    if as_json:
        answer_json([asdict(each) for each in times])
    else:
        answer(times_table(times))


def bench_study_command(hours: float, controller: str, jobs: int, dask: bool, as_json: bool) -> None:
    """Print how many closed-loop hours a second a study does."""
    from dataclasses import asdict

    from warmlink.orchestration.bench.study import bench_study, times_table

    times = list(bench_study(hours, controller, jobs, dask))
    if as_json:
        answer_json([{**asdict(each), "hours_a_second": each.hours_a_second} for each in times])
    else:
        answer(times_table(times))
