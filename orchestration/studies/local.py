"""Workers that are processes of this machine."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.workers import (
    ATTEMPTS,
    DEFAULT_JOBS,
    attempt,
    died,
    longest_first,
    prepare_stepping,
)

_fmus: FmuSet | None = None


class LocalWorkers:
    """A pool of processes, begun with the first case and ended with the `with` block.

    Parameters
    ----------
    fmus : what the cases run on
    jobs : how many processes
    """

    def __init__(self, fmus: FmuSet, jobs: int = DEFAULT_JOBS) -> None:
        if jobs < 1:
            raise InputError(f"--jobs {jobs}: not a number of processes; give 1 or more")
        self._fmus, self._jobs = fmus, jobs
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases; those under way when a worker died are run again, one at a time."""
        suspects: list[int] = []
        waiting = longest_first(cases)
        while waiting:
            futures: dict[Future[Outcome], int] = {}
            try:
                yield from self._shared(cases, waiting, futures)
            except BrokenProcessPool:
                self._close()
                # Only those that a worker may have held are suspect, which are the first unfinished ones.
                suspects += waiting[: self._jobs + 1]
                del waiting[: self._jobs + 1]
        for place in suspects:
            yield place, self._alone(cases[place])

    def _shared(
        self, cases: Sequence[Case], waiting: list[int], futures: dict[Future[Outcome], int]
    ) -> Iterator[tuple[int, Outcome]]:
        """Run what waits, taking it off the list as it ends."""
        pool, submitted = self._open(), 0
        while waiting:
            # Few at a time, so that a death leaves few under suspicion.
            while submitted < len(waiting) and len(futures) <= self._jobs:
                futures[pool.submit(_attempt, cases[waiting[submitted]])] = waiting[submitted]
                submitted += 1
            for future in wait(futures, return_when=FIRST_COMPLETED).done:
                outcome = future.result()
                place = futures.pop(future)
                waiting.remove(place)
                submitted -= 1
                yield place, outcome

    def _alone(self, case: Case) -> Outcome:
        for _ in range(ATTEMPTS - 1):
            try:
                return self._open().submit(_attempt, case).result()
            except BrokenProcessPool:
                self._close()
        return died(case)

    def _open(self) -> ProcessPoolExecutor:
        if self._pool is None:
            # Spawned, since a fork would inherit FMUs and threads of whoever calls.
            spawn = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self._jobs, spawn, _begin, (self._fmus,))
        return self._pool

    def _close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


def _begin(fmus: FmuSet) -> None:
    """Make a process a worker."""
    global _fmus
    _fmus = fmus
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    # Ctrl-C at the terminal is for the parent: a run that it cut short would look like one that failed.
    if hasattr(os, "setsid"):
        with contextlib.suppress(OSError):
            os.setsid()
    prepare_stepping()


def _end_with(parent: multiprocessing.process.BaseProcess) -> None:
    parent.join()
    os._exit(1)


def _attempt(case: Case) -> Outcome:
    assert _fmus is not None
    return attempt(case, _fmus)
