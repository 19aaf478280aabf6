"""What is learnt from the sound part is judged as it will be used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.watch import WatchedCell
from tests.orchestration.watch.conftest import RATE, SOUND
from warmlink.orchestration.watch import learning
from warmlink.orchestration.watch.ticks import Tick

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes

TICKS = 120


def sound_ticks(table: np.ndarray) -> list[Tick]:
    made = WatchedCell.made(4, SOUND / 24, RATE)
    found = list[Tick]()
    for row in table.tolist():
        read = made.reader.read(row)
        assert read is not None
        found += made.gatherer.add(read)
        if len(found) >= TICKS:
            break
    return found


def test_what_is_frozen_is_what_is_judged(
    sound_cell: tuple[WatchedCell, np.ndarray], table: np.ndarray
) -> None:
    """Not what one more step of the search would make of it: thresholds of that would be too low."""
    machine, learnt = sound_cell[0].watcher.machine, sound_cell[0].watcher.learnt
    assert learnt is not None
    nothing = learning._Calibration(np.zeros_like(learnt.moved), np.zeros_like(learnt.weights))
    noise = replace(learnt.noise, stirred=np.zeros_like(learnt.noise.stirred))  # so that values have to move
    passed = learning._pass(machine, noise, nothing, sound_ticks(table))
    fit = learning._Fit(machine, noise, nothing, passed)
    held = np.concatenate([rows[:, 0] for rows in fit.held_out()])
    every = np.concatenate(fit._rows)
    seen, a_step_on = every[:, 0], every[:, 0] - every[:, 1:][:, fit._free] @ fit._found()
    assert np.mean(a_step_on**2) < 0.5 * np.mean(seen**2)
    assert np.mean(held**2) > 0.8 * np.mean(seen**2)
