"""What runs the cases of a study in a process: FMUs one by one, or joined systems, several runs at once."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Protocol

from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.files import whole_file
from warmlink.fmus.packaging.cache import cache_folder, used
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.orchestration.files import FULL_DISK
from warmlink.orchestration.fmu_store import FmuKind
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import RecordTable, Result
from warmlink.orchestration.studies.case import Case, Outcome, figures, run_case

Remark = Callable[[str], None]

MOST_POINTS = 200_000
"""Most steps of a kind, and samples, of a joined run: all of them are laid out in memory."""

CASE_S, JOINED_HOURS_A_SECOND, FMU_HOURS_A_SECOND = 1e-3, 1000.0, 50.0
"""What a run takes in itself, and the closed-loop hours of joined systems and of FMUs in a second, about."""

_KEPT = "the finished runs are kept, and the same command continues"


class Workers(Protocol):
    """Whoever runs cases."""

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run cases and give each one's place and outcome, in the order in which they end.

        A run that stops, or whose worker dies each time, has an outcome that says why; a worker that dies
        once loses nothing. InputError where the workers cannot go on.
        """


@dataclass(frozen=True)
class FmuSet:
    """Contents of FMUs by the component's name.

    Attributes
    ----------
    rollouts : joined systems that run in place of the FMUs, by the component behind the controllers
    """

    kind: FmuKind
    contents: Mapping[str, bytes] = field(repr=False)
    rollouts: Mapping[str, Rollout] = field(default_factory=dict, repr=False)

    @classmethod
    def read(cls, kind: FmuKind, files: Mapping[str, Path]) -> FmuSet:
        """Take FMUs from their files."""
        return cls(kind, {name: path.read_bytes() for name, path in sorted(files.items())})

    @cached_property
    def digest(self) -> str:
        """Digest of names and contents."""
        return self._digest(self.contents, self.rollouts)

    def digest_for(self, case: Case) -> str:
        """Digest of what one run uses: the FMUs of its system, and what is joined in their place."""
        return self._digest(case.machine.parts_with(case.law).values(), (case.law,))

    def _digest(self, fmus: Iterable[str], laws: Iterable[str]) -> str:
        held = {name: self._digests[name] for name in fmus if name in self._digests}
        joined = {law: self._joined[law] for law in laws if law in self._joined}
        return hashlib.sha256(json.dumps([held, joined], sort_keys=True).encode()).hexdigest()[:16]

    @cached_property
    def _digests(self) -> dict[str, str]:
        return {name: hashlib.sha256(content).hexdigest() for name, content in self.contents.items()}

    @cached_property
    def _joined(self) -> dict[str, str]:
        return {law: hashlib.sha256(each.library).hexdigest() for law, each in self.rollouts.items()}

    @property
    def unpacked(self) -> Path:
        """Folder in which runs on this machine unpack them, once; their files lie beside it."""
        return cache_folder() / "studies" / self.digest / "unpacked"

    def files(self) -> dict[str, Path]:
        """Files of the FMUs on this machine, written where they are missing or damaged."""
        return _written(self.unpacked.parent, tuple(sorted(self.contents.items())))


@lru_cache(maxsize=4)
def _written(folder: Path, contents: tuple[tuple[str, bytes], ...]) -> dict[str, Path]:
    folder.mkdir(parents=True, exist_ok=True)
    used(folder)
    files = {name: folder / f"{name}.fmu" for name, _ in contents}
    for name, content in contents:
        # Several workers may do this at once: each writes its own file, and any of the files will do.
        if not files[name].is_file() or files[name].read_bytes() != content:
            with whole_file(files[name]) as scratch:
                scratch.write_bytes(content)
    return files


def attempt_all(cases: Sequence[Case], fmus: FmuSet) -> list[Outcome]:
    """Run cases in this process: in groups where they have a joined system, else one by one on FMUs."""
    joined = joined_outcomes(cases, fmus.rollouts)
    return [joined.get(place) or attempt(case, fmus) for place, case in enumerate(cases)]


def attempt(case: Case, fmus: FmuSet) -> Outcome:
    """Run a case on FMUs; what goes wrong is the outcome's reason, but a full disk a NoRoomError."""
    try:
        return run_case(case, fmus.files(), fmus.unpacked)
    except NoRoomError as fault:
        raise NoRoomError(f"{fault}; {_KEPT}") from None
    except InputError as fault:
        return Outcome(stopped=str(fault))
    except Exception as fault:
        if isinstance(fault, OSError) and fault.errno in FULL_DISK:
            where = fault.filename or "a temporary file"
            raise NoRoomError(f"{where}: cannot be written ({fault.strerror}); free space; {_KEPT}") from None
        return Outcome(stopped=f"{type(fault).__name__}: {fault}")


def groups(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> list[list[int]]:
    """Places of the cases that run at once, longest run first: several where joined, on FMUs one alone.

    Longest first, so that no worker begins a long one when the others end.
    """
    alike: dict[object, list[int]] = {}
    for place in sorted(range(len(cases)), key=lambda place: -cases[place].work_hours):
        alike.setdefault(lane_of(cases[place], rollouts) or place, []).append(place)
    most = max((each.lanes for each in rollouts.values()), default=1)
    return [places[i : i + most] for places in alike.values() for i in range(0, len(places), most)]


def seconds(case: Case, rollouts: Mapping[str, Rollout]) -> float:
    """About how long a run takes."""
    joined = lane_of(case, rollouts) is not None
    return CASE_S + case.work_hours / (JOINED_HOURS_A_SECOND if joined else FMU_HOURS_A_SECOND)


def lane_of(case: Case, rollouts: Mapping[str, Rollout]) -> tuple[object, ...] | None:
    """What the runs in one group with this one have in common; None for one that runs on FMUs."""
    rollout = rollouts.get(case.law)
    periods = None if rollout is None else rollout.periods(case.values)
    if rollout is None or periods is None:
        return None
    if case.stop_time / min(case.step_size, rollout.micro_step, *periods) > MOST_POINTS:
        return None
    return case.law, case.stop_time, case.step_size, case.with_budget, periods


def joined_outcomes(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> dict[int, Outcome]:
    """Figures by place of the cases that have a joined system, where no FMU would have refused a value."""
    return {place: figures(cases[place], *results) for place, *results in joined_results(cases, rollouts)}


def joined_results(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> Iterator[tuple[Any, ...]]:
    """Place and result of each such case, and the result at half the step of one with a budget."""
    for places in groups(cases, rollouts):
        first = cases[places[0]]
        if lane_of(first, rollouts) is None:
            continue
        rollout, runs = rollouts[first.law], []
        names, units = rollout.recorded, dict.fromkeys(rollout.recorded)
        for parts in (1, 2) if first.with_budget else (1,):
            points = CommunicationPoints.between(0.0, first.stop_time, first.step_size / parts)
            given = [cases[place].values for place in places]
            played = [cases[place].machine.tables for place in places]
            runs.append((points, *rollout.run(given, points.count, points.step_size, played=played)))
        for i, place in enumerate(places):
            if all(well[i] for *_, well in runs):
                tables = (RecordTable(names, units, points, values[i].T) for points, values, _ in runs)
                yield place, *(Result(table, "completed") for table in tables)
