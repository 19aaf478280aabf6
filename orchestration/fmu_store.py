"""The FMUs that a run needs: those of earlier runs are used again, missing ones are built."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

from warmlink.controllers.own import check_symbols
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError, NoRoomError, in_one_line
from warmlink.fmus.files import WRITING, sweep
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import (
    CACHE_VARIABLE,
    cache_folder,
    source_digest,
    undamaged,
    unfit,
    used,
    vouch,
    wanted_cache_folder,
)
from warmlink.fmus.packaging.trust import others_may_write
from warmlink.orchestration.catalogue import Controller, Entry, entries
from warmlink.orchestration.progress import progress_bar

FmuKind = Literal["native", "python"]
FMU_KINDS: tuple[FmuKind, ...] = ("native", "python")

Remark = Callable[[str], None]


class BuildProgress:
    """Progress of so many things that are made, some at the same time: which, and how many are left."""

    def __init__(self, progress: Callable[..., None], total: int) -> None:
        self._progress, self._total, self._left = progress, total, total
        self._names: list[str] = []

    def begun(self, name: str) -> None:
        """Say that one is being made."""
        self._names.append(name)
        self._show()

    def done(self, name: str) -> None:
        """Say that one is made."""
        if name in self._names:
            self._names.remove(name)
        self._left -= 1
        self._show()

    def _show(self) -> None:
        left = f"{self._left} left"
        self._progress(
            1 - self._left / self._total, ": ".join([left, *filter(None, [", ".join(self._names)])])
        )


@dataclass(frozen=True)
class FmuStore:
    """FMUs of one kind, kept in a folder of the user's cache under a digest of what they are built from."""

    kind: FmuKind
    root: Path = field(default_factory=cache_folder)

    @cached_property
    def folder(self) -> Path:
        """Folder of this version's FMUs of this kind."""
        return self.root / source_digest() / self.kind

    @property
    def _shared(self) -> Path:
        """The same in the folder that is wanted, which may have been filled before and be read-only."""
        shared = self.root == cache_folder()
        return wanted_cache_folder() / source_digest() / self.kind if shared else self.folder

    def file(self, name: str | Path) -> Path:
        """Where a file is, or is to be made."""
        held = self._shared / name
        return held if undamaged(held) else self.folder / name

    def files(self, names: Iterable[str], remark: Remark | None = None) -> dict[str, Path]:
        """File of each component by name; what is missing is built first.

        InputError if native FMUs are asked for and nothing on this machine can compile them, NoRoomError if
        there is no room for them.
        """
        wanted = {name: self.file(_place(entries()[name])) for name in names}
        used(self.folder)
        # A computer that loses its power may leave files without their content, a disk flips bits.
        missing = [entries()[name] for name, path in wanted.items() if not undamaged(path)]
        if missing and remark is not None:
            if self.folder != self._shared and self._shared.is_dir():
                remark(_elsewhere())
            ending = "s" if len(missing) > 1 else ""
            remark(f"building {len(missing)} {self.kind} FMU{ending}, once for this version")
        if missing:
            self.build([entry for entry in missing if not entry.added], self.folder)
        for entry in missing:
            if entry.added:
                self.build([entry], self.folder / _place(entry).parent)
        return wanted

    def of_controller(self, law: Controller) -> dict[str, Path]:
        """FMU of a user's own law by its component's name, built if it is missing; empty for a shipped law.

        InputError if the law does not become an FMU of this kind.
        """
        if not law.place:
            return {}
        name, own = law.component.name, Path("own") / law.digest
        path = self.file(own / f"{name}.fmu")
        if undamaged(path):
            return {name: path}
        try:
            if self.kind == "native":
                check_symbols(law.component)
            return {name: self.build([Entry(law.component, law.module)], self.folder / own)[0]}
        except InputError:
            raise
        except Exception as fault:
            raise InputError(
                f"{law.place}: does not become a {self.kind} FMU ({type(fault).__name__}: "
                f"{in_one_line(fault)}); write the law in plain arithmetic with "
                "warmlink.fmus.component.arithmetic, where() instead of if"
            ) from fault

    def build(self, missing: Sequence[Entry], folder: Path) -> list[Path]:
        """Build components' FMUs into a folder of the store; raises as `files`."""
        from warmlink.fmus.packaging.native.fmu import build_native_fmus
        from warmlink.fmus.packaging.python.fmu import build_python_fmus

        try:
            sweep(folder, WRITING)
            with progress_bar(f"Building {self.kind} FMUs") as progress:
                at_work = BuildProgress(progress, len(missing))
                if self.kind == "python":
                    built = build_python_fmus(missing, folder, at_work.done)
                else:
                    built = build_native_fmus(missing, folder, progress=at_work.done, begun=at_work.begun)
            for path in built:
                vouch(path)
            return built
        except OSError as fault:
            told = f"cannot be written ({fault.strerror}); free space there, or name another folder in"
            raise NoRoomError(f"{folder}: {told} {CACHE_VARIABLE}") from None


def _place(entry: Entry) -> Path:
    """Where a component's FMU is kept; that of another package's under the digest of its code."""
    return Path(*(["added", entry.digest] if entry.added else []), f"{entry.component.name}.fmu")


def fmu_files(components: str | Component | Iterable[str | Component]) -> dict[str, Path]:
    """Give native FMUs (FMI 2.0) of components for this machine, from the cache; missing ones are built.

    They are for use where they are: what is to be passed on is written by `build`.

    Parameters
    ----------
    components : names of components and controllers, as `ThermalLink`, and components of one's own, which
        NAME.md in the current folder documents, if there is one

    Returns
    -------
    dict
        path of each FMU by its component's name

    Raises
    ------
    InputError
        If there is no component of a name, two have one name, or no compiler is found.

    Examples
    --------
    >>> wl.fmu_files(["MotorHeatSource", "ThermalLink"])["ThermalLink"]
    """
    native, wanted = FmuStore("native"), dict[str, Entry]()
    for each in [components] if isinstance(components, str | Component) else components:
        name = each if isinstance(each, str) else each.name
        if isinstance(each, str) and name not in entries():
            raise InputError(f"{name}: there is no component of this name; {instead(name, entries())}")
        if name in wanted:
            raise InputError(f"{name}: two components of this name; rename one, or leave it out")
        wanted[name] = entries()[name] if isinstance(each, str) else Entry(each, "__main__")
    native.files([name for name, entry in wanted.items() if entry == entries().get(name)])
    return {name: own_file(native, entry) for name, entry in wanted.items()}


def own_file(native: FmuStore, entry: Entry) -> Path:
    """FMU of a component; one's own is kept under the digest of its code, variables and texts."""
    from warmlink.fmus.packaging.beside import files_beside
    from warmlink.fmus.packaging.model_description import model_description
    from warmlink.fmus.packaging.native.fmu import native_sources
    from warmlink.fmus.packaging.views import opened

    name = f"{entry.component.name}.fmu"
    if entry == entries().get(entry.component.name):
        return native.file(_place(entry))
    _, implementation = native_sources(entry.component, "2.0")
    described = model_description(opened(entry.component), implementation=implementation)
    contents = b"".join([described, *files_beside(entry).values()])
    place = Path("own") / hashlib.sha256(contents).hexdigest()[:16]
    path = native.file(place / name)
    return path if undamaged(path) else native.build([entry], native.folder / place)[0]


def kind_named(name: str | None) -> FmuKind | None:
    """Kind of FMU by its name, None if none was given; raises InputError if no kind has that name."""
    if name not in (None, *FMU_KINDS):
        raise InputError(f"{argument('fmus', name)}: no such kind; {instead(str(name), FMU_KINDS)}")
    return name


def store(kind: str | None, names: Iterable[str], remark: Remark) -> FmuStore:
    """Store of the kind asked for; unasked, native, or with a remark Python where nothing compiles.

    InputError if there is no such kind.
    """
    asked = kind_named(kind)
    filled = wanted_cache_folder() / source_digest()
    if cache_folder() != wanted_cache_folder() and (others_may_write(filled) or not filled.is_dir()):
        remark(_elsewhere())
    if asked is not None:
        return FmuStore(asked)
    native = FmuStore("native")
    try:
        native.files(names, remark)
    except NoRoomError:
        raise
    except InputError as fault:
        remark(f"{fault}; using the Python FMUs meanwhile")
        return FmuStore("python")
    return native


def _elsewhere() -> str:
    """Where FMUs go that cannot go where it is wanted."""
    return (
        f"{wanted_cache_folder()}: {unfit()}; built FMUs go to {cache_folder()}; "
        f"to keep them, name a folder in {CACHE_VARIABLE}"
    )
