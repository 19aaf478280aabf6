"""How fast studies go: closed-loop hours a second on processes of this machine and on a Dask cluster."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration import catalogue
from warmlink.orchestration.commands.console import remark
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.scenarios.closed_loop import cell_components
from warmlink.orchestration.scenarios.scenario import load_scenario
from warmlink.orchestration.studies.case import Case, case_of
from warmlink.orchestration.studies.cluster import ClusterWorkers
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.local import LocalWorkers
from warmlink.orchestration.studies.mismatch import draw
from warmlink.orchestration.studies.workers import Workers
from warmlink.orchestration.system.shipped import WARMUP_CELL

DUTY_CYCLES = ("windshield_wiper", "stop_and_go", "random_jobs", "pick_and_place_medium")


@dataclass(frozen=True)
class StudyTime:
    """Wall time of the same runs on some workers, their start included.

    `efficiency` is the time of one worker of the same kind over that of all, divided by their number; None
    where there is no such time.
    """

    workers: str
    count: int
    runs: int
    hours: float
    wall_seconds: float
    efficiency: float | None = None

    @property
    def hours_a_second(self) -> float:
        """Closed-loop hours a second of wall time."""
        return self.hours / self.wall_seconds


def cases_of(hours: float, controller: str) -> list[Case]:
    """Runs of at least so many closed-loop hours, each with thermal parameters of its own."""
    law = catalogue.controller(controller)
    declared = cell_components(law)
    duties = [load_scenario(name) for name in DUTY_CYCLES]
    rounds = math.ceil(hours / (sum(duty.stop_time for duty in duties) / 3600))
    return [
        case_of(
            replace(duty, parameters=draw(seed).applied(duty.parameters, declared)),
            law,
            (controller, duty.name, f"draw_{seed}"),
        )
        for seed in range(1, rounds + 1)
        for duty in duties
    ]


def bench_study(hours: float, controller: str, jobs: int, dask: bool) -> Iterator[StudyTime]:
    """Time the runs on local processes, and where asked on one and on two workers of a local Dask cluster.

    Raises
    ------
    InputError
        If there is no such controller, or the hours are not positive.
    """
    if not 0 < hours < 1e7:
        raise InputError(f"--hours {hours:g}: not an amount of work; give a number above 0")
    cases = cases_of(hours, controller)
    kinds = sorted(WARMUP_CELL.components_with(cases[0].law).values())
    chosen = store(None, kinds, remark)
    fmus = FmuSet.read(chosen.kind, chosen.files(kinds, remark))
    began = time.perf_counter()
    with LocalWorkers(fmus, jobs) as workers:
        yield _timed(f"{jobs} processes", jobs, cases, workers, began)
    if dask:
        alone = _on_dask(fmus, cases, 1)
        yield alone
        both = _on_dask(fmus, cases, 2)
        yield replace(both, efficiency=alone.wall_seconds / (2 * both.wall_seconds))


def times_table(times: list[StudyTime]) -> str:
    """The times as text."""
    lines = [f"{'':<22}{'runs':>7}{'hours':>9}{'s':>9}{'hours/s':>10}{'efficiency':>13}"]
    for each in times:
        share = "" if each.efficiency is None else f"{each.efficiency:.2f}"
        lines.append(
            f"{each.workers:<22}{each.runs:>7}{each.hours:>9.0f}{each.wall_seconds:>9.1f}"
            f"{each.hours_a_second:>10.1f}{share:>13}".rstrip()
        )
    return "\n".join(lines)


def _on_dask(fmus: FmuSet, cases: list[Case], count: int) -> StudyTime:
    with local_cluster(count) as address, ClusterWorkers(fmus, address) as workers:
        # The workers' own start is the cluster's, which stands before any study.
        list(workers.run(cases[: 2 * count]))
        return _timed(f"Dask, {count} workers", count, cases, workers, time.perf_counter())


@contextmanager
def local_cluster(count: int) -> Iterator[str]:
    """Address of a Dask scheduler on this machine with so many workers of one thread each."""
    try:
        from distributed import LocalCluster
    except ImportError:
        raise MissingExtraError("a Dask cluster", "studies") from None
    cluster: Any = LocalCluster(
        n_workers=count, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    )
    with cluster:
        yield str(cluster.scheduler_address)


def _timed(name: str, count: int, cases: list[Case], workers: Workers, began: float) -> StudyTime:
    stopped = [outcome.stopped for _, outcome in workers.run(cases) if outcome.stopped is not None]
    if stopped:
        raise InputError(f"{len(stopped)} runs stopped early, the first because of: {stopped[0]}")
    took = time.perf_counter() - began
    return StudyTime(name, count, len(cases), sum(case.hours for case in cases), took)
