"""Caches of tests' own that hold what is compiled already, where a test is not about compiling."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import vouch
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL


def cell_fmus(law: str) -> dict[str, Path]:
    """Native FMUs of the cell with a law, of the tests' cache; the test is skipped without a compiler."""
    try:
        return FmuStore("native").files(WARMUP_CELL.parts_with(controller(law).name).values())
    except InputError as fault:
        pytest.skip(str(fault))


def fill(cache: Path, fmus: Mapping[str, Path]) -> None:
    """Let another cache hold native FMUs, as if they had been built for it."""
    folder = FmuStore("native", cache).folder
    folder.mkdir(parents=True)
    for file in fmus.values():
        vouch(Path(shutil.copy(file, folder)))
