"""What `warmlink tune` and `warmlink sweep` have in common: the study, its FMUs, its workers, its folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.commands.console import remark
from warmlink.orchestration.commands.run import chosen_kind
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.studies.fmu_set import FmuSet
from warmlink.orchestration.studies.ledger import Ledger
from warmlink.orchestration.studies.study import Study
from warmlink.orchestration.studies.workers import Workers
from warmlink.orchestration.system.shipped import WARMUP_CELL

INTERRUPTED = 130
KEPT = "interrupted; what is finished is kept, the same command goes on"
LOCK = ".lock"


@dataclass(frozen=True)
class Means:
    """What a study is run with."""

    fmus: FmuSet
    folder: Path
    workers: Workers


@contextmanager
def means(study: Study, fmus: str | None, scheduler: str | None, jobs: int, out: Path) -> Iterator[Means]:
    """FMUs, folder and workers of a study; a folder made for the purpose goes again if nothing came of it.

    Raises
    ------
    InputError
        If there are no workers to be had, the folder cannot be written, or another study is at work in it.
    """
    chosen = _fmu_set(study, fmus)
    with _workers(chosen, scheduler, jobs) as workers, _folder(out):
        yield Means(chosen, out, Ledger(out, chosen.digest, workers, remark))


@contextmanager
def _workers(fmus: FmuSet, scheduler: str | None, jobs: int) -> Iterator[Workers]:
    if scheduler is not None:
        from warmlink.orchestration.studies.cluster import ClusterWorkers

        with ClusterWorkers(fmus, scheduler) as cluster:
            yield cluster
        return
    from warmlink.orchestration.studies.local import LocalWorkers

    with LocalWorkers(fmus, jobs) as local:
        yield local


def _fmu_set(study: Study, fmus: str | None) -> FmuSet:
    own = study.own
    kinds = WARMUP_CELL.components_with(study.law.name).values()
    needed = sorted(kind for kind in kinds if own is None or kind != study.law.name)
    chosen = store(chosen_kind(fmus), needed, remark)
    files = chosen.files(needed, remark)
    if own is not None:
        files[study.law.name] = own.fmu(chosen)
    return FmuSet.read(chosen.kind, files)


@contextmanager
def _folder(folder: Path) -> Iterator[None]:
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stream = (folder / LOCK).open("w")
    except OSError as fault:
        raise InputError(f"{folder}: cannot be written ({fault.strerror}); choose another --out") from None
    try:
        with stream:
            _lock(stream.fileno(), folder)
            try:
                yield
            except InputError:
                if made:
                    _clear(folder)
                raise
            finally:
                with suppress(OSError):
                    (folder / LOCK).unlink()
    finally:
        for path in made:
            with suppress(OSError):  # it holds something
                path.rmdir()


def _lock(handle: int, folder: Path) -> None:
    """Keep others out until the process ends, be it by a kill."""
    try:
        import fcntl
    except ImportError:  # Windows, where the file itself is held open
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise InputError(
            f"{folder}: another study is at work there; wait for it, or choose another --out"
        ) from None


def _clear(folder: Path) -> None:
    for path in folder.iterdir():
        if path.is_file():
            path.unlink()
