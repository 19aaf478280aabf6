"""Processes that run cases: the one interface of those on this machine and those of a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.orchestration.files import FULL_DISK
from warmlink.orchestration.studies.case import Case, Outcome, failed, run_case
from warmlink.orchestration.studies.cores import joined
from warmlink.orchestration.studies.cores.joined import lane_of
from warmlink.orchestration.studies.fmu_set import FmuSet

DEFAULT_JOBS = 2

ATTEMPTS = 3
"""Times that a run is tried whose worker dies, before it is recorded as the cause."""


class Workers(Protocol):
    """Whoever runs cases."""

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases and give each one's place and outcome, in the order in which they end.

        A run that stops, or whose worker dies each time, has an outcome that says why; a worker that dies
        once loses nothing. InputError where the workers cannot go on.
        """


_KEPT = "the finished runs are kept, and the same command continues"


def attempt_all(cases: Sequence[Case], fmus: FmuSet) -> list[Outcome]:
    """Run cases in this process: side by side where they have a joined system, else one by one on FMUs."""
    outcomes: dict[int, Outcome | None] = {}
    for places in side_by_side(cases, fmus):
        mine = [cases[place] for place in places]
        rollout = None if lane_of(mine[0], fmus.rollouts) is None else fmus.rollouts[mine[0].law]
        found = [None] * len(mine) if rollout is None else joined.outcomes(mine, rollout)
        outcomes |= zip(places, found, strict=True)
    return [outcomes[place] or attempt(case, fmus) for place, case in enumerate(cases)]


def attempt(case: Case, fmus: FmuSet) -> Outcome:
    """Run a case on FMUs; what goes wrong is the outcome's reason, but a full disk a NoRoomError."""
    try:
        return run_case(case, fmus.files(), fmus.unpacked)
    except NoRoomError as fault:
        raise NoRoomError(f"{fault}; {_KEPT}") from None
    except InputError as fault:
        return failed(str(fault))
    except OSError as fault:
        if fault.errno in FULL_DISK:
            where = fault.filename or "a temporary file"
            raise NoRoomError(f"{where}: cannot be written ({fault.strerror}); free space; {_KEPT}") from None
        return failed(f"{type(fault).__name__}: {fault}")
    except Exception as fault:
        return failed(f"{type(fault).__name__}: {fault}")


def side_by_side(cases: Sequence[Case], fmus: FmuSet) -> list[list[int]]:
    """Places of the cases in shares that run together, longest run first: one on FMUs, several where joined.

    Longest first, so that no worker begins a long one when the others end.
    """
    shares: list[list[int]] = []
    open_share: dict[object, list[int]] = {}
    for place in sorted(range(len(cases)), key=lambda i: (-cases[i].hours, i)):
        lane = lane_of(cases[place], fmus.rollouts)
        share = open_share.get(lane) if lane is not None else None
        if share is None:
            open_share[lane] = share = []
            shares.append(share)
        share.append(place)
        if lane is not None and len(share) == fmus.rollouts[cases[place].law].lanes:
            del open_share[lane]
    return shares


def died(case: Case) -> Outcome:
    """Outcome of a case whose worker died at every attempt."""
    return failed(f"{', '.join(case.label)}: the worker died at each of {ATTEMPTS} attempts")
