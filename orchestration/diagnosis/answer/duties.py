"""Duty cycles that a warm-up cell can be asked to go through to learn more about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.diagnosis.data.measured import Run

ROOM = 295.15


@dataclass(frozen=True)
class Stage:
    """Part of a duty cycle: s, rad/s, N.m, and temperatures in K."""

    duration_s: float
    speed: float
    torque: float
    pad_temperature: float | None = None
    ambient_temperature: float = ROOM


_REST = Stage(900, 0.0, 0.0)
_FAST = Stage(1500, 4.5, 0.5)
_HEAVY = Stage(1500, 1.0, 5.0)
_STALL = Stage(1500, 0.0, 4.5)
_BOTH = Stage(1500, 3.43, 2.5)
_PAD = Stage(1500, 0.0, 0.0, ROOM + 35)
_LONG_REST = Stage(2700, 0.0, 0.0)
_HOT = Stage(2700, 0.0, 4.5, ROOM + 60)  # pad and winding together: the shaft 45 K warm, the winding 80 K
_HOT_FAST = Stage(2700, 4.5, 2.5, ROOM + 60)

DUTIES: tuple[tuple[Stage, ...], ...] = (
    (_REST, _BOTH, _LONG_REST, _FAST),
    (_FAST, _REST, _HEAVY, _REST, _PAD, _REST),
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
        replace(s, duration_s=600.0)
        for s in (_FAST, _REST, _HEAVY, _REST, _STALL, _REST, _PAD, _REST, _BOTH, _REST, _FAST, _REST)
    ),
    tuple(replace(s, duration_s=300.0) for s in (_BOTH, _REST, _PAD, _REST, _FAST, _REST, _HEAVY, _REST) * 3),
)
"""Feasible duty cycles of one to three hours."""


def length(duty: Sequence[Stage]) -> float:
    """Duration of a duty cycle in s."""
    return sum(stage.duration_s for stage in duty)


def run_of(duty: Sequence[Stage], variables: Sequence[str], share: float, interval: float) -> Run:
    """The opening share of a duty cycle as a run with rows an interval in s apart; its readings are 0."""
    ends = np.cumsum([stage.duration_s for stage in duty])
    time = np.arange(0.0, share * ends[-1] + interval / 2, interval)
    which = np.clip(np.searchsorted(ends, time, side="right"), 0, len(duty) - 1)
    stages = [duty[i] for i in which]
    pad = np.array([np.nan if s.pad_temperature is None else s.pad_temperature for s in stages])
    inputs = {
        "motor.speed": np.array([s.speed for s in stages]),
        "motor.torque": np.array([s.torque for s in stages]),
        "motor.ambient_temperature": np.array([s.ambient_temperature for s in stages]),
        "motor.pad_temperature": pad,
    }
    return Run("next", time, inputs, {v: np.zeros(time.size) for v in variables})
