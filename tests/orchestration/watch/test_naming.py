"""What an alarm is put down to."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from benchmarks.strange_machine import Machine, Room
from benchmarks.watch import WatchedCell, rows_of
from tests.orchestration.watch.conftest import BASE, SLIPS, SOUND, WORK
from warmlink.orchestration.watch.naming import Explanation, Naming

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes


def explanation(name: str, evidence: float, level: float) -> Explanation:
    return Explanation(name, cast(Any, None), 1.0, 0.1, evidence, 0.0, level)


@pytest.mark.parametrize(
    ("evidence", "level", "named"),
    [(150.0, 0.2, "joint"), (250.0, 0.2, "clock"), (150.0, 0.8, "clock"), (90.0, 0.8, "joint")],
)
def test_a_cause_is_believed_by_its_test_or_by_twice_the_evidence(
    evidence: float, level: float, named: str
) -> None:
    both = explanation("joint", 100.0, 1.0), explanation("clock", evidence, level)
    found = Naming.of({each.name: (each, 200.0) for each in both})
    assert found.ranked[0].name == named
    assert [each.name for each in found.set][:1] == [named] or found.ranked[0].evidence < 100


def test_where_no_test_leans_no_cause_is_named() -> None:
    assert Naming.of({"clock": (explanation("clock", 900.0, 0.1), 900.0)}).set == ()
    assert Naming.of({}).set == ()


def test_readings_that_come_late_by_a_tick_are_the_clock_s_from_when_they_do(
    sound_cell: tuple[WatchedCell, np.ndarray], table: np.ndarray
) -> None:
    """They lag behind what this tick rises by and behind what the one before did."""
    cell, begins = sound_cell[0].fork(), 3600 * (SOUND + 0.3)
    sound = table.copy()
    sound[sound[:, 0] > 3600 * SLIPS, BASE] -= 3.0
    late = rows_of(Machine(4).run(WORK, 4, Room()), np.random.default_rng(4), late=60.0)[::3][: len(table)]
    rows = np.where((sound[:, 0] > begins)[:, None], late, sound)[-len(sound_cell[1]) :]
    for row in rows.tolist():
        read = cell.reader.read(row)
        assert read is not None
        for tick in cell.gatherer.add(read):
            list(cell.watcher.add(tick))
    best = max(cell.watcher.named().ranked, key=lambda each: each.evidence)
    assert best.name == "clock_offset"
    assert best.since == pytest.approx(begins, abs=120.0)
    assert best.value > 5 * best.std
