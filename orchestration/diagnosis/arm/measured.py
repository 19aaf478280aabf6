"""Measurements of the whole arm as an experiment for each axis.

An axis is a warm-up cell with its neighbours' readings as two more inputs: the temperature of the link's tip
before it, and that of the next joint, behind its own link's tip. So what is wrong with one joint shows in
that joint's axis, and what it does to the others is accounted for.

A neighbour's temperature drives an axis as an input does, and its noise with it: in the last cell of a light
link a reading that is 0.1 K off for ten seconds is a disturbance. Between two changes of the duty cycle a
temperature bends slowly, so it is interpolated where it was not read, and replaced by a straight line fitted
to the readings about each row; at a change, where it has a kink, the lines end. Over minutes the noise still
adds up in a shaft. That is no cause either, and so the fit is told how much the readings scatter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from warmlink.controllers.interface import SENSED
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.chain import axis, axis_name
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import HELD_OUT_SHARE, Experiment
from warmlink.orchestration.diagnosis.data.measured import Run, over_steps, read_run
from warmlink.orchestration.diagnosis.data.signals import row_noise
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.text_files import is_file, measured_text

AMBIENT = "ambient_temperature [degC]"
DEMANDS = {"speed [rad/s]": "motor.speed", "torque [N.m]": "motor.torque"}
_COLUMNS = rig(DEFAULT).columns
MEASURED = {f"{name} [degC]": _COLUMNS[name] for name in SENSED} | {"elongation [um]": _COLUMNS["elongation"]}
"""Variables of an axis by header; in the file it begins with the axis, `axis3.tip_temperature [degC]`."""

HALF_WIDTH = 60.0
"""s to either side of a row from which its line is fitted."""


def header_of(number: int, header: str) -> str:
    """Header of an axis's column."""
    return f"{axis_name(number)}.{header}"


def is_arm_file(path: Path) -> bool:
    """Whether a file is a CSV file of the whole arm, by its header row."""
    if path.suffix.lower() != ".csv" or not is_file(path):
        return False
    return f"{axis_name(1)}." in measured_text(path).partition("\n")[0]


def arm_experiments(path: Path) -> dict[int, Experiment]:
    """Experiment of each axis, by its number, from a CSV file of the whole arm.

    The file has `time [s]`, `ambient_temperature [degC]` and, for each axis, `axis1.speed [rad/s]`,
    `axis1.torque [N.m]`, `axis1.shaft_temperature [degC]` and so on with winding, base, middle and tip, and
    `axis1.elongation [um]`. Cells of what is measured may be empty. A row holds until the next.

    Raises
    ------
    InputError
        The file, a header or a cell does not fit.
    """
    runs = {}
    for i in range(1, AXES + 1):
        own = {header_of(i, header): name for header, name in (DEMANDS | MEASURED).items()}
        runs[i] = read_run(path, rig(DEFAULT), {AMBIENT: "motor.ambient_temperature", **own})
    changes = []
    for run in runs.values():
        moves = [np.diff(run.inputs[name]) != 0 for name in DEMANDS.values()]
        changes.append(run.time[1:][np.any(moves, axis=0)])
    every = np.unique(np.concatenate(changes))
    return {i: _experiment(i, runs, every) for i in runs}


def _experiment(number: int, runs: Mapping[int, Run], changes: Array) -> Experiment:
    """One axis's experiment: its run and its nominal parameters, the next joint behind its link's tip."""
    this, run = axis(number), runs[number]
    known = {f"motor.{name}": value for name, value in this.motor.items()}
    known |= {f"link.{name}": value for name, value in this.link.items()}
    if number == 1:
        known["motor.neighbour_conductance"] = 0.0
    if number < AXES:
        known["link.tip_conductance"] = axis(number + 1).motor["neighbour_conductance"]
    # Said of the link too: the room's temperature would else feed the tip's sink as well.
    inputs = {**run.inputs, "link.ambient_temperature": run.inputs["motor.ambient_temperature"]}
    scatter: dict[str, float] = {}
    columns = [*run.columns]
    for other, header, name in (
        (number - 1, "tip_temperature [degC]", "motor.neighbour_temperature"),
        (number + 1, "shaft_temperature [degC]", "link.tip_sink_temperature"),
    ):
        if other in runs:
            column = next(c for c in runs[other].columns if c.variable == MEASURED[header])
            readings = runs[other].readings[column.variable]
            read = np.isfinite(readings)
            if not read.any():
                raise InputError(
                    f"{run.name}: column {column.header!r} is empty; axis {number} needs its readings"
                )
            scatter[name] = row_noise(run.time, readings)
            filled = np.interp(run.time, run.time[read], readings[read])
            inputs[name] = over_steps(smoothed(run.time, filled, changes))
            columns.append(replace(column, variable=name))
    until = (1 - HELD_OUT_SHARE) * float(run.time[-1])
    name = f"{axis_name(number)}, {this.name}"
    run = replace(run, name=name, inputs=inputs, scatter=scatter, fit_until=until, columns=tuple(columns))
    return Experiment(name, rig(DEFAULT), (run,), run.measured, known)


def smoothed(time: Array, values: Array, changes: Array) -> Array:
    """Readings as lines fitted about each row give them, shape (n,), for rising times in s.

    Changes of the duty cycle closer together than the lines are wide bend the course too little to end one.
    """
    ends = np.concatenate([[time[0]], changes, [time[-1]]])
    gaps = np.diff(ends)
    inner = ends[1:-1][(gaps[:-1] >= HALF_WIDTH) & (gaps[1:] >= HALF_WIDTH)]
    part = np.searchsorted(inner, time, side="right")
    result = np.empty_like(values)
    for i in range(time.size):
        low = np.searchsorted(time, time[i] - HALF_WIDTH)
        high = np.searchsorted(time, time[i] + HALF_WIDTH, side="right")
        window = np.arange(low, high)
        # The row at a change still belongs to the course before it as well.
        near = window[(part[window] == part[i]) | np.isin(time[window], inner)]
        result[i] = _line_at(time[near] - time[i], values[near])
    return result


def _line_at(distance: Array, values: Array) -> float:
    """Value at distance 0 of the line of least squares."""
    mean, spread = distance.mean(), distance - distance.mean()
    square = float(spread @ spread)
    slope = float(spread @ values) / square if square > 0 else 0.0
    return float(values.mean() - slope * mean)
