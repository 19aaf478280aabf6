"""How fast studies go: closed-loop hours a second on processes of this machine and on a Dask cluster."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import typer

from benchmarks.command import start
from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import answer, answer_json, remark
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.scenarios.mismatch import NOMINAL, draw, load
from warmlink.orchestration.studies.case import Case, case_of
from warmlink.orchestration.studies.joined import agreeing, joined_systems
from warmlink.orchestration.studies.processes import ClusterWorkers, LocalWorkers, connected
from warmlink.orchestration.studies.workers import FmuSet, Workers

DUTY_CYCLES = ("windshield_wiper", "stop_and_go", "random_jobs", "pick_and_place_medium")


@dataclass(frozen=True)
class StudyTime:
    """Wall time of the same runs on some workers, the start of local ones included.

    `cpu_seconds` is what this process and the workers computed, a Dask cluster's own start included: on cores
    that nothing else uses, the wall time is that, divided by the number of workers. `efficiency` is the wall
    time of one worker of the same kind over that of all, divided by their number; None where there is no such
    time. It means something on a machine that does nothing else.
    """

    workers: str
    count: int
    runs: int
    hours: float
    wall_seconds: float
    cpu_seconds: float | None
    efficiency: float | None = None

    @property
    def hours_a_second(self) -> float:
        """Closed-loop hours a second of wall time."""
        return self.hours / self.wall_seconds


def cases_of(hours: float, controller: str) -> list[Case]:
    """Runs of at least so many closed-loop hours, each with thermal parameters of its own."""
    law = catalogue.shipped(controller)
    duties = [load_scenario(name) for name in DUTY_CYCLES]
    rounds = math.ceil(hours / (sum(duty.stop_time for duty in duties) / 3600))
    return [
        case_of(
            replace(duty, controller=law).mismatched(draw(seed)),
            (controller, duty.name, f"draw_{seed}"),
        )
        for seed in range(1, rounds + 1)
        for duty in duties
    ]


def bench_study(hours: float, controller: str, jobs: int, dask: bool, exact: bool) -> Iterator[StudyTime]:
    """Time the runs on local processes, and where asked on one and on two workers of a local Dask cluster.

    They go side by side in the joined system, unless the FMUs themselves are asked for.

    Raises
    ------
    InputError
        If there is no such controller, or the hours are not positive.
    """
    if not 0 < hours < 1e7:
        raise InputError(f"--hours {hours:g}: not an amount of work; give a number above 0")
    cases = cases_of(hours, controller)
    kinds = sorted(WARMUP_CELL.parts_with(cases[0].law).values())
    chosen = store(None, kinds, remark)
    fmus = FmuSet.read(chosen.kind, chosen.files(kinds, remark))
    if not exact:
        duties = [
            replace(load_scenario(name), controller=catalogue.shipped(controller)) for name in DUTY_CYCLES
        ]
        joined = replace(fmus, rollouts=joined_systems(duties, remark))
        fmus = agreeing([each.mismatched(load(NOMINAL)) for each in duties], joined, remark)
    wall, cpu = time.perf_counter(), _cpu_seconds()
    with LocalWorkers(fmus, jobs) as workers:
        timed = _timed(f"{jobs} processes", jobs, cases, workers, wall)
    # The workers' time counts once they have ended.
    yield replace(timed, cpu_seconds=_since(cpu))
    if dask:
        alone = _on_dask(fmus, cases, 1)
        yield alone
        both = _on_dask(fmus, cases, 2)
        yield replace(both, efficiency=alone.wall_seconds / (2 * both.wall_seconds))


def times_table(times: list[StudyTime]) -> str:
    """The times as text."""
    lines = [f"{'':<22}{'runs':>7}{'hours':>9}{'s':>9}{'hours/s':>10}{'CPU s':>9}{'efficiency':>13}"]
    for each in times:
        cpu = "" if each.cpu_seconds is None else f"{each.cpu_seconds:.1f}"
        share = "" if each.efficiency is None else f"{each.efficiency:.2f}"
        lines.append(
            f"{each.workers:<22}{each.runs:>7}{each.hours:>9.0f}{each.wall_seconds:>9.1f}"
            f"{each.hours_a_second:>10.1f}{cpu:>9}{share:>13}".rstrip()
        )
    return "\n".join(lines)


def _on_dask(fmus: FmuSet, cases: list[Case], count: int) -> StudyTime:
    cpu = _cpu_seconds()
    with (
        local_cluster(count) as address,
        connected(address) as client,
        ClusterWorkers(fmus, client) as workers,
    ):
        # The workers' own start is the cluster's, which stands before any study.
        list(workers.run(cases[: 2 * count]))
        timed = _timed(f"Dask, workers: {count}", count, cases, workers, time.perf_counter())
    return replace(timed, cpu_seconds=_since(cpu))


@contextmanager
def local_cluster(count: int) -> Iterator[str]:
    """Address of a Dask scheduler on this machine with so many workers of one thread each."""
    try:
        from distributed import LocalCluster
    except ImportError:
        raise MissingExtraError("a Dask cluster", "studies") from None
    cluster: Any = LocalCluster(
        n_workers=count, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    )
    with cluster:
        yield str(cluster.scheduler_address)


def _timed(name: str, count: int, cases: list[Case], workers: Workers, began: float) -> StudyTime:
    stopped = [outcome.stopped for _, outcome in workers.run(cases) if outcome.stopped is not None]
    if stopped:
        raise InputError(f"{len(stopped)} runs stopped early, the first because of: {stopped[0]}")
    took = time.perf_counter() - began
    return StudyTime(name, count, len(cases), sum(case.work_hours for case in cases), took, None)


def _cpu_seconds() -> float | None:
    """CPU time of this process and of those of its children that have ended; None where it is not told."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _since(before: float | None) -> float | None:
    now = _cpu_seconds()
    return None if now is None or before is None else now - before


def main(
    hours: Annotated[float, typer.Option(help="Closed-loop hours to simulate.")] = 2000,
    controller: Annotated[str, typer.Option(help="Controller in the loop.")] = "lag",
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 2,
    dask: Annotated[bool, typer.Option(help="Also on one and two workers of a local Dask cluster.")] = False,
    exact: Annotated[bool, typer.Option("--exact", help="Run the FMUs, not the joined system.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Print how many closed-loop hours per second a study does on this machine."""
    times = list(bench_study(hours, controller, jobs, dask, exact))
    if json:
        answer_json([{**asdict(each), "hours_a_second": each.hours_a_second} for each in times])
    else:
        answer(times_table(times))


if __name__ == "__main__":
    start(main)
