"""Files that are whole or not there: written under another name, then renamed."""

from __future__ import annotations

import codecs
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from warmlink.fmus.errors import InputError


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
        _remove_empty(made)
        raise InputError(f"{folder}: cannot be written ({fault.strerror}); choose another --out") from None
    try:
        yield work
        for path in sorted(work.iterdir()):
            path.replace(folder / path.name)
    finally:
        shutil.rmtree(work, ignore_errors=True)
        _remove_empty(made)


def _remove_empty(folders: Iterable[Path]) -> None:
    for path in folders:
        with suppress(OSError):  # it holds something, or was never made
            path.rmdir()


@contextmanager
def fresh_file(path: Path) -> Iterator[Path]:
    """Path to write a file under; it takes its own name when it is whole.

    Raises
    ------
    InputError
        If the file cannot be written, as where the folder is read-only or the disk is full.
    """
    scratch = path.with_name(f".writing-{path.name}")
    try:
        yield scratch
        scratch.replace(path)
    except OSError as fault:
        with suppress(OSError):
            scratch.unlink(missing_ok=True)
        reason = fault.strerror or fault
        raise InputError(
            f"{path}: cannot be written ({reason}); nothing is there, choose another --out"
        ) from None


def text_of(path: Path) -> str:
    """Text of a file of measurements in UTF-8, UTF-16 with its mark, or else Latin-1, as spreadsheets write.

    Raises
    ------
    InputError
        The file cannot be read, or holds no text.
    """
    try:
        content = path.read_bytes()
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror}); give the path of a file") from None
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = content.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if "\0" in text:
        raise InputError(f"{path.name}: is no text in UTF-8, UTF-16 or Latin-1; save it as UTF-8")
    return text
