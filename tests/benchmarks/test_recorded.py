"""What a recorded duty costs."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import recorded


def test_a_step_costs_the_same_in_a_short_and_in_a_long_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorded, "STEPS", 20_000)
    monkeypatch.setattr(recorded, "PYTHON_STEPS", 200)
    short, long = (recorded.measured(rows, True, tmp_path) for rows in (1_000, 100_000))
    assert long.table_mb == pytest.approx(100 * short.table_mb, rel=0.05)
    assert long.python_us < 5 * short.python_us
    assert len(str(short)) == len(recorded.HEAD)
