"""Rows of a log gathered into ticks, mostly of a minute, of its own time, whatever order they come in.

A tick is a function of the rows alone, never of when they arrive; what cannot be used is counted and told.
"""

from __future__ import annotations

import math
from bisect import insort
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.simulation import input_table
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.watch.sources.rows import LoggedRow

TICK = 60.0
"""s of the log in one tick, unless the user says otherwise."""

LATE = 0.5
"""Ticks by which a row may come later than newer ones and still count."""

GAP = 15
"""Ticks without rows after which nobody knows what the machine did: the filter begins anew."""

_SET_BACK = 20
"""Rows that follow one another before the newest row, from which on the clock was set back."""

_SPIKE = 8.0
"""Robust standard deviations from the median of a tick at which a reading is a spike of the line."""

_FEWEST = 8
"""Readings of a tick from which on spikes are looked for."""


class Tick(NamedTuple):
    """What the rows of a stretch of time say.

    Attributes
    ----------
    start, end : s of the log's own time
    levels, shares : inputs of the plant that acted, shape (levels, externals), and their shares of the time
    readings : means in SI, shape (outputs,); NaN where there is none
    places : mean time of these readings as a share of the tick, shape (outputs,)
    counts : how many readings each mean has, shape (outputs,)
    scatter : standard deviation of one reading from one to the next, NaN where there are too few, shape
        (outputs,)
    correction : mean of the logged correction in m, NaN where there is none
    anew : whether a gap came before that nobody knows about
    """

    start: float
    end: float
    levels: Array
    shares: Array
    readings: Array
    places: Array
    counts: Array
    scatter: Array
    correction: float
    anew: bool


@dataclass
class Gatherer:
    """Gathers rows into ticks.

    Parameters
    ----------
    rig : the machine
    known : values in SI of parameters and inputs that differ from the nominal ones
    readings : outputs that are measured, in order
    tick : s of the log in one tick
    """

    rig: Rig
    known: Mapping[str, float]
    readings: Sequence[str]
    tick: float = TICK
    counts: Counter[str] = field(default_factory=Counter)
    shift: float = 0.0
    _open: list[tuple[float, int, LoggedRow]] = field(default_factory=list)
    _held: dict[str, float] = field(default_factory=dict)
    _end: float = -math.inf
    _newest: float = -math.inf
    _number: int = 0
    _back: list[float] = field(default_factory=list)

    def add(self, row: LoggedRow) -> Iterator[Tick]:
        """Take a row; give the ticks that are over with it, which are mostly none."""
        self._number += 1
        time = row.time + self.shift
        if time <= self._end or time < self._newest - GAP * self.tick:
            time = self._came_late(row, time)
            if not math.isfinite(time):
                return
        if any(time == each for each, _, _ in self._open):
            self.counts["repeated"] += 1
            return
        if time < self._newest:
            self.counts["unsorted"] += 1
        else:
            self._back.clear()
        if not math.isfinite(self._end):
            self._end = time
        insort(self._open, (time, self._number, row._replace(time=time)))
        self._newest = max(self._newest, time)
        while self._open and self._newest >= self._boundary() + LATE * self.tick:
            yield self._tick(self._boundary())

    def rest(self) -> Iterator[Tick]:
        """The ticks of the rows that are left, where the log has ended."""
        while self._open:
            yield self._tick(self._boundary())

    def _boundary(self) -> float:
        """End of the tick that the oldest open row is in."""
        whole = math.ceil((self._open[0][0] - self._end) / self.tick)
        return self._end + self.tick * max(whole, 1)

    def _came_late(self, row: LoggedRow, time: float) -> float:
        """Time of a row that lies before what was judged; NaN if it cannot be used any more."""
        if time == self._newest or (self._back and time == self._back[-1]):
            self.counts["repeated"] += 1
            return math.nan
        self._back = [*self._back, time] if self._back and time > self._back[-1] else [time]
        self.counts["late"] += 1
        if len(self._back) < _SET_BACK:
            return math.nan
        ahead = self._newest + (GAP + 1) * self.tick - time  # nobody knows how long it stood: as after a gap
        self.shift += ahead
        self.counts["clock set back"] += 1
        self._back.clear()
        return time + ahead

    def _tick(self, end: float) -> Tick:
        """The tick up to a boundary, from where the one before ended."""
        rows = [row for time, _, row in self._open if time <= end]
        self._open = self._open[len(rows) :]
        start, self._end = self._end, end
        anew = rows[0].time - start > GAP * self.tick
        if anew:
            self.counts["gaps"] += 1
            start = end - self.tick
        levels, shares = self._levels(rows, start, end)
        found = np.array(
            [self._mean([(r.time, r.readings[n]) for r in rows], start, end) for n in self.readings]
        )
        readings, places, counts, scatter = found.reshape(-1, 4).T
        said = [row.correction for row in rows if math.isfinite(row.correction)]
        correction = math.fsum(said) / len(said) if said else math.nan
        return Tick(start, end, levels, shares, readings, places, counts, scatter, correction, anew)

    def _levels(self, rows: Sequence[LoggedRow], start: float, end: float) -> tuple[Array, Array]:
        """Inputs that acted, and for how much of the time; what surrounds the machine as its mean."""
        first = dict(self._held) if self._held else self._filled(rows[0])
        courses, times = [first], [start]
        for row in rows:
            self._held = self._filled(row)
            courses.append(self._held)
            times.append(max(row.time, start))
        inputs = {name: np.array([c[name] for c in (*courses, courses[-1])]) for name in first}
        run = Run("tick", np.array([*times, max(end, times[-1])]) - start, inputs, {})
        with np.errstate(invalid="ignore"):
            table = input_table(self.rig, run, self.known)[:, :-1].T
        lasting = np.diff(run.time)
        shares = lasting / lasting.sum()
        room = [
            i
            for i, n in enumerate(self.rig.externals)
            if n.endswith(("ambient_temperature", "sink_temperature"))
        ]
        table[:, room] = shares @ table[:, room]
        levels, which = np.unique(table[shares > 0], axis=0, return_inverse=True)
        acted = np.bincount(which.ravel(), shares[shares > 0], len(levels)).astype(float)
        return levels, acted

    def _filled(self, row: LoggedRow) -> dict[str, float]:
        """Inputs of a row with the last value in each empty cell; an empty cell of a pad switches it off."""
        found = {}
        for name, value in row.inputs.items():
            pad = name.endswith(("pad_temperature", "pad_power"))
            if not pad and math.isnan(value):
                value = self._held.get(name, float(self.rig.variables[name].start or 0.0))
            found[name] = 0.0 if math.isnan(value) and name.endswith("pad_power") else value
        return found

    def _mean(
        self, read: Sequence[tuple[float, float]], start: float, end: float
    ) -> tuple[float, float, float, float]:
        """Mean of readings without spikes, its place in the tick, their number and their scatter."""
        there = [(time, value) for time, value in read if math.isfinite(value)]
        if not there:
            return math.nan, 0.5, 0.0, math.nan
        times, values = np.array(there).T
        if values.size >= _FEWEST:
            away = np.abs(values - np.median(values))
            usual = max(1.4826 * float(np.median(away)), float(np.min(away[away > 0], initial=1e9)))
            kept = away <= _SPIKE * usual
            if not kept.all():
                self.counts["spikes"] += int(values.size - kept.sum())
            times, values = times[kept], values[kept]
        place = (float(times.mean()) - start) / (end - start)
        scatter = float(np.sqrt(np.mean(np.diff(values) ** 2) / 2)) if values.size >= _FEWEST else math.nan
        return float(values.mean()), min(max(place, 0.0), 1.0), float(values.size), scatter

    def state(self) -> dict[str, Any]:
        """What a restart needs, as JSON."""
        rows = [(time, number, *row[1:]) for time, number, row in self._open]
        own = {
            name: getattr(self, name) for name in ("shift", "_held", "_end", "_newest", "_number", "_back")
        }
        return {**own, "open": rows, "counts": dict(self.counts)}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a state that `state` gave."""
        for name in ("shift", "_held", "_end", "_newest", "_number", "_back"):
            setattr(self, name, state[name])
        self.counts = Counter(state["counts"])
        self._open = [(time, number, LoggedRow(time, *rest)) for time, number, *rest in state["open"]]
