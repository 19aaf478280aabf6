"""The FMUs that a run needs: found where an earlier run left them, built where they are missing."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from importlib import metadata, resources
from pathlib import Path
from typing import Literal

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.orchestration.catalogue import entries

FmuKind = Literal["native", "python"]
FMU_KINDS: tuple[FmuKind, ...] = ("native", "python")

CACHE_VARIABLE = "WARMLINK_CACHE"
"""Environment variable that names the folder for built FMUs."""

Remark = Callable[[str], None]


@dataclass(frozen=True)
class FmuStore:
    """FMUs of one kind, kept in a folder of the user's cache under a digest of what they are built from."""

    kind: FmuKind
    root: Path = field(default_factory=lambda: cache_folder())

    @cached_property
    def folder(self) -> Path:
        """Where this version's FMUs of this kind lie."""
        return self.root / source_digest() / self.kind

    def files(self, names: Iterable[str], remark: Remark | None = None) -> dict[str, Path]:
        """File of each component by name; what is missing is built first.

        Raises
        ------
        InputError
            If native FMUs are asked for and nothing on this machine can compile them.
        """
        wanted = {name: self.folder / f"{name}.fmu" for name in names}
        missing = [entries()[name] for name, path in wanted.items() if not path.is_file()]
        if missing:
            if remark is not None:
                remark(f"building {len(missing)} {self.kind} FMUs, once for this version")
            self._build(missing)
        return wanted

    def _build(self, missing: list[Entry]) -> None:
        if self.kind == "python":
            build_python_fmus(missing, self.folder.parent)
            return
        from warmlink.fmus.packaging.native.fmu import build_native_fmus

        build_native_fmus(missing, self.folder)


def kind_named(name: str | None) -> FmuKind | None:
    """Kind of FMU by its name, None unasked; raises InputError where there is none of that name."""
    for kind in FMU_KINDS:
        if kind == name:
            return kind
    if name is not None:
        raise InputError(f"--fmus {name}: no such kind; {instead(name, FMU_KINDS)}")
    return None


def store(kind: FmuKind | None, names: Iterable[str], remark: Remark) -> FmuStore:
    """Store of the kind asked for; unasked, native, or with a remark Python where nothing compiles."""
    if cache_folder() != wanted_cache_folder():
        remark(
            f"{wanted_cache_folder()}: cannot be written; built FMUs go to {cache_folder()}; "
            f"to keep them, name a folder in {CACHE_VARIABLE}"
        )
    if kind is not None:
        return FmuStore(kind)
    native = FmuStore("native")
    try:
        native.files(names, remark)
    except InputError as fault:
        remark(f"{fault}; using the Python FMUs meanwhile")
        return FmuStore("python")
    return native


def cache_folder() -> Path:
    """Folder for built FMUs: the one wanted, or where that cannot be written, one among temporary files.

    Raises
    ------
    InputError
        If the other folder cannot be made either, or belongs to somebody else.
    """
    wanted = wanted_cache_folder()
    with suppress(OSError):
        wanted.mkdir(parents=True, exist_ok=True)
    # A cache that was filled before may be read-only.
    if os.access(wanted, os.W_OK) or (wanted / source_digest()).is_dir():
        return wanted
    own = os.getuid() if hasattr(os, "getuid") else 0
    other = Path(tempfile.gettempdir()) / f"warmlink-cache-{own}"
    with suppress(OSError):
        other.mkdir(mode=0o700, exist_ok=True)
        if not other.is_symlink() and other.stat().st_uid == own:
            return other
    raise InputError(f"{wanted}: cannot be written; name a folder for built FMUs in {CACHE_VARIABLE}")


def wanted_cache_folder() -> Path:
    """Folder for built FMUs: `WARMLINK_CACHE`, or warmlink's place in the user's cache."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "warmlink"


def source_digest() -> str:
    """Digest of everything that FMUs are built from, so that a changed equation is never run stale."""
    digest = hashlib.sha256()
    for package in ("casadi", "pythonfmu"):
        digest.update(f"{package} {metadata.version(package)}\n".encode())
    for package in ("warmlink.fmus", "warmlink.controllers"):
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(path.relative_to(root).as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
