"""What a recorded duty costs."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import recorded


def test_what_a_short_and_a_long_table_cost_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorded, "STEPS", 20_000)
    monkeypatch.setattr(recorded, "PYTHON_STEPS", 200)
    short, long = (recorded.measured(rows, True, tmp_path) for rows in (1_000, 100_000))
    assert long.table_mb == pytest.approx(100 * short.table_mb, rel=0.05)
    assert min(long.python_us, short.python_us, long.native_us) > 0
    assert len(str(short)) == len(recorded.HEAD)
