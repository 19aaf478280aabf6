"""Files that are whole or not there, folders with one writer, and temporary folders that do not stay."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.files import TEMPORARY, WRITING, hold, let_go, lock, sweep, unlock, whole_file
from warmlink.fmus.safe_text import printable

WRITTEN = ".written-"
"""How the names of folders begin whose files are whole, and are about to take their places."""

_GOES = ".goes"
"""Folder in such a folder with the names of files that go before; those that are kept stand in a folder of it
that is named as the one into which they go. Names alone take no room on a disk that is full."""

ENDING_SECONDS = 1.0
"""Within which the processes of a command that was killed have ended, and hold no folder any more."""

FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO)
"""Error numbers that mean a full or broken disk."""


@contextmanager
def fresh_folder(
    folder: Path, old: Callable[[], Iterable[Path]] = tuple, kept_in: str = ""
) -> Iterator[Path]:
    """Folder to write results into; its files move to `folder` when all are written.

    Files of the same names are replaced, and before that the `old` ones go, or are `kept_in` a folder of that
    name inside; others in `folder` are left alone, and so are all where nothing was written. Whatever ends
    the process, either the old files are there or the new ones: what it had no time for, `settle` does.
    Folders made for the purpose go again where nothing came of it, and so does what a process that was killed
    left there. InputError if the folder cannot be written; NoRoomError where the disk is full.
    """
    shown, folder = folder, folder.absolute()
    with _made(folder, shown):
        settle(folder)
        sweep(folder, WRITING)
        with _owned(folder, WRITING, f"choose another {argument('out')}", shown) as work:
            try:
                yield work
                new = [path.relative_to(work) for path in sorted(work.rglob("*")) if path.is_file()]
                for name in new:
                    if (folder / name).is_dir():
                        raise InputError(
                            f"{shown / name}: is a folder; choose another {argument('out')}, or move it"
                        )
                goes = work / _GOES / kept_in
                goes.mkdir(parents=True)
                for path in old() if new else ():
                    (goes / path.name).touch()
            except OSError as fault:
                if fault.errno not in FULL_DISK:
                    raise
                told = os.strerror(fault.errno).lower()
                raise NoRoomError(f"{shown}: cannot be written ({told}); free space there") from None
            if new:
                with _refused("{}: cannot be replaced ({}); choose another " + argument("out"), shown):
                    ready = work.rename(work.with_name(work.name.replace(WRITING, WRITTEN, 1)))
                    _take_places(ready)


def settle(folder: Path) -> None:
    """Finish what a killed process had begun in a folder: files that it had written take their places.

    Where that cannot be done, as in a folder that is read-only, all stays as it is.
    """
    with suppress(OSError, ValueError):  # a name that no folder can have
        for path in [*folder.glob(f"{WRITTEN}*")]:
            handle, _ = lock(path, wait=True)  # by who is at it now, for a moment
            with suppress(OSError):
                _take_places(path)
            unlock(handle)


def _take_places(ready: Path) -> None:
    """Have the old files go, then the new ones move up; may be done again after it was interrupted."""
    goes = ready / _GOES
    for name in [path for path in goes.rglob("*") if path.is_file()]:
        path = ready.parent / name.name
        if name.parent != goes and path.exists():
            kept = ready.parent / name.parent.name
            kept.mkdir(exist_ok=True)
            path.replace(kept / name.name)
        path.unlink(missing_ok=True)
        name.unlink()
    for path in sorted(ready.rglob("*")):
        if path.is_file():
            place = ready.parent / path.relative_to(ready)
            place.parent.mkdir(parents=True, exist_ok=True)
            path.replace(place)
    shutil.rmtree(ready)


@contextmanager
def fresh_file(path: Path) -> Iterator[Path]:
    """Path to write a file under; it takes its own name when it is whole.

    InputError if the file cannot be written, as where the folder is read-only or the disk is full.
    """
    with _refused("{}: cannot be written ({}); nothing is there, choose another " + argument("out"), path):
        sweep(path.parent, WRITING)
        with whole_file(path) as scratch:
            yield scratch


def write_all(file: BinaryIO, data: bytes) -> None:
    """Write all of some bytes to a file without a buffer, which may take a part of them alone."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def with_hash(path: str | Path) -> str:
    """A file's name and the SHA-256 of what it holds, in short, as texts tell what numbers were made from."""
    mark = hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]
    return f"{printable(Path(path).name)} (SHA-256 {mark})"


def stamped(facts: Mapping[str, Any]) -> bytes:
    """A line of JSON that tells by a checksum that it is whole."""
    text = json.dumps(facts)
    return f'{text[:-1]}, "checksum": "{hashlib.sha256(text.encode()).hexdigest()[:16]}"}}\n'.encode()


def unstamped(line: bytes) -> dict[str, Any] | None:
    """What a line says; None where it is not, byte for byte, what `stamped` writes."""
    try:
        said = json.loads(line)
        said.pop("checksum")
        return said if stamped(said) == line else None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def write_files(
    folder: Path, writers: Mapping[str, Callable[[Path], object]], earlier: bool = False
) -> str | None:
    """Write files by name, each whole or not there, whatever becomes of the others, into a fresh folder.

    Where not all can be written and there are results of an `earlier` run, none is left, so that those stay.
    Returns what could not be written and why, as a sentence; None where everything was.
    """
    lost, reason = [], ""
    for name, write in writers.items():
        try:
            write(folder / name)
        except OSError as fault:
            # What Arrow says of it takes three lines.
            reason = (os.strerror(fault.errno) if fault.errno else str(fault)).lower()
            lost.append(name)
            (folder / name).unlink(missing_ok=True)
    if not lost:
        return None
    stay = ""
    if earlier:
        lost, stay = list(writers), "; the results of an earlier run stay"
        for name in writers:
            (folder / name).unlink(missing_ok=True)
    told = f"lost, because {'not all' if earlier else 'it'} could{'' if earlier else ' not'} be written"
    return f"{told} ({reason}): {' and '.join(lost)}{stay}; free space or choose another {argument('out')}"


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Keep other processes from writing into a folder as long as this one does; it is made where absent.

    The lock ends with the process, however that ends, and leaves no file behind. On a file system without
    locks (some network file systems) nobody is refused. InputError if another process holds the folder, or it
    cannot be written.
    """
    folder, give_up = folder.absolute(), time.monotonic() + ENDING_SECONDS
    while True:
        handle = None
        try:
            with _made(folder):
                handle, free = lock(folder)
                if not free and time.monotonic() < give_up:
                    time.sleep(0.02)
                    continue
                if not free:
                    raise InputError(
                        f"{folder}: another warmlink is writing there{_holder(folder)}; wait until it has "
                        f"ended, or choose another {argument('out')}"
                    )
                if handle is None or _is_still(handle, folder):
                    yield
                    return
        finally:
            unlock(handle)  # only now, so that nobody locks a folder that is about to go again


def _holder(folder: Path) -> str:
    """Number of the process that holds a folder, in brackets, where the system tells."""
    with suppress(OSError):
        facts = folder.stat()
        place = f"{os.major(facts.st_dev):02x}:{os.minor(facts.st_dev):02x}:{facts.st_ino}"
        for line in Path("/proc/locks").read_text("ascii").splitlines():
            words = line.split()
            if "FLOCK" in words and place in words and "->" not in words:
                return f" (process {words[words.index(place) - 1]})"
    return ""


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Folder for a run's own files, gone afterwards; those that killed processes left go too.

    InputError if it cannot be made.
    """
    try:
        home = Path(tempfile.gettempdir())
    except OSError as fault:
        raise InputError(f"{fault.strerror}; name a folder that can be written in TMPDIR") from None
    sweep(home, TEMPORARY)
    with _owned(home, TEMPORARY, "free space there, or name another folder in TMPDIR") as work:
        yield work


@contextmanager
def _refused(sentence: str, path: Path) -> Iterator[None]:
    """Raise InputError with a sentence of a path and of what the system says, where it refuses."""
    try:
        yield
    except OSError as fault:
        raise InputError(sentence.format(path, fault.strerror or fault)) from None


@contextmanager
def _made(folder: Path, shown: Path | None = None) -> Iterator[None]:
    """Make a folder, which may be shown otherwise; those made go again where nothing came of it."""
    made: list[Path] = []
    try:
        with _refused("{}: cannot be written ({}); choose another " + argument("out"), shown or folder):
            made = [path for path in (folder, *folder.parents) if not path.exists()]
            folder.mkdir(parents=True, exist_ok=True)
        yield
    finally:
        for path in made:
            with suppress(OSError):  # it holds something, or was never made
                path.rmdir()


@contextmanager
def _owned(parent: Path, prefix: str, remedy: str, shown: Path | None = None) -> Iterator[Path]:
    """Temporary folder that is locked as long as its owner lives, so that `sweep` can tell."""
    with _refused(f"{{}}: cannot be written ({{}}); {remedy}", shown or parent):
        work, handle = hold(parent, prefix)
    try:
        yield work
    finally:
        let_go(work, handle)


def _is_still(handle: int, folder: Path) -> bool:
    """Whether a folder is the one that was locked: whoever held it before may have removed it meanwhile."""
    try:
        return os.path.samestat(os.fstat(handle), folder.stat())
    except FileNotFoundError:
        return False
