"""Runs as real loggers write them: uneven rows, a room that is never quite still, a pad that is regulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.practice.effects import CHANNELS
from warmlink.orchestration.diagnosis.practice.hidden import COLD, Truth, simulate
from warmlink.orchestration.diagnosis.practice.hide import write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment
from warmlink.orchestration.system.units import ZERO_CELSIUS

Columns = dict[str, np.ndarray]

PADDED = (
    Segment(900, 2.0, 2.5),
    Segment.with_pad(1500, COLD + 28),
    Segment(600, 0.0, 4.0),
    Segment(1200, 4.0, 1.0),
    Segment.with_pad(900, COLD + 35, 1.5, 3.0),
    Segment(900, 3.43, 2.5),
)
"""A hundred minutes with the heating pad on twice, once while the motor works."""

HALF = tuple(replace(segment, duration=segment.duration / 2) for segment in PADDED)
"""The same changes in half the time."""


@dataclass(frozen=True)
class Logger:
    """How a run is logged.

    Attributes
    ----------
    interval, jitter : s between rows, and by how much a row may come early or late
    room, pad_noise : K by which the room wanders, and noise of the pad's logged temperature
    """

    interval: float = 10.0
    jitter: float = 0.0
    room: float = 0.0
    pad_noise: float = 0.0


def logged_inputs(logger: Logger, seed: int, duty: Sequence[Segment] = PADDED) -> tuple[Columns, Truth]:
    """Times and inputs by header, and a cell in the room that wandered; a row where the duty changes."""
    random = np.random.default_rng(seed)
    ends = np.cumsum([segment.duration for segment in duty])
    count = int(ends[-1] / logger.interval)
    rows = logger.interval * np.arange(count) + logger.jitter * random.uniform(-1, 1, count)
    rows = np.union1d(np.round(rows[rows > 1.0], 2), [0.0, *ends])
    phase = random.uniform(0, 2 * np.pi)

    def room(time: float) -> float:
        return logger.room * float(np.sin(2 * np.pi * time / 3000 + phase) - np.sin(phase))

    at = [duty[i] for i in np.clip(np.searchsorted(ends, rows, side="right"), 0, len(duty) - 1)]
    pad = np.array([s.pad for s in at]) - ZERO_CELSIUS
    columns = {
        "time [s]": rows,
        "speed [rad/s]": np.array([s.speed for s in at]),
        "torque [N.m]": np.array([s.torque for s in at]),
        "pad_temperature [degC]": pad + logger.pad_noise * random.standard_normal(rows.size),
        "ambient_temperature [degC]": np.array([COLD - ZERO_CELSIUS + room(t) for t in rows]),
    }
    return columns, Truth(room=room)


def logged_file(folder: Path, effect: Mapping[str, Any], logger: Logger, seed: int) -> Path:
    """A CSV file of a cell with an effect, a field of `Truth` in SI, as the logger writes it."""
    columns, cell = logged_inputs(logger, seed)
    rows = columns["time [s]"]
    course = simulate(replace(cell, **effect), list(PADDED), rows)
    random = np.random.default_rng(seed)
    true = (course.shaft, course.winding, course.base, course.middle, course.tip)
    for name, values in zip(CHANNELS, true, strict=True):
        columns[f"{name} [degC]"] = values - ZERO_CELSIUS + 0.08 * random.standard_normal(rows.size)
    columns["elongation [um]"] = 1e6 * course.elongation + 0.4 * random.standard_normal(rows.size)
    path = folder / "logged.csv"
    write_csv(columns, path)
    return path


def logged_run(logger: Logger, seed: int, duty: Sequence[Segment] = PADDED) -> Run:
    """Inputs alone, of which a run is simulated."""
    columns, _ = logged_inputs(logger, seed, duty)
    time, speed, torque, pad, ambient = columns.values()
    inputs = {
        "motor.speed": speed,
        "motor.torque": torque,
        "motor.pad_temperature": pad + ZERO_CELSIUS,
        "motor.ambient_temperature": ambient + ZERO_CELSIUS,
    }
    return Run("logged", time, inputs, {})


def sticking(course: np.ndarray, band: float) -> np.ndarray:
    """Readings of a sensor that follows once it is off by more than the band."""
    held = [course[0]]
    for value in course[1:]:
        held.append(value if abs(value - held[-1]) > band else held[-1])
    return np.array(held)
