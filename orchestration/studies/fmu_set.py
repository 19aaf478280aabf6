"""The FMUs of a study as one value, which can be sent to workers on this machine and on others."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

from warmlink.fmus.packaging.cache import cache_folder
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.orchestration.fmu_store import FmuKind


@dataclass(frozen=True)
class FmuSet:
    """Contents of FMUs by the component's name.

    Attributes
    ----------
    rollouts : joined systems that run in place of the FMUs, by the component behind the controllers
    """

    kind: FmuKind
    contents: Mapping[str, bytes] = field(repr=False)
    rollouts: Mapping[str, Rollout] = field(default_factory=dict, repr=False)

    @classmethod
    def read(cls, kind: FmuKind, files: Mapping[str, Path]) -> FmuSet:
        """Take FMUs from their files."""
        return cls(kind, {name: path.read_bytes() for name, path in sorted(files.items())})

    @cached_property
    def digest(self) -> str:
        """Digest of names and contents."""
        digest = hashlib.sha256()
        joined = {f"{law} joined": rollout.library for law, rollout in self.rollouts.items()}
        for name, content in sorted({**self.contents, **joined}.items()):
            digest.update(f"{name}\0{len(content)}\0".encode() + content)
        return digest.hexdigest()[:16]

    @property
    def unpacked(self) -> Path:
        """Folder in which runs on this machine unpack them, once."""
        return _folder(self.digest) / "unpacked"

    def files(self) -> dict[str, Path]:
        """Files of the FMUs on this machine, written where they are missing."""
        return _written(self.digest, tuple(sorted(self.contents.items())))


@lru_cache(maxsize=4)
def _written(digest: str, contents: Iterable[tuple[str, bytes]]) -> dict[str, Path]:
    folder = _folder(digest)
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for name, content in contents:
        files[name] = folder / f"{name}.fmu"
        if not files[name].is_file():
            # Several workers may do this at once: each writes its own file, and any of the files will do.
            handle, scratch = tempfile.mkstemp(dir=folder)
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
            Path(scratch).replace(files[name])
    return files


def _folder(digest: str) -> Path:
    return cache_folder() / "studies" / digest
