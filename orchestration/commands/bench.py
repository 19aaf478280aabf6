"""`warmlink bench`: times side by side, as measured in this run on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.commands.console import answer, answer_json, progress_bar


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


def bench_masters_command(rounds: int, as_json: bool) -> None:
    """Print our master beside other people's; each case when it is done."""
    import sys
    from dataclasses import asdict

    from warmlink.orchestration.bench.masters import Extent, absent, bench_masters, masters_table
    from warmlink.orchestration.bench.whole_run import bench_whole_run
    from warmlink.orchestration.commands.console import remark

    told = remark if sys.stderr.isatty() else (lambda name: None)
    found = []
    for rows in bench_masters(Extent(rounds=rounds), told):
        found += rows
        if not as_json:
            answer(masters_table(rows) + "\n")
    whole = bench_whole_run(rounds)
    if as_json:
        answer_json({"rows": [asdict(row) for row in found], **asdict(whole), "not_installed": absent()})
        return
    answer(f"{whole}\n")
    answer("off by: from motor and link solved as one system of equations (BDF, tolerance 1e-11)")
    for name, packages in absent().items():
        answer(f"not installed: {name} ({', '.join(packages)})")


def bench_scale_command(as_json: bool) -> None:
    """Print the time of a macro step of arms with more and more axes, and that of an 8-hour shift."""
    from dataclasses import asdict

    from warmlink.orchestration.bench.scale import bench_scale, scale_table

    found = list(bench_scale())
    if as_json:
        answer_json(
            [
                {
                    **asdict(each),
                    "us_per_step_and_component": each.us_per_step_and_component,
                    "us_per_step_and_axis": each.us_per_step_and_axis,
                }
                for each in found
            ]
        )
    else:
        answer(scale_table(found))


def bench_laws_command(share: float, seed: int, jobs: int, as_json: bool) -> None:
    """Run the observers through fresh trials, and print what came of them."""
    from dataclasses import asdict

    from warmlink.orchestration.bench.laws import Counts, bench_laws, laws_table

    with progress_bar("Observers") as progress:
        trials = bench_laws(Counts().shared(positive_share(share)), seed, jobs, progress)
    if as_json:
        answer_json([asdict(trial) for trial in trials])
        return
    answer(laws_table(trials))
    answer(f"seed {seed}")


def positive_share(share: float) -> float:
    """The share of the full counts asked for.

    Raises
    ------
    InputError
        If it is none.
    """
    if not 0 < share <= 1:
        raise InputError(f"--share: {share:g} is not a share; give a number above 0, at most 1")
    return share


def bench_diagnosis_command(share: float, seed: int, jobs: int, out: Path, as_json: bool) -> None:
    """Hide effects in fresh runs, diagnose them, and print how often that was right."""
    from warmlink.orchestration.diagnosis.bench import FULL, bench_diagnosis

    share = positive_share(share)
    counts = {kind: max(1, round(share * count)) for kind, count in FULL.items()}
    with progress_bar("Hidden effects") as progress:
        bench = bench_diagnosis(counts, seed, jobs, lambda done, total: progress(done / total), out)
    bench.write(out)
    if as_json:
        answer_json(bench.table())
        return
    _print_shares(bench.table())
    answer(f"seed {seed}; confusion matrix and every trial in {out}")


_SHARES = {
    "right": "right_percent",
    "wrong": "wrong_name_percent",
    "95 %": "in_interval_percent",
    "held": "heldout_within_10_percent",
    "next": "next_experiment_right_percent",
    "said": "next_experiment_as_said_percent",
}
"""Columns of the table in the terminal, which all are shares in percent."""


def _print_shares(rows: list[dict[str, Any]]) -> None:
    answer(f"{'':<33}{'runs':>5}" + "".join(f"{heading:>7}" for heading in _SHARES) + f"{'s':>6}")
    for row in rows:
        shares = [row[name] for name in _SHARES.values()]
        cells = "".join(f"{'-' if share is None else f'{share:.1f}':>7}" for share in shares)
        answer(f"{row['kind']:<33}{row['runs']:>5}{cells}{row['seconds']:>6.2f}")
    answer(
        "in %: right or in the stated set; wrong name; strength in its 95 % interval; held-out error\n"
        "within 10 % of the noise; next experiment led to the right name; or did what it said it can.\n"
        "s: processor time of a search"
    )
