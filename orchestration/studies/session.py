"""What a comparison, a tuning study and a sweep run with: FMUs, and workers that keep what they finish."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import NamedTuple

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import locked_folder, stamped, temporary_folder, unstamped
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.progress import spinner, stretch
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.joined import agreeing, joined_systems
from warmlink.orchestration.studies.processes import (
    DEFAULT_JOBS,
    ClusterWorkers,
    LocalWorkers,
    check_jobs,
    connected,
)
from warmlink.orchestration.studies.workers import FmuSet, Remark, Workers

FILE = "runs.jsonl"

_COMPILED = 0.9
"""Share of the preparation that compiling the joined systems takes; the rest tries them beside the FMUs."""


@dataclass(frozen=True)
class RunOptions:
    """What a study runs with.

    Attributes
    ----------
    fmus : kind of FMU
    jobs : processes that run at once
    scheduler : in their place a Dask scheduler, `tcp://10.0.0.1:8786`
    exact : run the FMUs also where the system can be joined, as with a kind of FMU that is asked for
    """

    fmus: FmuKind | None = None
    jobs: int = DEFAULT_JOBS
    scheduler: str | None = None
    exact: bool = False


USUAL = RunOptions()


class StudySession(NamedTuple):
    """The folder of a study, its FMUs, and workers that run them."""

    folder: Path
    fmus: FmuSet
    workers: Workers


@contextmanager
def open_study(
    runs: Sequence[Scenario], options: RunOptions, out: str | Path | None = None
) -> Iterator[StudySession]:
    """FMUs for the runs of a study's points, and workers that keep each finished run in a folder.

    The folder is locked for them; by default it is a temporary one. If no run was finished, a folder that was
    empty before is empty again. InputError if another study is using the folder.
    """
    if options.scheduler is None:
        check_jobs(options.jobs)
    with ExitStack() as stack:
        folder = Path(out) if out is not None else stack.enter_context(temporary_folder()) / "study"
        stack.enter_context(locked_folder(folder))
        fresh, said, client = not any(folder.iterdir()), list[str](), None
        try:
            if options.scheduler is not None:  # before anything is built, which may be for nothing
                client = stack.enter_context(connected(options.scheduler))
            if any(each.coupling_tolerance is not None for each in runs):
                said.append("coupling_tolerance: steps follow it in `warmlink run` alone, here step_size")
            said.extend(dict.fromkeys(told for each in runs for told in each.remarks))
            built = store(options.fmus, sorted({kind for each in runs for kind in each.kinds}), remark)
            files = {name: path for each in runs for name, path in each.files(built).items()}
            fmus = FmuSet.read(built.kind, files)
            if built.kind == "native" and options.fmus is None and not options.exact:
                with spinner("Preparing the runs") as show:
                    joined = joined_systems(runs, said.append, stretch(show, 0.0, _COMPILED))
                    whole, trying = replace(fmus, rollouts=joined), stretch(show, _COMPILED, 1.0)
                    fmus = agreeing(runs, whole, said.append, trying)
            workers = LocalWorkers(fmus, options.jobs) if client is None else ClusterWorkers(fmus, client)
            own: Workers = stack.enter_context(workers)
            yield StudySession(folder, fmus, Ledger(folder, fmus, own, remark, said))
        except InputError:
            if fresh and not (folder / FILE).exists():
                for path in folder.iterdir():
                    if path.is_file():
                        path.unlink()
            raise


class Ledger:
    """Workers that know what was run before, in `runs.jsonl` of a folder: a line for each finished run.

    Each line ends with its checksum. A line that a kill cut short at the end of the file is overwritten; a
    damaged one elsewhere is named in a remark and removed, and its run is done again. Runs that gave no
    figures are not kept: what stopped them may be mended.

    Runs are told apart by the bytes of the `fmus` that they use, so that what was run stays known when a
    controller is added; `workers` run what is not known yet; `remark` is told of damaged lines, and of `news`
    before the first run.
    """

    def __init__(
        self, folder: Path, fmus: FmuSet, workers: Workers, remark: Remark, news: Sequence[str] = ()
    ) -> None:
        self._path, self._fmus, self._workers = folder / FILE, fmus, workers
        self._remark, self._news = remark, news
        self._known: dict[str, Outcome] = {}
        self._end = 0
        try:
            if self._path.is_file():
                self._read()
        except OSError as fault:
            raise InputError(
                f"{self._path}: cannot be read ({fault.strerror}); mend that, or choose "
                f"another {argument('out')}"
            ) from None

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Give what is known, then run the rest, equal cases once, each written down as it ends.

        KeyboardInterrupt where Ctrl-C was noted meanwhile.
        """
        waiting: dict[str, list[int]] = {}
        for place, case in enumerate(cases):
            key = hashlib.sha256(f"{self._fmus.digest_for(case)} {case.digest}".encode()).hexdigest()[:32]
            if key in self._known:
                yield place, self._known[key]
            else:
                waiting.setdefault(key, []).append(place)
        for sentence in self._news if waiting else ():
            self._remark(sentence)
            self._news = ()
        keys = list(waiting)
        for found, outcome in self._workers.run([cases[waiting[key][0]] for key in keys]):
            if under_way.asked():
                raise KeyboardInterrupt
            if outcome.stopped is None:
                self._keep(keys[found], outcome)
            for place in waiting[keys[found]]:
                yield place, outcome

    def _keep(self, key: str, outcome: Outcome) -> None:
        line = _line(key, outcome)
        if _parsed(line) != (key, outcome):  # a figure that is no number
            return
        try:
            with self._path.open("r+b" if self._path.exists() else "w+b") as stream:
                stream.seek(self._end)
                stream.truncate()
                stream.write(line)
        except OSError as fault:
            raise InputError(
                f"{self._path}: cannot be written ({fault.strerror}); the {len(self._known)} runs before are "
                "kept, those under way are lost; make room, and the same command continues"
            ) from None
        self._known[key] = outcome
        self._end += len(line)

    def _read(self) -> None:
        lines = self._path.read_bytes().splitlines(keepends=True)
        if lines and not lines[-1].endswith(b"\n"):
            lines.pop()
        parsed = [_parsed(line) for line in lines]
        good = b"".join(line for line, found in zip(lines, parsed, strict=True) if found is not None)
        damaged = [number for number, found in enumerate(parsed, start=1) if found is None]
        self._known.update(found for found in parsed if found is not None)
        if damaged:
            more = f" and {len(damaged) - 1} more" if len(damaged) > 1 else ""
            self._remark(f"{self._path}: line {damaged[0]}{more}: damaged; what was run there is run again")
            mended = self._path.with_suffix(".mended")
            mended.write_bytes(good)
            mended.replace(self._path)
        self._end = len(good)


def _line(key: str, outcome: Outcome) -> bytes:
    """A run as a line of the file."""
    return stamped({"run": key, **outcome.to_dict()})


def _parsed(line: bytes) -> tuple[str, Outcome] | None:
    """Key and outcome of a line; None where it is not, byte for byte, what `_line` writes."""
    given = unstamped(line) or {}
    try:
        key = str(given["run"])
        outcome = Outcome(**{each.name: given[each.name] for each in fields(Outcome)})
    except (KeyError, TypeError):
        return None
    return (key, outcome) if _line(key, outcome) == line else None
