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
