"""Workers that are processes of this machine."""

from __future__ import annotations

import multiprocessing
import signal
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import connection, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from types import ModuleType
from typing import NamedTuple

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves.isolation import die_with_parent
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import (
    ATTEMPTS,
    DEFAULT_JOBS,
    FmuSet,
    attempt_all,
    died,
    lane_of,
    side_by_side,
)

MOST_JOBS = 1024
"""Each is a process of some 100 MB; a typing error must not start a million of them."""


SOON_DONE_HOURS = 500.0
"""Closed-loop hours that joined systems simulate in about a second."""


class _Worker(NamedTuple):
    """A process and the pipe through which it takes shares of the cases and gives outcomes."""

    process: SpawnProcess
    pipe: Connection


class LocalWorkers:
    """Processes that are begun as cases need them, and ended with the `with` block.

    No thread of this process waits for them, so that Ctrl-C finds nothing that could hang; where the block
    is left by an exception, what they are at is cut short.
    """

    def __init__(self, fmus: FmuSet, jobs: int = DEFAULT_JOBS) -> None:
        check_jobs(jobs)
        self._fmus, self._jobs = fmus, jobs
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, list[int]]] = {}

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(self, *raised: object) -> None:
        self._cut_short()
        for worker in self._idle:
            worker.pipe.close()
        for worker in self._idle:
            worker.process.join()
        self._idle.clear()

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases; that of a worker that died is run again, by another one; InputError on a full disk."""
        waiting = side_by_side(cases, self._fmus)[::-1]
        if self._soon_done(cases):
            for share in waiting[::-1]:
                yield from zip(share, attempt_all([cases[i] for i in share], self._fmus), strict=True)
            return
        deaths: Counter[int] = Counter()
        try:
            while waiting or self._busy:
                while waiting and len(self._busy) < self._jobs:
                    self._give(waiting.pop(), cases)
                for pipe in connection.wait(list(self._busy)):
                    assert isinstance(pipe, Connection)
                    worker, share = self._busy[pipe]
                    outcomes: list[Outcome] | InputError | None = None
                    try:
                        outcomes = pipe.recv()
                        self._idle.append(worker)
                    except (EOFError, OSError):
                        _end(worker)
                        deaths[share[0]] += 1
                    del self._busy[pipe]
                    if outcomes is None and deaths[share[0]] < ATTEMPTS:
                        waiting.append(share)
                        continue
                    if isinstance(outcomes, InputError):
                        raise outcomes
                    yield from zip(share, outcomes or [died(cases[i]) for i in share], strict=True)
        finally:
            self._cut_short()

    def _soon_done(self, cases: Sequence[Case]) -> bool:
        """Whether joined systems do it before a process has begun."""
        joined = all(lane_of(case, self._fmus.rollouts) is not None for case in cases)
        return joined and sum(case.hours for case in cases) < SOON_DONE_HOURS

    def _give(self, share: list[int], cases: Sequence[Case]) -> None:
        worker = self._idle.pop() if self._idle else self._begun()
        self._busy[worker.pipe] = (worker, share)
        # One that died meanwhile is found out when its outcome is read.
        with suppress(BrokenPipeError, ConnectionResetError):
            worker.pipe.send([cases[place] for place in share])

    def _begun(self) -> _Worker:
        here, there = multiprocessing.Pipe()
        # Spawned, since a fork would inherit FMUs and threads of whoever calls; a daemon, since such a one is
        # ended with this process however it ends.
        process = multiprocessing.get_context("spawn").Process(
            target=_work, args=(there, self._fmus), daemon=True
        )
        with _no_interrupts(), without_main():
            process.start()
        there.close()
        return _Worker(process, here)

    def _cut_short(self) -> None:
        """End the workers that are at a case of which nobody wants to hear any more."""
        for worker, _ in self._busy.values():
            _end(worker)
        self._busy.clear()


def check_jobs(jobs: int) -> None:
    """Raise InputError where `jobs` is no number of processes."""
    if not 1 <= jobs <= MOST_JOBS:
        raise InputError(f"--jobs {jobs}: not a number of processes; give 1 to {MOST_JOBS}")


def _end(worker: _Worker) -> None:
    worker.process.kill()
    worker.process.join()
    worker.pipe.close()


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C at the terminal does not reach: it is for the parent to end them."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # which would set the mask back
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def without_main() -> Iterator[None]:
    """Keep a new process from running the script of whoever calls once more: it needs nothing of it."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _work(pipe: Connection, fmus: FmuSet) -> None:
    """Run cases until the other end of the pipe is closed."""
    die_with_parent()
    with suppress(EOFError, OSError):
        while True:
            cases = pipe.recv()
            try:
                outcomes: list[Outcome] | InputError = attempt_all(cases, fmus)
            except InputError as fault:
                outcomes = fault
            pipe.send(outcomes)
