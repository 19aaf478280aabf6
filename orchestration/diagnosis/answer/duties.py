"""Duty cycles that a warm-up cell can follow so that more is learned about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.scenarios.duties.duty import Segment, demands_at, length

_REST = Segment(900)
_FAST = Segment(1500, 4.5, 0.5)
_HEAVY = Segment(1500, 1.0, 5.0)
_STALL = Segment(1500, 0.0, 4.5)
_BOTH = Segment(1500, 3.43, 2.5)
_PAD = Segment.with_pad(1500, ROOM_TEMPERATURE + 35)
_LONG_REST = Segment(2700)
# Pad and winding heat together: the shaft becomes 45 K warm, the winding 80 K.
_HOT = Segment.with_pad(2700, ROOM_TEMPERATURE + 60, 0.0, 4.5)
_HOT_FAST = Segment.with_pad(2700, ROOM_TEMPERATURE + 60, 4.5, 2.5)

ONE_AT_A_TIME = (_FAST, _REST, _HEAVY, _REST, _PAD, _REST)
"""Fast without load, slow under load, and heated by a pad, with rests between."""

DUTIES: tuple[tuple[Segment, ...], ...] = (
    (_REST, _BOTH, _LONG_REST, _FAST),
    ONE_AT_A_TIME,
    (_PAD, _LONG_REST, _STALL, _REST),
    (_HEAVY, _FAST, _HEAVY, _FAST),
    (_PAD, _FAST, _PAD, _REST),
    (_LONG_REST, _STALL, _FAST, _REST),
    (_STALL, _BOTH, _REST, _PAD),
    (_HOT, _LONG_REST),
    (_HOT_FAST, _LONG_REST),
    (_HOT, _REST, _HOT_FAST, _LONG_REST),
    (_HOT, _FAST, _LONG_REST),
    tuple(
        replace(s, duration=600.0)
        for s in (_FAST, _REST, _HEAVY, _REST, _STALL, _REST, _PAD, _REST, _BOTH, _REST, _FAST, _REST)
    ),
    tuple(replace(s, duration=300.0) for s in (_BOTH, _REST, _PAD, _REST, _FAST, _REST, _HEAVY, _REST) * 3),
)
"""Feasible duty cycles of one to three hours."""


def run_of(duty: Sequence[Segment], variables: Sequence[str], share: float, interval: float) -> Run:
    """Run over the first share of a duty cycle, with a row for each interval in s; its readings are 0."""
    time = np.arange(0.0, share * length(duty) + interval / 2, interval)
    inputs = {f"motor.{name}": values for name, values in demands_at(duty, time).items()}
    return Run("next", time, inputs, {v: np.zeros(time.size) for v in variables})
