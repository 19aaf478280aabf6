"""Damaged files of the cache change no figure, in a few runs of the benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.damage import tried
from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore


@pytest.mark.slow
def test_figures_stay_the_same(tmp_path: Path) -> None:
    try:
        FmuStore("native").files(["ThermalLink"])
    except InputError as fault:
        pytest.skip(str(fault))
    assert tried(4, 3, tmp_path / "cache") == {"same": 4}
