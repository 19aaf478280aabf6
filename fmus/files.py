"""Files that are whole or not there, archives of equal bytes, locks that end with their process."""

import hashlib
import os
import shutil
import sys
import tempfile
import threading
import time
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache, lru_cache
from pathlib import Path

WRITING = ".writing-"
"""How the names of files begin that are not whole yet."""

TEMPORARY = "warmlink-run-"
"""How the names of folders among temporary files begin."""

NEW_SECONDS = 60.0
"""Within which whoever has made a folder has locked it, or is dead."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Path to write a file under; it takes its own name when it is whole, and goes where it cannot be."""
    # Its end says of what kind the file is; all of a long name would not fit.
    scratch = path.with_name(f"{WRITING}{os.getpid()}-{threading.get_ident()}-{path.name[-50:]}")
    held = None
    try:
        held = _locked(scratch)
        yield scratch
        scratch.replace(path)
    except BaseException:
        with suppress(OSError):
            scratch.unlink(missing_ok=True)
        raise
    finally:
        unlock(held)


def file_digest(path: Path) -> str:
    """Give the SHA-256 digest of a file's bytes; an unchanged file is read once in a process."""
    facts = path.stat()
    return _digest(path, (facts.st_ino, facts.st_size, facts.st_mtime_ns, facts.st_ctime_ns))


@lru_cache(maxsize=256)
def _digest(path: Path, _facts: tuple[int, ...]) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def write_archive(target: Path, files: Mapping[str, bytes]) -> None:
    """Write a zip archive (an FMU, say) whose bytes depend on its contents alone; its folder is made.

    The files, by path with forward slashes, come in the order of their paths, modelDescription.xml first.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(target) as scratch, zipfile.ZipFile(scratch, "w") as archive:
        for path in sorted(files, key=lambda path: (path != "modelDescription.xml", path)):
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            entry.create_system = 3  # Unix
            library = path.endswith((".so", ".dll", ".dylib"))
            entry.external_attr = (0o100755 if library else 0o100644) << 16
            # The highest level takes over twice as long and saves half a percent.
            archive.writestr(entry, files[path], zipfile.ZIP_DEFLATED, 6)


def _locked(scratch: Path) -> int | None:
    """Make a file and lock it, by which others tell it from one that a killed process left.

    It is made anew where one took it for that before.
    """
    while True:
        scratch.touch()
        held, _ = lock(scratch, wait=True)
        if scratch.exists():
            return held
        unlock(held)


def sweep(folder: Path, prefix: str) -> None:
    """Remove what killed processes left: files and folders of a prefix that nobody holds."""
    for path in folder.glob(f"{prefix}*"):
        with suppress(OSError):  # its owner is about to lock it
            if path.name.startswith(f"{prefix}new-") and time.time() - path.stat().st_mtime < NEW_SECONDS:
                continue
        handle, free = lock(path)
        if handle is not None and free:
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)
        unlock(handle)


def hold(parent: Path, prefix: str) -> tuple[Path, int | None]:
    """Make a temporary folder that is locked as long as its owner lives, so that `sweep` can tell.

    Gives it with the handle that `let_go` takes; OSError where it cannot be made.
    """
    made = Path(tempfile.mkdtemp(prefix=f"{prefix}new-", dir=parent))
    handle, _ = lock(made)
    # It gets its name only now that it is locked, so that nobody takes it for an ownerless one.
    return made.rename(made.with_name(made.name.replace(f"{prefix}new-", prefix, 1))), handle


def let_go(work: Path, handle: int | None) -> None:
    """Remove a folder that `hold` made, if it is still there."""
    shutil.rmtree(work, ignore_errors=True)
    unlock(handle)


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Folder among temporary files, gone afterwards; those that killed processes left go too.

    OSError where it cannot be made.
    """
    home = Path(tempfile.gettempdir())
    _sweep_once(home)
    work, handle = hold(home, TEMPORARY)
    try:
        yield work
    finally:
        let_go(work, handle)


@cache
def _sweep_once(home: Path) -> None:
    sweep(home, TEMPORARY)


def lock(path: Path, wait: bool = False) -> tuple[int | None, bool]:
    """Lock a file or folder that is there; where asked to, wait until nobody else holds it.

    Gives a handle for `unlock`, None where the system or the file system has no such locks, and whether
    nobody else holds it.
    """
    if sys.platform == "win32":
        return None, True
    import fcntl

    handle = None
    try:
        # Network file systems lock only files that are open for writing, and no folder can be.
        handle = os.open(path, (os.O_RDONLY if path.is_dir() else os.O_RDWR) | os.O_NOFOLLOW)
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return handle, False
    except OSError:
        unlock(handle)
        return None, True
    return handle, True


def unlock(handle: int | None) -> None:
    """Give a lock back."""
    if handle is not None:
        os.close(handle)
