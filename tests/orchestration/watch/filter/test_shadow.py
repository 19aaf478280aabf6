"""Rows do not say when between them work began or ended, and the filter knows that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.watch import WatchedCell
from tests.orchestration.watch.conftest import RATE, SOUND
from warmlink.orchestration.watch.filter.shadow import Shadow
from warmlink.orchestration.watch.learning import surprise_of
from warmlink.orchestration.watch.ticks import Tick

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes


def ticks_of(cell: WatchedCell, table: np.ndarray) -> list[Tick]:
    read = (cell.reader.read(row) for row in table.tolist())
    return [tick for each in read if each is not None for tick in cell.gatherer.add(each)]


def is_switch(tick: Tick) -> bool:
    return len(tick.shares) > 1


def test_a_moment_of_switching_moves_the_states_as_an_earlier_row_would(
    sound_cell: tuple[WatchedCell, np.ndarray], table: np.ndarray
) -> None:
    learnt, machine = sound_cell[0].watcher.learnt, sound_cell[0].watcher.machine
    assert learnt is not None
    earlier, early = table.copy(), 5.0
    begins = int(np.argmax((table[1:, 1] > 0) & (table[:-1, 1] == 0) & (table[:-1, 0] > 3600))) + 1
    earlier[begins, 0] -= early
    found = []
    for each in (table, earlier):
        shadow = Shadow(machine, learnt.noise, learnt.values, learnt.offsets, learnt.weights)
        nothing = np.full(len(machine.outputs), np.nan)
        for tick in ticks_of(WatchedCell.made(4, SOUND / 24, RATE), each[: begins + 6]):
            seen = tick if tick.end < table[begins, 0] else tick._replace(readings=nothing)
            linear = shadow.step(seen)[1]
            if tick.end > table[begins, 0]:
                break
        assert is_switch(tick)
        found.append((shadow.x, linear.onward[: shadow.plant, shadow.plant + shadow.signals]))
    (one, by_switch), (other, _) = found
    winding = int(np.argmax(np.abs(by_switch)))
    assert by_switch[winding] > 0.01, "K/s: the current warms the winding"
    np.testing.assert_allclose(other - one, early * by_switch, rtol=0.02, atol=1e-3 * early * by_switch.max())


def test_readings_surprise_no_more_where_work_begins_or_ends(
    sound_cell: tuple[WatchedCell, np.ndarray], table: np.ndarray
) -> None:
    learnt, machine = sound_cell[0].watcher.learnt, sound_cell[0].watcher.machine
    assert learnt is not None
    ticks = ticks_of(WatchedCell.made(4, SOUND / 24, RATE), table[table[:, 0] < 3600 * SOUND])
    certain = replace(learnt.noise, switching=np.zeros(1))
    surprises = []
    for noise in (learnt.noise, certain):
        shadow = Shadow(machine, noise, learnt.values, learnt.offsets, learnt.weights)
        said = [surprise_of(shadow.step(tick)[0].white) for tick in ticks]
        surprises.append(np.median([s for s, t in zip(said, ticks, strict=True) if is_switch(t)]))
    assert surprises[0] < 1.0
    assert surprises[1] > 2.0
