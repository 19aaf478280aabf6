"""Patterns that follow an input: what a model leaves in blocks, faster than slow courses, as torque goes.

They are too fast to be told from correlated noise by their spectrum, and betray themselves by their timing.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.fitting import Fitter

_LAG = 300.0
"""Time constant in s of the delayed course of an input: heat follows later than an instrument's fault."""

_VARIES = 1e-9
"""Share of its size by which an input must change for anything to follow it."""


@dataclass(frozen=True)
class Pattern:
    """What may follow an input in one channel: the input's courses there, whitened, shape (rows, courses)."""

    signal: str
    channel: int
    courses: Array


_KNOWN: WeakKeyDictionary[Fitter, tuple[Pattern, ...]] = WeakKeyDictionary()
"""Patterns by the fitter, which they do not keep alive."""


def patterns(fitter: Fitter) -> tuple[Pattern, ...]:
    """Patterns by each input but temperatures, which only heat follows, in each channel of all runs."""
    if fitter not in _KNOWN:
        _KNOWN[fitter] = _patterns(fitter)
    return _KNOWN[fitter]


def _patterns(fitter: Fitter) -> tuple[Pattern, ...]:
    runs, unit = fitter.problem.experiment.runs, fitter.problem.experiment.rig.unit
    names = dict.fromkeys(n for run in runs for n, v in run.inputs.items() if unit(n) != "K" and _varies(v))
    found = []
    for name in names:
        tables = [_courses(run, name, fitter.problem.data[i].time) for i, run in enumerate(runs)]
        white = [_by_channel(fitter, i, table) for i, table in enumerate(tables)]
        for channel in range(len(fitter.problem.variables)):
            joined = np.concatenate([each[channel] for each in white])
            if np.any(joined):
                found.append(Pattern(name, channel, joined))
    return tuple(found)


def _varies(values: Array) -> bool:
    return bool(np.ptp(np.nan_to_num(values)) > _VARIES * np.abs(np.nan_to_num(values)).max())


def _courses(run: Run, name: str, times: Array) -> Array:
    """An input and its square at times in s, and both later, shape (times, 4)."""
    if name not in run.inputs:
        return np.zeros((times.size, 4))
    signal = np.nan_to_num(run.inputs[name])[run.row_at(times)]
    size = max(float(np.abs(signal).max()), 1e-300)
    both = np.column_stack([signal / size, (signal / size) ** 2])
    later, kept = both.copy(), np.exp(-np.diff(times) / _LAG)
    for k, share in enumerate(kept):
        later[k + 1] = share * later[k] + (1 - share) * both[k]
    return np.column_stack([both, later])


def _by_channel(fitter: Fitter, run: int, table: Array) -> list[Array]:
    """Whitened columns of a run for each channel that alone has them, shape (all rows, columns)."""
    channels = len(fitter.problem.variables)
    stacked = fitter.stacked(run, np.repeat(table[:, None], channels, axis=1))
    begin = 0
    every = np.zeros((stacked.shape[0], channels * table.shape[1]))
    for channel, rows in enumerate(fitter.rows[run]):
        here = slice(begin, begin + rows.size)
        every[here, channel * table.shape[1] : (channel + 1) * table.shape[1]] = stacked[here]
        begin += rows.size
    return np.split(fitter.whiten(run, every), channels, axis=1)
