"""What `compare`, `tune` and `sweep` share: FMUs, workers, the folder, and what Ctrl-C does."""

from __future__ import annotations

import signal
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.console import INTERRUPTED, remark
from warmlink.orchestration.commands.run import chosen_kind
from warmlink.orchestration.files import fresh_folder, locked_folder
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.own_law import OwnLaw
from warmlink.orchestration.studies.cores.local import LocalWorkers, check_jobs
from warmlink.orchestration.studies.cores.workers import Workers
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.ledger import FILE, Ledger


@dataclass(frozen=True)
class Means:
    """What a study is run with."""

    fmus: FmuSet
    workers: Workers


@contextmanager
def means(
    kinds: Collection[str],
    foreign: Mapping[str, Path],
    own: Sequence[OwnLaw],
    fmus: str | None,
    scheduler: str | None,
    jobs: int,
    out: Path,
) -> Iterator[Means]:
    """FMUs, and workers that keep what they finish in a folder, which is theirs alone.

    Parameters
    ----------
    kinds : components of ours that are needed
    foreign : FMUs of others, by the component's name
    own : laws of one's own
    fmus, scheduler, jobs, out : what the command line says

    What was empty before is so again where no run was finished.

    Raises
    ------
    InputError
        If there are no workers to be had, the folder cannot be written, or another study is at work in it.
    """
    kind = chosen_kind(fmus)
    if scheduler is None:
        check_jobs(jobs)
    with locked_folder(out):
        fresh = not any(out.iterdir())
        try:
            chosen = _fmu_set(kinds, foreign, own, kind)
            with _workers(chosen, scheduler, jobs) as workers:
                yield Means(chosen, Ledger(out, chosen.digest, workers, remark))
        except InputError:
            if fresh and not (out / FILE).exists():
                _clear(out)
            raise


@contextmanager
def results(folder: Path) -> Iterator[Path]:
    """Folder to write the results of finished runs into; its files move to `folder` when all are written.

    Raises
    ------
    InputError
        If they cannot be written; the sentence says that the runs are kept.
    """
    kept = "every finished run is kept, and the same command writes the results"
    try:
        with fresh_folder(folder) as target:
            yield target
    except OSError as fault:
        raise InputError(
            f"{folder}: the results cannot be written ({fault.strerror or fault}); make room: {kept}"
        ) from None
    except InputError as fault:
        raise InputError(f"{fault}; {kept}") from None


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C ends what is done here in order, and then the command; pressed again meanwhile, it ends at once.

    Workers end with the process.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def first(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, first)
    try:
        yield
    except KeyboardInterrupt:
        remark("interrupted; what is finished is kept, the same command goes on")
        raise SystemExit(INTERRUPTED) from None
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _workers(fmus: FmuSet, scheduler: str | None, jobs: int) -> Iterator[Workers]:
    if scheduler is not None:
        from warmlink.orchestration.studies.cores.cluster import ClusterWorkers

        with ClusterWorkers(fmus, scheduler) as cluster:
            yield cluster
        return
    with LocalWorkers(fmus, jobs) as local:
        yield local


def _fmu_set(
    kinds: Collection[str], foreign: Mapping[str, Path], own: Sequence[OwnLaw], kind: FmuKind | None
) -> FmuSet:
    needed = sorted(set(kinds) - {law.component.name for law in own})
    chosen = store(kind, needed, remark)
    files = {**chosen.files(needed, remark), **foreign}
    for law in own:
        files[law.component.name] = law.fmu(chosen)
    return FmuSet.read(chosen.kind, files)


def _clear(folder: Path) -> None:
    for path in folder.iterdir():
        if path.is_file():
            path.unlink()
