"""Workers of a Dask cluster."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import FmuSet, attempt_all, died, side_by_side

CONNECT_TIMEOUT_S = 5.0

TASK_HOURS = 25.0
"""Closed-loop hours of a task: about half a second, against some milliseconds that a task costs in itself."""

TASKS_A_THREAD = 8
"""Tasks that a thread should have at least, so that all end together."""


class ClusterWorkers:
    """The workers of a scheduler at an address; they need warmlink installed and get the FMUs from here."""

    def __init__(self, fmus: FmuSet, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise MissingExtraError("a Dask cluster", "studies") from None
        # Where a scheduler is lost, threads of the client print tracebacks beside the error that is raised.
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
        try:
            self._client = Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as fault:
            raise InputError(
                f"--scheduler {address}: no Dask scheduler answers there; start one, or leave --scheduler out"
            ) from fault
        try:
            self._client.wait_for_workers(1, timeout=CONNECT_TIMEOUT_S)
        except Exception as fault:
            self._client.close()
            raise InputError(f"--scheduler {address}: the scheduler has no worker; start some") from fault
        self._set = fmus
        # A task, unlike scattered data, is done again when every worker that held its result has died.
        self._fmus: Any = self._client.submit(_itself, fmus, pure=False)

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(self, *raised: object) -> None:
        self._client.close()

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases; the scheduler gives those of a dead worker to another one.

        It blames a death on all that the worker had before it, so what is blamed too often is run once more,
        alone.
        """
        suspects: list[int] = []
        with _told_when_lost():
            for places, outcomes in self._ended(cases, self._shares(cases)):
                if outcomes is None:
                    suspects += places
                else:
                    yield from zip(places, outcomes, strict=True)
            for suspect in suspects:
                for _, outcomes in self._ended(cases, [[suspect]]):
                    yield suspect, died(cases[suspect]) if outcomes is None else outcomes[0]

    def _shares(self, cases: Sequence[Case]) -> list[list[int]]:
        """Places of the cases in shares that are worth a task each, several for every worker."""
        total = sum(case.hours for case in cases)
        threads = sum(self._client.nthreads().values()) or 1
        enough = min(TASK_HOURS, total / (TASKS_A_THREAD * threads))
        shares: list[list[int]] = []
        hours = enough
        for together in side_by_side(cases, self._set):
            if hours >= enough:
                shares.append([])
                hours = 0.0
            shares[-1] += together
            hours += sum(cases[place].hours for place in together)
        return shares

    def _ended(
        self, cases: Sequence[Case], shares: Sequence[list[int]]
    ) -> Iterator[tuple[list[int], list[Outcome] | None]]:
        """Run shares of the cases; None are the outcomes of one that was blamed for deaths."""
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        work = [[cases[place] for place in share] for share in shares]
        futures = self._client.map(attempt_all, work, fmus=self._fmus, pure=False)
        share_of = {future.key: share for future, share in zip(futures, shares, strict=True)}
        for future in as_completed(futures, loop=self._client.loop):
            try:
                outcomes: list[Outcome] | None = future.result()
            except KilledWorker:
                outcomes = None
            yield share_of[future.key], outcomes
            future.release()


@contextmanager
def _told_when_lost() -> Iterator[None]:
    """Turn whatever Dask raises into an InputError."""
    try:
        yield
    except InputError:  # a worker's own, as where its disk is full
        raise
    except Exception as fault:
        raise InputError(
            f"--scheduler: the cluster was lost ({type(fault).__name__}); what is finished is kept, "
            "run again to go on"
        ) from fault


def _itself(fmus: FmuSet) -> FmuSet:
    return fmus
