"""Reading other people's archives without trusting them.

An FMU or an SSP is a zip made by a stranger. Nothing here writes outside the folder asked for, follows a
link or fills the disk; whatever is wrong with a file becomes one `InputError` that names it.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import stat
import struct
import zipfile
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path

from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.files import file_digest, hold, let_go, sweep, whole_file
from warmlink.orchestration.files import write_all
from warmlink.orchestration.text_files import demand_file

# What zipfile raises on damaged input; OSError covers seeks to places that do not exist.
_ZIP_FAULTS = (
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
    zlib.error,
    struct.error,
    EOFError,
    RuntimeError,
    ValueError,
    OverflowError,
    IndexError,
    OSError,
)

_CHUNK = 1 << 20

UNPACKING = ".unpacking-"
"""How the names of folders begin that are not wholly unpacked yet."""

# How much an archive may hold, counted in what really comes out of it rather than in what it claims: entries,
# unpacked bytes of one and of all, and unpacked over packed size of one entry. Small files of equal bytes
# compress that well honestly, so that the ratio counts above some size.
MOST_MEMBERS = 20_000
MEMBER_BYTES = 1 << 30
TOTAL_BYTES = 4 << 30
RATIO, RATIO_FROM_BYTES = 300.0, 32 << 20

XML_LIMIT_BYTES = 16 << 20
DIRECTORY_LIMIT_BYTES = 16 << 20
"""For the list of an archive's entries, each of which takes about ten times as much in memory."""


class _Guarded(io.FileIO):
    """A file that caps the size of each read at that of the largest list of an archive's entries."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Read so many bytes, or what is left."""
        left = os.fstat(self.fileno()).st_size - self.tell()
        wanted = left if size is None or size < 0 else min(size, left)
        if wanted > DIRECTORY_LIMIT_BYTES + 1:
            raise zipfile.BadZipFile(f"its list of entries takes more than {DIRECTORY_LIMIT_BYTES >> 20} MiB")
        return super().read(wanted) or b""


@contextlib.contextmanager
def open_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open a zip; whatever goes wrong while it is open because of its bytes becomes an `InputError`."""
    _check_there(path)
    try:
        with _Guarded(path) as file, zipfile.ZipFile(file) as archive:
            yield archive
    except InputError:
        raise
    except _ZIP_FAULTS as fault:
        raise InputError(f"{path.name}: not a readable zip archive ({brief(fault)}); make it anew") from fault


def _check_there(path: Path) -> None:
    demand_file(path, "give the path of an .fmu or .ssp file")


def read_member(path: Path, name: str) -> bytes:
    """Give the bytes of one entry, of a size that is usual for XML; raises as `extract` for the rest."""
    with open_archive(path) as archive:
        try:
            info = archive.getinfo(name)
        except KeyError:
            raise InputError(
                f"{path.name}: holds no {name}; it is not a complete archive of its kind"
            ) from None
        _refuse_packing(path, info)
        with archive.open(info) as stream:
            data = stream.read(XML_LIMIT_BYTES + 1)
    if len(data) > XML_LIMIT_BYTES:
        raise InputError(
            f"{path.name}: {name} is larger than {XML_LIMIT_BYTES} bytes, the limit for it; make it smaller"
        )
    return data


def unpack(path: Path, workdir: Path, without: Collection[str] = ()) -> Path:
    """Unpack an archive as `extract` does into a folder of its own under `workdir`, and give that folder.

    The folder's name follows from the archive's bytes, so that the same archive is unpacked once and
    another one of the same name does not mix with it. Where it is there already, each file is compared with
    the archive's checksum of it, and written anew where it differs.
    """
    _check_there(path)
    target = workdir / f"{path.stem}-{file_digest(path)[:16]}"
    if target.is_dir():
        _mend(path, target, without)
    else:
        extract(path, target, without)
    return target


def repeated_entries(path: Path) -> tuple[str, ...]:
    """Give a remark on each entry that an archive holds more than once; raises as `extract` for the rest."""
    with open_archive(path) as archive:
        counts = Counter(info.filename for info in archive.infolist() if not info.is_dir())
    return tuple(
        f"{path.name}: holds {name[:80]!r} {'twice' if count == 2 else f'{count} times'}; the last one counts"
        for name, count in counts.items()
        if count > 1
    )


def holds_source_code(path: Path) -> bool:
    """Say whether an FMU holds source code, as one without any library may; raises as `extract`."""
    with open_archive(path) as archive:
        return any(name.startswith("sources/") and not name.endswith("/") for name in archive.namelist())


def _mend(path: Path, target: Path, without: Collection[str]) -> None:
    """Write those files anew that are no longer what the archive holds, as an FMU's library may be."""
    for folder, names, _ in os.walk(target):
        if "__pycache__" in names:  # nothing tells whether byte code is whole
            shutil.rmtree(Path(folder) / "__pycache__", ignore_errors=True)
    with open_archive(path) as archive:
        used = [info for info in archive.infolist() if info.filename.partition("/")[0] not in without]
        if all(info.is_dir() or _is_as_packed(f"{target}/{info.filename}", info) for info in used):
            return
        for name, info in _checked_members(path, archive, without):
            file = target / name
            if not _is_as_packed(file, info):
                with _room_in(file.parent, path):
                    file.parent.mkdir(parents=True, exist_ok=True)
                    with whole_file(file) as scratch:  # another process may have the old one loaded
                        scratch.unlink()
                        _write_member(path, archive, info, scratch, TOTAL_BYTES)


def _is_as_packed(file: str | Path, info: zipfile.ZipInfo) -> bool:
    """Whether a file has the size and the checksum of an entry."""
    with contextlib.suppress(OSError, ValueError), open(file, "rb") as stream:  # noqa: PTH123
        held = stream.read(info.file_size + 1)
        return len(held) == info.file_size and zlib.crc32(held) == info.CRC
    return False


def extract(path: Path, target: Path, without: Collection[str] = ()) -> None:
    """Unpack an archive into `target`, which must not exist; on failure nothing is left behind.

    Entries of the top-level folders named in `without` are looked at like all others, but not written.
    Of entries of one name the last one counts. InputError if the archive is damaged, an entry would land
    outside `target`, is a link or is encrypted, two entries that are spelt differently are the same file, or
    the limits are exceeded.
    """
    with _room_in(target.parent, path):
        target.parent.mkdir(parents=True, exist_ok=True)
        sweep(target.parent, UNPACKING)
        scratch, handle = hold(target.parent, UNPACKING)
    try:
        with open_archive(path) as archive:
            left = TOTAL_BYTES
            for name, info in _checked_members(path, archive, without):
                left -= _write_member(path, archive, info, scratch / name, left)
        # Another process may have unpacked the same archive meanwhile: then its result stands.
        with contextlib.suppress(OSError):
            scratch.replace(target)
        if not target.is_dir():
            raise InputError(f"{target}: cannot be created; choose another working folder")
    finally:
        let_go(scratch, handle)


def safe_relative(name: str) -> str | None:
    """Give a normalised relative path with forward slashes, or None if it would leave its folder."""
    parts = name.replace("\\", "/").split("/")
    if name.startswith(("/", "\\")) or re.match(r"^[A-Za-z]:", name) or "\0" in name:
        return None
    kept = [part for part in parts if part not in ("", ".")]
    if ".." in kept or any(len(os.fsencode(part)) > 255 for part in kept):
        return None
    return "/".join(kept)


def _checked_members(
    path: Path, archive: zipfile.ZipFile, without: Collection[str]
) -> list[tuple[str, zipfile.ZipInfo]]:
    """Entries of an archive that are files, by path, but for those of some top-level folders."""
    infos = archive.infolist()
    if len(infos) > MOST_MEMBERS:
        raise InputError(f"{path.name}: holds {len(infos)} entries, more than the {MOST_MEMBERS} allowed")
    members: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        name, entry = safe_relative(info.filename), f"{path.name}: its entry {info.filename!r}"
        if name is None:
            raise InputError(f"{entry} would be written outside the folder")
        if stat.S_IFMT(info.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise InputError(f"{entry} is a link or device, not a plain file")
        if info.flag_bits & 1:
            raise InputError(f"{entry} is encrypted; pack it without password")
        _refuse_packing(path, info)
        if info.is_dir() or info.filename.endswith("\\") or not name:
            continue
        if name in members and members[name].filename != info.filename:
            raise InputError(f"{path.name}: holds {name!r} in two spellings; which one counts is not defined")
        members[name] = info
    return [(name, info) for name, info in members.items() if name.partition("/")[0] not in without]


def _write_member(path: Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo, to: Path, left: int) -> int:
    """Write an entry as far as the limits allow, and give its size; `left` is what may be written in all."""
    written = 0
    with archive.open(info) as source:
        # A file where the archive has a folder too is the archive's own fault.
        with _room_in(to.parent, path, but=(FileExistsError, NotADirectoryError)):
            to.parent.mkdir(parents=True, exist_ok=True)
            # Without a buffer, whose rest would be written, and fail, when it is closed.
            sink = to.open("xb", buffering=0)
        with sink:
            while chunk := source.read(_CHUNK):
                written += len(chunk)
                _refuse_oversize(path, info, written, left)
                with _room_in(to.parent, path):
                    write_all(sink, chunk)
    return written


@contextlib.contextmanager
def _room_in(folder: Path, path: Path, but: tuple[type[OSError], ...] = ()) -> Iterator[None]:
    """Say where there is no room for what is unpacked; errors of the kinds `but` are passed on."""
    try:
        yield
    except OSError as fault:
        if isinstance(fault, but):
            raise
        raise NoRoomError(
            f"{path.name}: cannot be unpacked into {folder} ({fault.strerror}); free space there, or name "
            "another folder in TMPDIR"
        ) from None


def _refuse_packing(path: Path, info: zipfile.ZipInfo) -> None:
    """Refuse packing methods that FMI and SSP do not name; what they unpack to at once has no bound."""
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError(
            f"{path.name}: its entry {info.filename!r} is packed by another method than deflate; pack it anew"
        )


def _refuse_oversize(path: Path, info: zipfile.ZipInfo, written: int, left: int) -> None:
    entry = f"{path.name}: its entry {info.filename!r} unpacks to more than"
    if written > MEMBER_BYTES:
        raise InputError(f"{entry} {MEMBER_BYTES} bytes, the limit for one file")
    if written > left:
        raise InputError(f"{path.name}: unpacks to more than {TOTAL_BYTES} bytes, the limit for an archive")
    if written > RATIO_FROM_BYTES and written > RATIO * max(info.compress_size, 1):
        raise InputError(f"{entry} {RATIO:g} times its packed size, as only a zip bomb does")


def brief(fault: BaseException) -> str:
    """Give the first line of what a library said, short enough for one sentence."""
    lines = str(getattr(fault, "msg", fault)).splitlines() or [type(fault).__name__]
    return lines[0][:160]
