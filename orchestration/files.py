"""Files that are whole or not there, written under another name, then renamed; folders with one writer."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from warmlink.fmus.errors import InputError

LOCK = ".lock"


@contextmanager
def fresh_folder(folder: Path) -> Iterator[Path]:
    """Folder to write results into; its files move to `folder` when all are written.

    Files of the same names are replaced, others in `folder` are left alone. Folders made for the purpose go
    again where nothing came of it.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=".writing-", dir=folder))
    except OSError as fault:
        raise InputError(f"{folder}: cannot be written ({fault.strerror}); choose another --out") from None
    try:
        yield work
        for path in sorted(work.iterdir()):
            path.replace(folder / path.name)
    finally:
        shutil.rmtree(work, ignore_errors=True)
        for path in made:
            with suppress(OSError):  # it holds something
                path.rmdir()


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Keep other processes out of a folder until the block ends or this process dies, be it by a kill.

    Folders made for the purpose go again where nothing came of it.

    Raises
    ------
    InputError
        If the folder cannot be written, or another process is at work in it.
    """
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            stream = _locked(folder / LOCK)
        except BlockingIOError:
            raise InputError(
                f"{folder}: another warmlink is at work there; wait for it, or choose another --out"
            ) from None
        except OSError as fault:
            raise InputError(
                f"{folder}: cannot be written ({fault.strerror}); choose another --out"
            ) from None
        with stream:
            try:
                yield
            finally:
                with suppress(OSError):
                    (folder / LOCK).unlink()
    finally:
        for path in made:
            with suppress(OSError):  # it holds something
                path.rmdir()


def _locked(path: Path) -> TextIO:
    """The file, opened and locked, and still there: whoever ended just now may have removed it."""
    try:
        import fcntl
    except ImportError:  # Windows, where the file itself is held open
        return path.open("w")
    while True:
        stream = path.open("w")
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                    return stream
        except OSError:
            stream.close()
            raise
        stream.close()
