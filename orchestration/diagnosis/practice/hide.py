"""Runs with a hidden effect, for practice and for tests."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.safe_text import as_cell
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.data.measured import MOST_DAYS
from warmlink.orchestration.diagnosis.practice.effects import (
    CHANNELS,
    TEMPERATURES,
    Readings,
    effect_of,
    with_changes,
)
from warmlink.orchestration.diagnosis.practice.hidden import COLD, Course, Truth, simulate
from warmlink.orchestration.diagnosis.practice.hidden_terms import HiddenTerm
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.scenarios.duties.duty import (
    PAD_POWER,
    Duty,
    Recorded,
    Segment,
    demands_at,
    length,
)
from warmlink.orchestration.system.units import ZERO_CELSIUS


@dataclass(frozen=True)
class Noise:
    """Noise of the instruments: 1 sigma in K and m; a share of the variance is correlated over `minute` s.

    Temperatures are rounded to steps of `quantum` in K, the elongation in um, 0 for none; `spikes` is the
    share of readings that are spikes of 10 to 30 sigma.
    """

    temperature: float = 0.08
    elongation: float = 0.4e-6
    correlated: float = 0.0
    minute: float = 60.0
    quantum: float = 0.0
    spikes: float = 0.0


WHITE = Noise()
REAL = Noise(correlated=0.3, quantum=0.1, spikes=0.002)

INFORMATIVE: tuple[Segment, ...] = (
    Segment(300),
    Segment(1200, 3.43, 2.5),
    Segment(480, ambient_temperature=COLD + 2),
    Segment.with_pad(720, COLD + 25, ambient_temperature=COLD + 2),
    Segment(480, 1.2, 5.0, COLD + 1),
    Segment(600, ambient_temperature=COLD + 1),
    Segment(720, 4.5, 0.5, COLD - 1),
    Segment(600, 0.0, 4.0, COLD - 1),
    Segment(900, 2.2, 3.2),
    Segment(600),
    Segment(600, 3.43, 2.5, COLD + 1),
)
"""Two hours in which every cause shows: rest, pad, torque without speed, speed without torque."""

STILL: tuple[Segment, ...] = (Segment.with_pad(3600, 36 + ZERO_CELSIUS),)
MOVING: tuple[Segment, ...] = (Segment.with_pad(3600, 42 + ZERO_CELSIUS, 3.43, 2.5),)
"""The paper's hours, which show little apart."""


def duty_of(name: str) -> tuple[Segment, ...]:
    """Duty cycle of a scenario by its name or file, as `warmlink run` takes it, up to its stop time.

    InputError is raised if there is none, it is too long to be logged, or it heats by a pad of given
    power.
    """
    duty = load_scenario(name).duty
    if not isinstance(duty, Duty | Recorded):
        raise InputError(
            f"{name}: is a program of the arm; give a duty cycle, or {argument('axis')} with the program"
        )
    if duty.stop_time > MOST_DAYS * 86400:
        raise InputError(f"{name}: lasts {duty.stop_time / 86400:.4g} days; give at most {MOST_DAYS:g}")
    segments = duty.unrolled()
    if any(segment.pad_mode == PAD_POWER for segment in segments):
        raise InputError(f"{name}: a run is made with a pad held at a temperature; give pad_temperature")
    return segments


def hide(
    effects: Mapping[str, float],
    duty: Sequence[Segment] = INFORMATIVE,
    noise: Noise = WHITE,
    interval: float = 10.0,
    seed: int = 0,
    solver: Callable[[Truth, list[Segment], Array], Course] = simulate,
    at_changes: bool = False,
    progress: Progress = unseen,
    terms: Sequence[HiddenTerm] = (),
) -> dict[str, Array]:
    """Make a run that hides effects: columns by header as in a CSV file, NaN where a cell is empty.

    As any logger's, its rows do not know when the duty cycle changes, unless they are `at_changes` too.

    Parameters
    ----------
    effects : strength in SI; the effect of an instrument names its channel, as `sensor_lag:tip_temperature`
    duty : the duty cycle
    noise, seed : what the instruments add
    interval : s between rows, the second of which comes at a time drawn between one and two of them
    solver : gives the true course of a cell over a duty cycle at times in s
    terms : heat by equations

    Raises
    ------
    InputError
        An effect is not known, or the duty cycle is too short for two rows.
    """
    duration = length(duty)
    truth, late = Truth(terms=tuple(terms)), effects.get("clock_offset", 0.0)
    for name, size in effects.items():
        effect = effect_of(name)
        if effect.on_truth is not None:
            truth = effect.on_truth(truth, size, duration)
    begins = np.random.default_rng([seed, 1]).uniform(0.0, interval)
    rows = np.append(0.0, np.arange(begins + interval, duration, interval))
    changes = np.cumsum([segment.duration for segment in duty])[:-1]
    rows = np.unique(np.round([*rows, *(changes if at_changes else ())], 3))
    refuse_too_few(rows, interval)
    lagging = any(name.split(":")[0] in ("sensor_lag", "creep") for name in effects)
    seen = np.clip(rows - late, 0.0, duration)
    dense = np.union1d(np.arange(0.0, duration, 2.0), seen) if lagging else np.unique(seen)
    progress(f"{duration / 3600:.3g} h of the cell")
    course = solver(truth, list(duty), dense)
    readings = {f"{name}_temperature": getattr(course, name) for name in TEMPERATURES}
    readings["elongation"] = course.elongation
    readings["ambient"] = demands_at(duty, course.time)["ambient_temperature"]
    on_readings = [
        (change, size, name.partition(":")[2] or "elongation")
        for name, size in effects.items()
        if (change := effect_of(name).on_readings) is not None
    ]
    readings = with_changes(dense, readings, on_readings)
    picked = {name: readings[name][np.searchsorted(dense, seen)] for name in (*CHANNELS, "elongation")}
    found = noisy(rows, picked, noise, np.random.default_rng(seed))
    measured = {f"{channel} [degC]": found[channel] - ZERO_CELSIUS for channel in CHANNELS}
    return {**demand_columns(rows, duty), **measured, "elongation [um]": found["elongation"] * 1e6}


def refuse_too_few(rows: Array, interval: float) -> None:
    """Raise InputError where a run has no two rows, which come at an interval in s."""
    if rows.size < 2:
        told = f"a run of one row, for they come every {interval:g} s, the second within {2 * interval:g} s"
        raise InputError(f"duty: it makes {told}; give at least {2 * interval:g} s")


def write_csv(columns: Mapping[str, Array], path: Path) -> None:
    """Write a run, whole or not at all; raises InputError where it cannot be written."""
    import pandas as pd

    written = {name: pd.Series(values) for name, values in columns.items()}
    written["time [s]"] = written["time [s]"].map("{:.10g}".format)  # two rows of a long run stay two
    with fresh_file(path) as scratch:
        pd.DataFrame(written).rename(columns=as_cell).to_csv(scratch, index=False, float_format="%.6g")


def noisy(
    rows: Array,
    readings: Readings,
    noise: Noise,
    random: np.random.Generator,
    lengths: Collection[str] = ("elongation",),
) -> Readings:
    """Readings at rows in s, in SI, with what the instruments add; shape (rows,) each.

    Channels that are not `lengths` are temperatures.
    """
    from scipy.linalg import solve_banded

    result = {}
    decay = np.exp(-float(np.median(np.diff(rows))) / noise.minute)
    for channel, values in readings.items():
        of_camera = channel in lengths
        added = np.sqrt(1 - noise.correlated) * random.standard_normal(rows.size)
        start = random.standard_normal()
        drive = np.sqrt(1 - decay**2) * random.standard_normal(rows.size)
        drive[0] = start
        # Of the first-order recursion; scipy.signal takes a second to import.
        recursion = [np.ones(rows.size), np.full(rows.size, -decay)]
        added += np.sqrt(noise.correlated) * solve_banded((1, 0), recursion, drive)
        spiky = random.random(rows.size) < noise.spikes
        added += spiky * random.uniform(10, 30, rows.size) * random.choice([-1, 1], rows.size)
        read = values + (noise.elongation if of_camera else noise.temperature) * added
        if noise.quantum:
            quantum, zero = (noise.quantum * 1e-6, 0.0) if of_camera else (noise.quantum, ZERO_CELSIUS)
            read = np.round((read - zero) / quantum) * quantum + zero
        result[channel] = read
    return result


def demand_columns(rows: Array, duty: Sequence[Segment]) -> dict[str, Array]:
    """Times of rows in s and the demands there, by header as in a CSV file; NaN where no pad is held."""
    found = {"time [s]": rows}
    for name, values in demands_at(duty, rows).items():
        unit = {"speed": "rad/s", "torque": "N.m"}.get(name, "degC")
        found[f"{name} [{unit}]"] = values - (ZERO_CELSIUS if unit == "degC" else 0.0)
    return found
