"""A measured run by FMUs in a loop, with derivatives by differences of whole runs.

Stands where `Forward` stands for systems with parts whose equations nobody knows; README.md says how the
derivatives are taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.driven import Driven, courses
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.simulation import (
    NotSimulatedError,
    SimulatedRun,
    Simulation,
    given_inputs,
    halved,
    parts_before,
)
from warmlink.orchestration.machine.heat_paths import unit_of, with_values
from warmlink.orchestration.machine.rig import OFFSET, SCALE, Rig
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System

_DIFFERENCE = 5e-4
"""Share of the way between its bounds by which a slot is moved for a difference."""


_FEWEST, _CHANGED = 4, 1e-3
"""Steps between two rows, at least; share of an output's range by which half of each step may change it."""


class Loop(Simulation):
    """Simulates a run by FMUs.

    Parameters
    ----------
    rig, slots, run, known : as of a simulation, of a system of FMUs
    outputs : what is wanted, by full name
    finer_than : another simulation of the run, whose communication step is halved
    step : longest communication step in s; without, it is sought
    bounds : of an ordinary change of each slot, lower and upper ones, shape (slots,) each; without, no
        derivatives are given, and values extrapolated to a step of zero
    """

    def __init__(
        self,
        rig: Rig,
        slots: tuple[str, ...],
        outputs: tuple[str, ...],
        run: Run,
        known: Mapping[str, float],
        finer_than: Loop | None,
        bounds: tuple[Array, Array] | None,
        step: float | None = None,
    ) -> None:
        super().__init__(rig, slots, run, known)
        self._given = given_inputs(rig, run, known)
        self._outputs, self._bounds, self._finer_than, self._given_step = outputs, bounds, finer_than, step
        self._system = _needed(rig, outputs)
        units = (unit_of(self._system, name) for name in outputs)
        self._factors, self._offsets = np.array([(unit.factor, unit.offset) for unit in units]).T
        self._kept: dict[bytes, Array] = {}
        self._at: Array | None = None
        self._columns, self._answers = np.empty(0), dict[tuple[object, bytes], Array]()

    @cached_property
    def time(self) -> Array:
        """Communication points in s."""
        if self._finer_than is not None:
            return halved(self._finer_than.time)
        return self._points(self.step)

    @cached_property
    def step(self) -> float:
        """Longest communication step in s: the system's, or a longer one in a log whose rows are far apart.

        It is halved until one more halving changes no output by more than a thousandth of its range, as the
        experiment has the slots.
        """
        if self._given_step is not None:
            return self._given_step
        own, z = self.rig.machine.step_size, self.start_values()

        @cache
        def course(longest: float) -> tuple[Array, Array]:
            points = self._points(longest)
            return points, courses([self._driven(z, time=points)])[0]

        step = float(np.median(np.diff(self.run.time))) / _FEWEST
        while step > own:
            with suppress(NotSimulatedError):
                (points, whole), (half, finer) = course(step), course(step / 2)
                between = np.array([np.interp(half, points, each) for each in whole.T]).T
                change = np.max(np.abs(between - finer), axis=0)
                if np.all(change <= _CHANGED * np.ptp(finer, axis=0)):
                    return step
            step /= 2
        return own

    def _points(self, step: float) -> Array:
        """Communication points in s with a longest step."""
        infos = [read_description(part.fmu) for part in self._system.components.values()]
        uneven = all(info.capabilities.variable_step for info in infos)
        return _communication(self.run.time, step, uneven)

    def refine(self, z: Array) -> None:
        """Take all derivatives anew at values of the slots, where any are given."""
        self._at, self._answers = z.copy(), {}
        self._columns = self._by_slot(z, range(z.size if self._bounds else 0))

    def __call__(self, z: Array, times: Array, wanted: Sequence[int] | None = None) -> SimulatedRun:
        """Simulate. Between communication points the outputs are interpolated."""
        if self._at is None:
            self.refine(z)
        slots = range(z.size) if wanted is None else wanted
        there = np.array(slots if self._bounds else (), dtype=np.int64)
        by_slot = self._columns[:, :, there]
        moved = np.flatnonzero((z != self._at)[there])
        by_slot[:, :, moved] = self._by_slot(z, there[moved].tolist())
        values = self._course(z)  # which the differences have left behind
        slopes = np.gradient(values, self.time, axis=0)
        return SimulatedRun(*(self._interpolated(each, times) for each in (values, slopes, by_slot)))

    def responses(self, z: Array, times: Array, given: Courses) -> Array:
        """Derivatives by the courses' values at the nodes.

        They are those of the first point after a linearisation, as a run for each value is dear.
        """
        key = given.added_to, given.nodes.tobytes()
        if key not in self._answers:
            hats = [np.interp(self.time, given.nodes, hat) for hat in np.eye(given.nodes.size)]
            moves = np.abs(self._moves(z))
            sizes = [float(moves[list(slots)].min()) for slots in given.added_to]
            wanted = zip(given.added_to, sizes, strict=True)
            added = [dict.fromkeys(slots, size * hat) for slots, size in wanted for hat in hats]
            self._answers[key] = self._derivatives(z, added, np.repeat(sizes, len(hats)))
        return self._interpolated(self._answers[key], times)

    def sooner(self, z: Array, times: Array, rows: NDArray[np.int64], parts: int) -> SimulatedRun:
        """What each part of the time before a row adds, by runs with a further row each."""
        edges, time = parts_before(self.run, rows, parts), self.run.time
        shares = (time[rows] - edges[-2::-1]) / (time[rows] - time[rows - 1])
        each = zip(rows.tolist(), shares.T.tolist(), strict=True)
        sooner = [self.run.sooner(row, share) for row, some in each for share in some]
        alike = self.rig, self.slots, self._outputs
        loops = [Loop(*alike, run, self._known, None, None, self.step) for run in (self.run, *sooner)]
        runs = [loop._driven(z) for loop in loops]
        ended = courses([each for run in runs for each in (run, run.halved())])
        for loop, coarse, fine in zip(loops, ended[::2], ended[1::2], strict=True):
            loop._keep(z, 2 * fine[::2] - coarse)
        found = [loop(z, times, ()) for loop in loops]
        values = np.stack([each.values for each in found], axis=2)
        changes = (values[:, :, 1:] - values[:, :, :1]).reshape(*values.shape[:2], rows.size, parts)
        each_part = np.diff(changes, axis=3, prepend=0.0)
        return replace(found[0], by_slot=each_part.reshape(*values.shape[:2], -1))

    def _interpolated(self, values: Array, times: Array) -> Array:
        from scipy.interpolate import make_interp_spline

        return np.asarray(make_interp_spline(self.time, values, k=1, check_finite=False)(times))

    def _course(self, z: Array) -> Array:
        """Outputs at the communication points in SI, shape (points, outputs)."""
        key = z.tobytes()
        if key not in self._kept:
            run = self._driven(z)
            if self._bounds is not None:
                (found,) = courses([run])
            else:
                # The loop's error is of first order in its step, so that it goes out with half of the step.
                coarse, fine = courses([run, run.halved()])
                found = 2 * fine[::2] - coarse
            self._keep(z, found)
        return self._kept[key]

    def _keep(self, z: Array, found: Array) -> None:
        """Keep outputs in the variables' own units as those with values of the slots."""
        self._kept = {z.tobytes(): self._factors * found + self._offsets}

    def _moves(self, z: Array) -> Array:
        """How far each slot is moved for a difference, inside its bounds, shape (slots,)."""
        lower, upper = self._bounds or (np.zeros(z.size), np.ones(z.size))
        move = _DIFFERENCE * (upper - lower)
        return np.where(z + move > upper, -move, move)

    def _by_slot(self, z: Array, which: Sequence[int]) -> Array:
        """Derivatives by some of the slots, shape (points, outputs, which)."""
        moves = self._moves(z)
        return self._derivatives(z, [{i: moves[[i]]} for i in which], moves[list(which)])

    def _derivatives(self, z: Array, added: Sequence[Mapping[int, Array]], sizes: Array) -> Array:
        """Derivatives by the sizes of courses that are added to slots, shape (points, outputs, courses)."""
        if not added:
            return np.empty((self.time.size, len(self._outputs), 0))
        base, *moved = courses([self._driven(z, each) for each in ({}, *added)])
        self._keep(z, base)
        return np.stack([self._factors * (c - base) / size for c, size in zip(moved, sizes, strict=True)], 2)

    def _driven(
        self, z: Array, added: Mapping[int, Array] | None = None, time: Array | None = None
    ) -> Driven:
        """A run with values of the slots, and courses that are added to some, at its communication points."""
        time = self.time if time is None else time
        middle = np.append((time[:-1] + time[1:]) / 2, time[-1])
        signals = dict(zip(self.rig.externals, self._table[:, self.run.row_at(middle)], strict=True))
        logged = set(signals)
        signals |= {n: np.array([v]) for n, v in self._known.items() if n not in logged}
        for i, slot in enumerate(self.slots):
            value = z[i] + (added or {}).get(i, np.zeros(1))
            kind, _, fed = slot.partition(":")
            if kind not in (SCALE, OFFSET):
                signals[slot] = value
                continue
            for name in logged.intersection(self.rig.fed_with(fed, self._given)):
                signals[name] = signals[name] * value if kind == SCALE else signals[name] + value
        starts = {name: float(signal[0]) for name, signal in signals.items()}
        driven = {}
        for name, signal in signals.items():
            if np.ptp(signal) > 0 and self.rig.part_of(name) in self._system.components:
                unit = unit_of(self._system, name)
                driven[name] = (signal - unit.offset) / unit.factor
        return Driven(with_values(self._system, starts), driven, self._outputs, time)


def _communication(rows: Array, longest: float, uneven: bool) -> Array:
    """Times in s at which FMUs communicate: at the rows, and evenly between them in steps up to the longest.

    Where an FMU allows no steps that differ, they are even, and what acts in one is logged for its middle.
    """
    if uneven:
        parts = np.ceil(np.diff(rows) / longest - 1e-9)
        return np.interp(np.arange(parts.sum() + 1), np.append(0.0, np.cumsum(parts)), rows)
    step = min(longest, float(np.median(np.diff(rows))))
    return step * np.arange(np.ceil(rows[-1] / step - 1e-9) + 1)


def _needed(rig: Rig, outputs: tuple[str, ...]) -> System:
    """The parts on which outputs depend, without the connections that the log stands for."""
    assert rig.system is not None
    system = rig.system
    wires = [each for each in system.connections if each.source not in rig.cut]
    wires = [each for each in wires if each.source_component in rig.components]
    needed = {rig.part_of(name) for name in outputs}
    while more := {w.source_component for w in wires if w.target_component in needed} - needed:
        needed |= more
    parts = {name: part for name, part in system.components.items() if name in needed}
    kept = tuple(each for each in wires if each.target_component in needed)
    return replace(system, components=parts, connections=kept)
