"""Damaged files of the cache change no figure, in a few runs of the benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.damage import tried
from tests.filled import cell_fmus, fill


@pytest.mark.slow
def test_figures_stay_the_same(tmp_path: Path) -> None:
    fill(tmp_path / "cache", cell_fmus("lag"))
    assert tried(3, 3, tmp_path / "cache") == {"same": 3}
