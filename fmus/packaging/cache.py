"""Where built FMUs and what they are built from are kept between runs."""

import hashlib
import os
import pickle
import re
import shutil
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import WRITING, file_digest, lock, sweep, unlock, whole_file
from warmlink.fmus.packaging.trust import others_may_write

CACHE_VARIABLE = "WARMLINK_CACHE"
"""Environment variable that names the folder for built FMUs."""

LIMIT_VARIABLE = "WARMLINK_CACHE_LIMIT"
"""Environment variable with the size in MB beyond which what was not used for longest goes."""

_LIMIT_MB = 2000.0
_IN_USE_S = 86400.0
"""What was used within this time stays: somebody may be at it."""

_LOOK_AGAIN_S = 3600.0
"""A cache that has its room is looked through again after this time: a full one holds thousands of files."""

ROOMS = Path(__file__).parents[2]
"""Where the folders of the source are."""

_OWN = re.compile(r"[0-9a-f]{16}/.*|.*/[0-9a-f]{16,64}|.*/.*[0-9a-f]{40}\.(kept|lock)|unpacked/\d+")
"""Paths of what is kept, below the cache: digests of what it is made from, or processes.

Nothing else is removed: somebody may have named a folder in which other things lie too.
"""

_DIGEST = hashlib.sha256().digest_size
_GENERATORS = ("casadi", "pythonfmu")
_BYTE_CODE = "__pycache__"
"""Folders that Python writes while it runs, at times into files that are gone a moment later."""

Made = TypeVar("Made")


def kept(folder: str, made_from: object, make: Callable[[], bytes]) -> bytes:
    """What was made before from the same things; else it is made, and kept where that is possible.

    The folder lies below the cache; `made_from` is everything that it depends on, told apart by its `repr`.
    While one process makes it, others that want it wait.
    """
    content = kept_before(folder, made_from)
    if content is None:
        held = _alone(folder, made_from)
        try:
            content = kept_before(folder, made_from)  # which another process has made meanwhile
            if content is None:
                content = make()
                with suppress(OSError, InputError):
                    _write(folder, made_from, content)
        finally:
            unlock(held)
        make_room()
    return content


def remembered(folder: str, made_from: object, make: Callable[[], Made]) -> Made:
    """As `kept`, of an object that can be pickled, which this state of the source makes from the same.

    Nobody waits for another process that makes the same: that takes as long as making it.
    """
    asked = source_state(), made_from
    with suppress(Exception):  # nothing, another Python's file, or what no `repr` tells
        found: Made = pickle.loads(kept_before(folder, asked) or b"")
        return found
    made = make()
    with suppress(Exception):  # the disk is full, or this is no object that can be pickled
        _write(folder, asked, pickle.dumps(made))
    return made


def _write(folder: str, made_from: object, content: bytes) -> None:
    place = _place(folder, made_from)
    place.parent.mkdir(parents=True, exist_ok=True)
    sweep(place.parent, WRITING)
    with whole_file(place) as scratch:
        # A damaged library would end the process that loads it.
        scratch.write_bytes(hashlib.sha256(content).digest() + content)


def kept_before(folder: str, made_from: object) -> bytes | None:
    """What `kept` has made from the same things before; None where it has not, or its file is damaged."""
    with suppress(InputError):
        place = _place(folder, made_from)
        for root in (cache_folder(), wanted_cache_folder()):  # which may be read-only
            path = root / folder / place.name
            if others_may_write(root, path.parent):  # what lies there may be a stranger's code
                continue
            with suppress(OSError):
                file = path.read_bytes()
                digest, content = file[:_DIGEST], file[_DIGEST:]
                if hashlib.sha256(content).digest() == digest:
                    used(path)
                    return content
    return None


def vouch(file: Path) -> None:
    """Keep the digest of a complete file beside it, by which `undamaged` tells whether it still is."""
    with whole_file(_digest_of(file)) as scratch:
        scratch.write_text(file_digest(file), encoding="ascii")


def undamaged(file: Path) -> bool:
    """Whether a file in the cache is what was written there, bit for bit, and nobody else may change it.

    It is read once in a process, as long as it does not change.
    """
    roots = (root for root in (wanted_cache_folder(), *file.parents) if file.is_relative_to(root))
    with suppress(OSError, ValueError):
        if not others_may_write(next(roots), file.parent):
            return _digest_of(file).read_bytes() == file_digest(file).encode()
    return False


def _digest_of(file: Path) -> Path:
    return file.with_name(f"{file.name}.sha256")


def used(path: Path) -> None:
    """Note that something in the cache is used, so that it does not go."""
    with suppress(OSError):  # a cache that was filled before may be read-only
        os.utime(path)


def make_room() -> None:
    """Remove what was not used for longest until the cache keeps its limit; done once an hour.

    InputError if the limit is no size.
    """
    given = os.environ.get(LIMIT_VARIABLE, str(_LIMIT_MB))
    try:
        left = 1e6 * float(given)
    except ValueError:
        left = -1.0
    if not left >= 0:
        raise InputError(f"{LIMIT_VARIABLE} is {given!r}: not a size; give one in MB, as {_LIMIT_MB:g}")
    entries = []
    with suppress(OSError, InputError):  # there is no cache
        folder = cache_folder()
        if _has_room(folder / "room", left):
            return
        for path in folder.glob("*/*"):
            if _OWN.fullmatch(path.relative_to(folder).as_posix()):
                with suppress(OSError):  # another process is making room too
                    entries.append(_last_used(path))
    for when, size, path in sorted(entries, reverse=True):
        left -= size
        if left < 0 and when < time.time() - _IN_USE_S:
            shutil.rmtree(path, ignore_errors=True)
            with suppress(OSError):  # it was a folder
                path.unlink()


def _has_room(note: Path, limit: float) -> bool:
    """Whether room was made lately within the same limit; it is noted that it is made now."""
    with suppress(OSError):
        if note.read_text("ascii") == f"{limit:g}" and time.time() - note.stat().st_mtime < _LOOK_AGAIN_S:
            return True
    note.write_text(f"{limit:g}", "ascii")
    return False


def _last_used(entry: Path) -> tuple[float, int, Path]:
    """When a file or folder was last used, its size in bytes, and itself."""
    own = entry.lstat()
    inside = [path.lstat() for path in entry.rglob("*") if not path.is_dir()] if entry.is_dir() else []
    read = inside if entry.is_dir() else [own]  # a folder counts as read whenever it is listed, as here
    times = [*(each.st_atime for each in read), *(each.st_mtime for each in (*inside, own))]
    return max(times), sum(each.st_size for each in (*inside, own)), entry


def _place(folder: str, made_from: object) -> Path:
    return cache_folder() / folder / f"{hashlib.sha256(repr(made_from).encode()).hexdigest()}.kept"


def _alone(folder: str, made_from: object) -> int | None:
    """A lock that one alone holds who makes a thing; None where there can be none."""
    with suppress(OSError, InputError):
        file = _place(folder, made_from).with_suffix(".lock")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
        return lock(file, wait=True)[0]
    return None


def cache_folder() -> Path:
    """Folder for built FMUs: the one wanted, or where that will not do, one among temporary files.

    What a cache holds that was filled before and is read-only is used all the same.
    InputError if the other folder cannot be made either, or belongs to somebody else.
    """
    wanted = wanted_cache_folder()
    with suppress(OSError):
        if not wanted.is_dir():  # asked first, since that costs a twentieth
            wanted.mkdir(mode=0o700, parents=True, exist_ok=True)
    if unfit() is None:
        return wanted
    import tempfile

    own = os.getuid() if hasattr(os, "getuid") else 0
    other = Path(tempfile.gettempdir()) / f"warmlink-cache-{own}"
    with suppress(OSError):
        other.mkdir(mode=0o700, exist_ok=True)
        if not other.is_symlink() and other.stat().st_uid == own and not others_may_write(other):
            return other
    raise InputError(f"{wanted}: {unfit()}; name a folder for built FMUs in {CACHE_VARIABLE}")


def unfit() -> str | None:
    """Why nothing is kept in the folder that is wanted; None where it is."""
    wanted = wanted_cache_folder()
    if not wanted.is_dir() or not os.access(wanted, os.W_OK):
        return "cannot be written"
    return (
        "others may write to it, and code from there would run with your rights"
        if others_may_write(wanted)
        else None
    )


def wanted_cache_folder() -> Path:
    """Folder for built FMUs: `WARMLINK_CACHE`, or warmlink's place in the user's cache."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named).absolute()  # an FMU in Python goes to a folder of its own while it begins
    base = os.environ.get("XDG_CACHE_HOME")
    home = Path(os.sep)  # of who has none, as containers say it
    with suppress(RuntimeError):
        home = Path.home()
    return (Path(base) if base else home / ".cache") / "warmlink"


@cache
def source_state() -> str:
    """Digest of the sizes and times of the source's files, found sooner than one of what they hold.

    Of the times of their last change too, since packages may give all their files one time.
    """
    origins = [spec.origin for spec in map(find_spec, _GENERATORS) if spec is not None and spec.origin]
    told = [_facts(origin, Path(origin).stat()) for origin in origins]
    folders = [str(ROOMS / name) for name in ("fmus", "controllers", "orchestration")]
    while folders:
        held = list(os.scandir(folders.pop()))
        folders += [each.path for each in held if each.is_dir() and each.name != _BYTE_CODE]
        told += [_facts(each.path, each.stat()) for each in held if not each.is_dir()]
    return hashlib.sha256(repr(sorted(told)).encode()).hexdigest()


def _facts(path: str, of: os.stat_result) -> tuple[str, int, int, int]:
    return path, of.st_size, of.st_mtime_ns, of.st_ctime_ns


def source_digest() -> str:
    """Digest of everything that FMUs are built from, so that a changed equation is never run stale."""
    return kept("digests", source_state(), _source_digest).decode()


@cache
def _source_digest() -> bytes:
    from importlib.metadata import version

    digest = hashlib.sha256()
    for package in _GENERATORS:
        digest.update(f"{package} {version(package)}\n".encode())
    for root in (ROOMS / "fmus", ROOMS / "controllers"):
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.parent.name != _BYTE_CODE:
                digest.update(path.relative_to(root).as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16].encode()
