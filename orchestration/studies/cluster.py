"""Workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Any

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.workers import attempt, died, longest_first

CONNECT_TIMEOUT_S = 5.0


class ClusterWorkers:
    """The workers of a scheduler, which need warmlink installed and get the FMUs from here.

    Parameters
    ----------
    fmus : what the cases run on
    address : of the scheduler, as `tcp://10.0.0.1:8786`

    Raises
    ------
    InputError
        If there is no scheduler at the address, or it has no worker.
    """

    def __init__(self, fmus: FmuSet, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise MissingExtraError("a Dask cluster", "studies") from None
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
        self._fmus: Any = self._client.scatter(fmus, broadcast=True, hash=False)

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases; the scheduler gives those of a dead worker to another one."""
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        order = longest_first(cases)
        futures = self._client.map(attempt, [cases[i] for i in order], fmus=self._fmus, pure=False)
        places = {future.key: place for future, place in zip(futures, order, strict=True)}
        for future in as_completed(futures, loop=self._client.loop):
            place = places[future.key]
            try:
                outcome = future.result()
            except KilledWorker:
                outcome = died(cases[place])
            except Exception as fault:
                raise InputError(
                    f"--scheduler: the cluster was lost ({type(fault).__name__}); what is finished is kept, "
                    "run again to go on"
                ) from fault
            yield place, outcome
            future.release()
