"""Simulation of a measured run by FMUs in a loop, with derivatives by differences of whole runs.

Stands where `Forward` stands for systems with parts whose equations nobody knows. The derivatives by what may
be freed are those of the last linearisation, except by what has changed its value since: these are taken
anew. So a step of a fit costs a few runs, and its own derivatives are right wherever it goes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.rig import OFFSET, SCALE, Rig
from warmlink.orchestration.diagnosis.data.rigs import Own, from_si, to_si
from warmlink.orchestration.diagnosis.model.driven import Driven, courses, halved
from warmlink.orchestration.diagnosis.model.forward import (
    Courses,
    Trajectory,
    held_row,
    input_table,
    start_values,
)
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import System, Value

Bounds = Callable[[], tuple[Array, Array]]
"""Lower and upper bounds of an ordinary change of each slot, shape (slots,) each."""

_DIFFERENCE = 5e-4
"""Share of the way between its bounds by which a slot is moved for a difference."""


class Loop:
    """Simulates one run, again and again, with other values of what is freed.

    Parameters
    ----------
    rig : a system of FMUs
    slots, outputs : what may be freed, and what is wanted, by full name
    run : the measured run: its times and inputs
    known : value by parameter or input, as far as it differs from the system's
    finer_than : another simulation of the run, whose communication step is halved
    bounds : of the slots; without, no derivatives are given, and values extrapolated to a step of zero
    """

    def __init__(
        self,
        rig: Rig,
        slots: tuple[str, ...],
        outputs: tuple[str, ...],
        run: Run,
        known: Mapping[str, float],
        finer_than: Loop | None,
        bounds: Bounds | None,
    ) -> None:
        assert rig.own is not None
        self.rig, self.slots, self._outputs, self._bounds = rig, slots, outputs, bounds
        self._system = _needed(rig, rig.own, outputs)
        self._infos = {name: read_description(part.fmu) for name, part in self._system.components.items()}
        uneven = all(info.capabilities.variable_step for info in self._infos.values())
        laid = _communication(run.time, rig.blueprint.step_size, uneven)
        self.time: Array = laid if finer_than is None else halved(finer_than.time)
        self._table = input_table(rig, run, known)
        middle = np.append((self.time[:-1] + self.time[1:]) / 2, self.time[-1])
        self._acting = self._table[:, held_row(run.time, middle)]
        self._known = known
        self._kept: dict[bytes, Array] = {}
        self._at: Array | None = None
        self._columns = np.empty(0)
        self._answers: dict[tuple[object, bytes], Array] = {}

    def start_values(self) -> Array:
        """Values of the slots as the experiment has them, shape (slots,)."""
        return start_values(self.rig, self.slots, self._known, self._table)

    def current(self, times: Array) -> Array:
        """Motor current, which no cause of such a system asks for: 0, shape (times,)."""
        return np.zeros(times.size)

    def linearise(self, z: Array) -> None:
        """Take all derivatives anew at values of the slots."""
        self._at, every, self._answers = z.copy(), np.arange(z.size), {}
        self._columns = self._differences(z, every)

    def __call__(self, z: Array, times: Array) -> Trajectory:
        """Simulate; see `Forward`. Between communication points the outputs are interpolated."""
        by_slot: Array = np.empty((self.time.size, len(self._outputs), 0))
        if self._bounds:
            if self._at is None:
                self.linearise(z)
            by_slot = self._columns.copy()
            moved = np.flatnonzero(z != self._at)
            by_slot[:, :, moved] = self._differences(z, moved)
        values = self._course(z)  # which the differences have left behind
        slopes = np.gradient(values, self.time, axis=0)
        return Trajectory(*(self._interpolated(each, times) for each in (values, slopes, by_slot)))

    def responses(self, z: Array, times: Array, given: Courses) -> Array:
        """Derivatives of the outputs by the courses' values at the nodes, shape (times, outputs, values).

        They are those of the first point after a linearisation, as a run for each value is dear.
        """
        key = given.added_to, given.nodes.tobytes()
        if key not in self._answers:
            self._answers[key] = self._responses(z, given)
        return self._interpolated(self._answers[key], times)

    def _responses(self, z: Array, given: Courses) -> Array:
        """The same at the communication points."""
        runs, moves = [], []
        for slots in given.added_to:
            lower, upper = self._bounds() if self._bounds else (np.zeros(z.size), np.ones(z.size))
            move = _DIFFERENCE * float(np.min((upper - lower)[list(slots)]))
            for k in range(given.nodes.size):
                hat = move * np.interp(self.time, given.nodes, np.eye(given.nodes.size)[k])
                runs.append(self._driven(z, dict.fromkeys(slots, hat)))
                moves.append(move)
        if not runs:
            return np.empty((self.time.size, len(self._outputs), 0))
        base = self._course(z)
        found = [(self._in_si(c) - base) / m for c, m in zip(courses(runs), moves, strict=True)]
        return np.stack(found, axis=2)

    def _interpolated(self, values: Array, times: Array) -> Array:
        k = np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, self.time.size - 2)
        share = (times - self.time[k]) / (self.time[k + 1] - self.time[k])
        share = share.reshape(-1, *(1,) * (values.ndim - 1))
        return np.asarray((1 - share) * values[k] + share * values[k + 1])

    def _course(self, z: Array) -> Array:
        """Outputs at the communication points in SI, shape (points, outputs)."""
        key = z.tobytes()
        if key not in self._kept:
            run = self._driven(z)
            if self._bounds is not None:
                self._kept = {key: self._in_si(courses([run])[0])}
            else:
                # The loop's error is of first order in its step, so that it goes out with half of the step.
                coarse, fine = map(self._in_si, courses([run, run.halved()]))
                self._kept = {key: 2 * fine[::2] - coarse}
        return self._kept[key]

    def _differences(self, z: Array, which: NDArray[np.int64]) -> Array:
        """Derivatives by some of the slots, shape (points, outputs, which)."""
        if not which.size or self._bounds is None:
            return np.empty((self.time.size, len(self._outputs), which.size))
        lower, upper = self._bounds()
        move = _DIFFERENCE * (upper - lower)
        move = np.where(z + move > upper, -move, move)
        ahead = [z + move * (np.arange(z.size) == i) for i in which]
        base, *moved = courses([self._driven(each) for each in (z, *ahead)])
        self._kept = {z.tobytes(): self._in_si(base)}
        return np.stack(
            [self._in_si(c - base, 0.0) / move[i] for i, c in zip(which, moved, strict=True)], axis=2
        )

    def _driven(self, z: Array, added: Mapping[int, Array] | None = None) -> Driven:
        """A run with values of the slots, and courses that are added to some of them."""
        index = {name: i for i, name in enumerate(self.rig.externals)}
        inputs = self._acting.copy()
        values = {n: v for n, v in self._known.items() if n not in index}
        changing: dict[str, Array] = {}
        for i, slot in enumerate(self.slots):
            value = z[i] + (added[i] if added and i in added else np.zeros(1))
            if slot in index:
                inputs[index[slot]] = value
            elif slot.startswith((SCALE, OFFSET)):
                for k in (index[n] for n in self.rig.fed_with(slot.partition(":")[2]) if n in index):
                    inputs[k] = inputs[k] * value if slot.startswith(SCALE) else inputs[k] + value
            elif added and i in added:
                changing[slot] = value
            else:
                values[slot] = float(z[i])
        signals = {name: inputs[i] for name, i in index.items()} | changing
        return self._in_own_units(values, signals)

    def _in_own_units(self, values: Mapping[str, float], signals: Mapping[str, Array]) -> Driven:
        starts: dict[str, dict[str, Value]] = {n: dict(c.values) for n, c in self._system.components.items()}
        driven: dict[str, Array] = {}
        for name, value in (*values.items(), *((n, float(s[0])) for n, s in signals.items())):
            part = self.rig.part_of(name)
            if part in starts:
                starts[part][name[len(part) + 1 :]] = from_si(*self._named(name), value)
        for name, signal in signals.items():
            if self.rig.part_of(name) in starts and np.ptp(signal) > 0:
                own = to_si(*self._named(name))
                driven[name] = (signal - own.offset) / own.factor
        parts = {n: replace(c, values=starts[n]) for n, c in self._system.components.items()}
        system = replace(self._system, components=parts)
        return Driven(system, driven, self._outputs, self.time)

    def _named(self, name: str) -> tuple[ModelInfo, str]:
        part = self.rig.part_of(name)
        return self._infos[part], name[len(part) + 1 :]

    def _in_si(self, values: Array, zero: float = 1.0) -> Array:
        """Outputs in SI; with `zero` 0 differences of outputs."""
        return values * self._units[0] + zero * self._units[1]

    @cached_property
    def _units(self) -> tuple[Array, Array]:
        own = [to_si(*self._named(name)) for name in self._outputs]
        return np.array([each.factor for each in own]), np.array([each.offset for each in own])


def _communication(rows: Array, longest: float, uneven: bool) -> Array:
    """Times in s at which FMUs communicate: at the rows, and evenly between them in steps up to the longest.

    Where an FMU allows no steps that differ, they are even, and what acts in one is logged for its middle.
    """
    if uneven:
        parts = np.ceil(np.diff(rows) / longest - 1e-9)
        return np.interp(np.arange(parts.sum() + 1), np.append(0.0, np.cumsum(parts)), rows)
    step = min(longest, float(np.median(np.diff(rows))))
    return step * np.arange(np.ceil(rows[-1] / step - 1e-9) + 1)


def _needed(rig: Rig, own: Own, outputs: tuple[str, ...]) -> System:
    """The parts on which outputs depend, without the connections that the log stands for."""
    wires = [each for each in own.system.connections if each.source not in rig.cut]
    wires = [each for each in wires if each.source_component in rig.components]
    needed = {rig.part_of(name) for name in outputs}
    while more := {w.source_component for w in wires if w.target_component in needed} - needed:
        needed |= more
    return replace(
        own.system,
        components={name: part for name, part in own.system.components.items() if name in needed},
        connections=tuple(each for each in wires if each.target_component in needed),
    )
