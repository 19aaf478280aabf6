"""What runs the cases of a study in a process: FMUs one by one, or joined systems side by side."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import cycle
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.files import whole_file
from warmlink.fmus.packaging.cache import cache_folder, remembered, used
from warmlink.fmus.packaging.native.library import loaded, made_here, processor
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.fmus.packaging.native.rollout_code import compiled
from warmlink.orchestration.files import FULL_DISK
from warmlink.orchestration.fmu_store import FmuKind
from warmlink.orchestration.master.algorithms import DEFAULT_MASTER
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import RecordTable, Result
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.scenarios.duties.duty import IDLE
from warmlink.orchestration.scenarios.mismatch import Mismatch
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import (
    COMPARED,
    Case,
    Outcome,
    case_of,
    figures,
    recorded,
    run_case,
)

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
        joined = {f"{law} joined": rollout.library for law, rollout in self.rollouts.items()}
        held = sorted({**self.contents, **joined}.items())
        told = b"".join(f"{name}\0{len(content)}\0".encode() + content for name, content in held)
        return hashlib.sha256(told).hexdigest()[:16]

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
    """Run cases in this process: side by side where they have a joined system, else one by one on FMUs."""
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


def side_by_side(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> list[list[int]]:
    """Places of the cases in shares that run together, longest run first: one on FMUs, several where joined.

    Longest first, so that no worker begins a long one when the others end.
    """
    alike: dict[object, list[int]] = {}
    for place in sorted(range(len(cases)), key=lambda place: -cases[place].hours):
        alike.setdefault(lane_of(cases[place], rollouts) or place, []).append(place)
    most = max((each.lanes for each in rollouts.values()), default=1)
    return [places[i : i + most] for places in alike.values() for i in range(0, len(places), most)]


def seconds(case: Case, rollouts: Mapping[str, Rollout]) -> float:
    """About how long a run takes."""
    joined = lane_of(case, rollouts) is not None
    return CASE_S + case.hours / (JOINED_HOURS_A_SECOND if joined else FMU_HOURS_A_SECOND)


def lane_of(case: Case, rollouts: Mapping[str, Rollout]) -> tuple[object, ...] | None:
    """What the runs that go side by side with this one have in common; None for one that runs on FMUs."""
    rollout = rollouts.get(case.law)
    periods = None if rollout is None else rollout.periods(case.values)
    if rollout is None or periods is None:
        return None
    if case.stop_time / min(case.step_size, rollout.micro_step, *periods) > MOST_POINTS:
        return None
    return case.law, case.stop_time, case.step_size, case.with_budget, periods


def joined_outcomes(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> dict[int, Outcome]:
    """Figures by place of the cases that have a joined system, where no FMU would have refused a value."""
    return {place: figures(cases[place], *results) for place, *results in _joined(cases, rollouts)}


def _joined(cases: Sequence[Case], rollouts: Mapping[str, Rollout]) -> Iterator[tuple[Any, ...]]:
    """Place and result of each such case, and the result at half the step of one with a budget."""
    for places in side_by_side(cases, rollouts):
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


def joined_systems(
    scenarios: Sequence[Scenario], remark: Remark, progress: Progress = unseen
) -> dict[str, Rollout]:
    """The systems of a study's scenarios, joined and compiled, by the component behind the controllers.

    Those that hold foreign FMUs, or are run with another master than the usual one, are left out; so are
    those that cannot be compiled, with a remark.
    """
    found: dict[str, Rollout] = {}
    # Whatever drives them is no part of what is compiled: tables stand in place of the segments.
    laws = _by_law([replace(each, duty=IDLE) if each.duty.tables else each for each in scenarios])
    for done, (law, mine) in enumerate(laws.items()):
        progress(f"compiling system {done + 1} of {len(laws)}, with {law}", done / len(laws))
        first = mine[0]
        usual = DEFAULT_MASTER, dict[str, Path](), first.made_from
        if any((each.master, each.machine.foreign, each.made_from) != usual for each in mine):
            continue
        names = tuple(dict.fromkeys(name for each in mine for name in recorded(each.machine)))
        made_from = (*made_here(), *first.made_from, names, processor())
        try:
            rollout = remembered("rollouts", made_from, lambda: compiled(first.joined({}), names))  # noqa: B023
            loaded(rollout.library)
            found[law] = rollout
        except (InputError, OSError) as fault:
            remark(f"{law}: runs on its FMUs, since its system cannot be joined: {fault}")
    return found


def _by_law(scenarios: Sequence[Scenario]) -> dict[str, list[Scenario]]:
    """Scenarios by the component behind their controllers."""
    laws = dict.fromkeys(each.controller.component.name for each in scenarios)
    return {law: [each for each in scenarios if each.controller.component.name == law] for law in laws}


def agreeing(
    scenarios: Sequence[Scenario],
    mismatches: Sequence[Mismatch],
    fmus: FmuSet,
    remark: Remark,
    progress: Progress = unseen,
) -> FmuSet:
    """The FMUs with those of their joined systems whose figures are theirs within the coupling error."""
    found = tried(scenarios, mismatches, fmus, remark, progress)
    good = {law: each for law, each in found.items() if each[0] <= each[1]}
    for law, (difference, coupling) in found.items():
        if law not in good:
            told = f"{law}: figures of the joined system differ by {difference:.2g} µm from those of the FMUs"
            remark(f"{told}, more than the coupling error of {coupling:.2g} µm; it runs on its FMUs")
    if good:
        difference, coupling = np.max(list(good.values()), axis=0)
        told = f"joined systems: {len(good)} run{'s' if len(good) > 1 else ''} tried beside the FMUs"
        told += f"; figures differ by at most {difference:.2g} µm"
        remark(f"{told}, the coupling error is up to {coupling:.2g} µm ({argument('exact')} runs the FMUs)")
    return replace(fmus, rollouts={law: fmus.rollouts[law] for law in good})


def tried(
    scenarios: Sequence[Scenario],
    mismatches: Sequence[Mismatch],
    fmus: FmuSet,
    remark: Remark,
    progress: Progress = unseen,
) -> dict[str, tuple[float, float]]:
    """Difference of the figures of joined systems from those of FMUs, and the coupling error, both in µm.

    FMUs hand on what changes up to a step late, so that a run in which the growth turns most sharply has the
    largest coupling error. Each controller is tried in such a run, each in another as far as there are any.
    What was found is kept for the next study with the same FMUs; where nothing was, a remark says why.
    """
    planned = [each for each in scenarios if each.controller.component.name in fmus.rollouts]
    runs = _by_law([mismatch.applied(each) for each in planned for mismatch in mismatches])
    cases, turns = [case_of(each, (each.name,)) for each in next(iter(runs.values()), [])], dict[int, float]()
    progress("looking for the runs to try beside the FMUs", 0.0)
    for place, result in _joined(cases, fmus.rollouts):
        growth = cases[place].machine.roles.uncompensated.value(result.__getitem__)
        turns[place] = -float(np.max(np.abs(np.diff(growth, 2)), initial=0.0))
    sharpest_first = sorted(range(len(cases)), key=lambda place: turns.get(place, 0.0))
    found = dict[str, tuple[float, float]]()
    for done, ((law, mine), at) in enumerate(zip(runs.items(), cycle(sharpest_first), strict=False)):
        progress(f"trying {law} beside its FMUs", done / len(runs))
        try:
            found[law] = _difference(mine[at], fmus)
        except _UntriedError as why:
            remark(f"{law}: runs on its FMUs, since {why}")
    return found


class _UntriedError(Exception):
    """A run did not end both ways; it says which way, and is no answer to be kept."""


def _difference(scenario: Scenario, fmus: FmuSet) -> tuple[float, float]:
    """Largest difference of a run's figures, and the coupling error of the FMUs, both in µm."""
    case = case_of(scenario, (scenario.controller.name, scenario.name, "tried"), with_budget=True)

    def found() -> tuple[float, float]:
        exact, joined = attempt(case, fmus), joined_outcomes([case], fmus.rollouts).get(0)
        if exact.coupling_um is None:
            why = exact.stopped or "at half its step"
            raise _UntriedError(f"the run that was tried of it stopped: {why}")
        if joined is None:
            raise _UntriedError("its joined system does not take the run that was tried")
        most = float(np.max([abs(getattr(exact, name) - getattr(joined, name)) for name in COMPARED]))
        if not math.isfinite(most):
            raise _UntriedError("the score of the run that was tried of it is no number")
        return most, exact.coupling_um

    return remembered("agreements", (fmus.digest, case.digest), found)
