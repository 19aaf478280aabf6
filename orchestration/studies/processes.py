"""Workers that are processes: of this machine, or of a Dask cluster."""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing import connection
from typing import TYPE_CHECKING, Any

from warmlink.fmus.arguments import argument, count_given
from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.master.slaves.frames import DamagedError, Frames
from warmlink.orchestration.master.slaves.other_process import OtherProcess, ProcessEndedError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import FmuSet, attempt_all, groups, lane_of, seconds

if TYPE_CHECKING:
    from distributed import Client

DEFAULT_JOBS = 2
MOST_JOBS = 1024
"""Each is a process of some 100 MB; a typing error must not start a million of them."""

SOON_DONE_S = 0.5
"""What takes no longer is done before a process has begun."""

TASK_S, TASKS_A_WORKER = 0.5, 8
"""Time that a share of the cases takes, against some milliseconds that it costs in itself; how many shares
each worker has at least, so that all end together."""

ATTEMPTS = 3
"""Times that a run is tried whose worker dies, before it is recorded as the cause."""

CONNECT_TIMEOUT_S = 5.0
AHEAD = 2
"""Shares that a Dask worker's thread has before it, so that it never waits."""

Ended = Iterator[tuple[list[int], list[Outcome] | None]]
"""Places of the cases of a share, and their outcomes; None where its worker died."""


class _Processes:
    """Workers that take shares of the cases; what is common to all kinds. `count` tells how many they are."""

    rounds = ATTEMPTS

    def __init__(self, fmus: FmuSet, count: Callable[[], int]) -> None:
        self._fmus, self._count = fmus, count

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *raised: object) -> None:
        """End what the workers themselves began."""

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases, those of a worker that died again, each alone; InputError where that cannot go on."""
        tried = [self._shares(cases)]
        for _ in range(self.rounds):
            suspects: list[int] = []
            for shares in tried:
                for places, outcomes in self._ended(cases, shares):
                    if outcomes is None:
                        suspects += places
                    else:
                        yield from zip(places, outcomes, strict=True)
            tried = [[[place]] for place in suspects]
        for place in suspects:
            label = ", ".join(cases[place].label)
            yield place, Outcome(stopped=f"{label}: the worker died at each of {ATTEMPTS} attempts")

    def _shares(self, cases: Sequence[Case]) -> list[list[int]]:
        """Places of the cases in shares that are worth a task each, several for every worker."""
        needed = [seconds(case, self._fmus.rollouts) for case in cases]
        enough = min(TASK_S, sum(needed) / (TASKS_A_WORKER * self._count()))
        shares: list[list[int]] = []
        for together in groups(cases, self._fmus.rollouts):
            if not shares or sum(needed[place] for place in shares[-1]) >= enough:
                shares.append([])
            shares[-1] += together
        return shares

    def _ended(self, cases: Sequence[Case], shares: list[list[int]]) -> Ended:
        """Run shares of the cases, each once."""
        raise NotImplementedError


class LocalWorkers(_Processes):
    """Processes of this machine that are begun as cases need them, and ended with the `with` block.

    No thread of this process waits for them, so that Ctrl-C finds nothing that could hang; where the block
    is left by an exception, what they are at is cut short.
    """

    def __init__(self, fmus: FmuSet, jobs: int = DEFAULT_JOBS) -> None:
        super().__init__(fmus, lambda: count)
        count = check_jobs(jobs)
        self._idle: list[OtherProcess] = []

    def __exit__(self, *raised: object) -> None:
        while self._idle:
            self._idle.pop().end()

    def _ended(self, cases: Sequence[Case], shares: list[list[int]]) -> Ended:
        joined = all(lane_of(case, self._fmus.rollouts) is not None for case in cases)
        if joined and sum(seconds(case, self._fmus.rollouts) for case in cases) < SOON_DONE_S:
            for share in shares:
                yield share, attempt_all([cases[place] for place in share], self._fmus)
            return
        waiting, busy = shares[::-1], dict[Any, tuple[OtherProcess, list[int]]]()
        try:
            while waiting or busy:
                while waiting and len(busy) < self._count():
                    share = waiting.pop()
                    worker = self._idle.pop() if self._idle else self._begun()
                    busy[worker.pipe] = worker, share
                    # One that died meanwhile is found out when its outcome is read.
                    with suppress(ProcessEndedError):
                        worker.ask(pickle.dumps([cases[place] for place in share]))
                for ready in connection.wait(list(busy)):
                    worker, share = busy[ready]
                    outcomes: list[Outcome] | InputError | None = None
                    try:
                        outcomes = worker.answer(0.0)
                        if outcomes is None:  # it has begun
                            continue
                        self._idle.append(worker)
                    except (ProcessEndedError, DamagedError):
                        worker.end()
                    del busy[ready]
                    if isinstance(outcomes, InputError):
                        raise outcomes
                    yield share, outcomes
        finally:
            for worker, _ in busy.values():  # at cases whose results are no longer needed
                worker.end()

    def _begun(self) -> OtherProcess:
        return OtherProcess("worker", _work, self._fmus, classes=(Outcome,))


def check_jobs(jobs: int) -> int:
    """The number of processes; InputError where it is none."""
    return count_given("jobs", jobs, 1, MOST_JOBS, "processes")


def _work(pipe: Frames, fmus: FmuSet) -> None:
    """Run cases until the other end of the pipe is closed; they come as a pickle, outcomes go as frames."""
    with suppress(EOFError, OSError):
        while True:
            cases = pickle.loads(pipe.receive())
            try:
                outcomes: list[Outcome] | InputError = attempt_all(cases, fmus)
            except InputError as fault:
                outcomes = fault
            pipe.send(outcomes)


class ClusterWorkers(_Processes):
    """The workers of a Dask scheduler; they need warmlink installed and get the FMUs from here.

    The scheduler gives the share of a dead worker to another one. It blames a death on all that the worker
    had before it, so what is blamed too often is run once more, alone.
    """

    rounds = 2

    def __init__(self, fmus: FmuSet, client: Client) -> None:
        super().__init__(fmus, lambda: sum(client.nthreads().values()) or 1)
        self._client = client
        # A copy that a task makes, unlike scattered data, is made again when all that held it have died.
        self._shared: Any = self._client.submit(replace, fmus, pure=False)

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases as other workers do; whatever Dask raises becomes an InputError."""
        try:
            yield from super().run(cases)
        except InputError:  # a worker's own, as where its disk is full
            raise
        except Exception as fault:
            raise InputError(
                f"{argument('scheduler')}: the cluster was lost ({type(fault).__name__}); what is "
                "finished is kept, run again to go on"
            ) from fault

    def _ended(self, cases: Sequence[Case], shares: list[list[int]]) -> Ended:
        from distributed import KilledWorker, as_completed

        waiting, under_way = shares[::-1], dict[Any, list[int]]()
        ended = as_completed(loop=self._client.loop)
        while waiting or under_way:
            # A few at a time: all cases of a large study at once are more than a scheduler wants to hold.
            while waiting and len(under_way) <= AHEAD * self._count():
                share = waiting.pop()
                work = [cases[place] for place in share]
                task = self._client.submit(attempt_all, work, self._shared, pure=False)
                under_way[task.key] = share
                ended.add(task)
            future, outcomes = next(ended), None
            with suppress(KilledWorker):
                outcomes = future.result()
            yield under_way.pop(future.key), outcomes
            future.release()


def connected(address: str) -> Client:
    """Client of a Dask scheduler, a context; InputError where none answers, or it has no worker."""
    try:
        from distributed import Client
    except ImportError:
        raise MissingExtraError("a Dask cluster", "studies") from None
    # Dask tells of a slow start, and where a scheduler is lost, beside the sentence that is ours.
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as fault:
        raise InputError(
            f"{argument('scheduler', address)}: no Dask scheduler answers there; start one, or "
            "leave the scheduler out"
        ) from fault
    try:
        client.wait_for_workers(1, timeout=CONNECT_TIMEOUT_S)
    except Exception as fault:
        client.close()
        raise InputError(
            f"{argument('scheduler', address)}: the scheduler has no worker; start some"
        ) from fault
    return client
