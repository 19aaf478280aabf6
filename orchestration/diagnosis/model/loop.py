"""A measured run by FMUs in a loop, with derivatives by differences of whole runs.

Stands where `Forward` stands for systems with parts whose equations nobody knows. The derivatives by what may
be freed are those of the last linearisation, except by what has changed its value since: these are taken
anew. So a step of a fit costs a few runs, and its own derivatives are right wherever it goes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.own import Own, from_si, to_si
from warmlink.orchestration.diagnosis.data.rig import OFFSET, SCALE, Rig
from warmlink.orchestration.diagnosis.model.driven import Driven, courses, halved
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.simulation import Simulation, Trajectory, held_row
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.units import Conversion

Bounds = Callable[[], tuple[Array, Array]]
"""Lower and upper bounds of an ordinary change of each slot, shape (slots,) each."""

_DIFFERENCE = 5e-4
"""Share of the way between its bounds by which a slot is moved for a difference."""


class Loop(Simulation):
    """Simulates a run by FMUs.

    Parameters
    ----------
    rig, slots, run, known : as of a simulation, of a system of FMUs
    outputs : what is wanted, by full name
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
        super().__init__(rig, slots, run, known)
        assert rig.own is not None
        self._outputs, self._bounds, self._system = outputs, bounds, _needed(rig, rig.own, outputs)
        self._infos = {name: read_description(part.fmu) for name, part in self._system.components.items()}
        uneven = all(info.capabilities.variable_step for info in self._infos.values())
        laid = _communication(run.time, rig.blueprint.step_size, uneven)
        self._time: Array = laid if finer_than is None else halved(finer_than.time)
        middle = np.append((self.time[:-1] + self.time[1:]) / 2, self.time[-1])
        self._acting = self._table[:, held_row(run.time, middle)]
        self._units = [self._unit(name) for name in outputs]
        self._kept: dict[bytes, Array] = {}
        self._at: Array | None = None
        self._columns = np.empty(0)
        self._answers: dict[tuple[object, bytes], Array] = {}

    @property
    def time(self) -> Array:
        """Communication points in s."""
        return self._time

    def linearise(self, z: Array) -> None:
        """Take all derivatives anew at values of the slots."""
        self._at, self._answers = z.copy(), {}
        self._columns = self._by_slot(z, range(z.size))

    def __call__(self, z: Array, times: Array) -> Trajectory:
        """Simulate. Between communication points the outputs are interpolated."""
        by_slot: Array = np.empty((self.time.size, len(self._outputs), 0))
        if self._bounds:
            if self._at is None:
                self.linearise(z)
            by_slot = self._columns.copy()
            moved = np.flatnonzero(z != self._at).tolist()
            by_slot[:, :, moved] = self._by_slot(z, moved)
        values = self._course(z)  # which the differences have left behind
        slopes = np.gradient(values, self.time, axis=0)
        return Trajectory(*(self._interpolated(each, times) for each in (values, slopes, by_slot)))

    def responses(self, z: Array, times: Array, given: Courses) -> Array:
        """Derivatives by the courses' values at the nodes.

        They are those of the first point after a linearisation, as a run for each value is dear.
        """
        key = given.added_to, given.nodes.tobytes()
        if key not in self._answers:
            hats = [np.interp(self.time, given.nodes, hat) for hat in np.eye(given.nodes.size)]
            moves = np.abs(self._moves(z))
            wanted = [
                (slots, float(moves[list(slots)].min()), hat) for slots in given.added_to for hat in hats
            ]
            added = [dict.fromkeys(slots, size * hat) for slots, size, hat in wanted]
            self._answers[key] = self._derivatives(z, added, [size for _, size, _ in wanted])
        return self._interpolated(self._answers[key], times)

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

    def _moves(self, z: Array) -> Array:
        """How far each slot is moved for a difference, inside its bounds, shape (slots,)."""
        lower, upper = self._bounds() if self._bounds else (np.zeros(z.size), np.ones(z.size))
        move = _DIFFERENCE * (upper - lower)
        return np.where(z + move > upper, -move, move)

    def _by_slot(self, z: Array, which: Sequence[int]) -> Array:
        """Derivatives by some of the slots, shape (points, outputs, which)."""
        moves = self._moves(z)
        return self._derivatives(z, [{i: moves[[i]]} for i in which], moves[list(which)])

    def _derivatives(
        self, z: Array, added: Sequence[Mapping[int, Array]], sizes: Sequence[float] | Array
    ) -> Array:
        """Derivatives by the sizes of courses that are added to slots, shape (points, outputs, courses)."""
        if not added:
            return np.empty((self.time.size, len(self._outputs), 0))
        base, *moved = courses([self._driven(z, each) for each in ({}, *added)])
        self._kept = {z.tobytes(): self._in_si(base)}
        factors = np.array([unit.factor for unit in self._units])
        return np.stack([factors * (c - base) / size for c, size in zip(moved, sizes, strict=True)], axis=2)

    def _driven(self, z: Array, added: Mapping[int, Array] | None = None) -> Driven:
        """A run with values of the slots, and courses that are added to some of them."""
        index = {name: i for i, name in enumerate(self.rig.externals)}
        signals = dict(zip(index, self._acting, strict=True))
        signals |= {n: np.array([v]) for n, v in self._known.items() if n not in index}
        for i, slot in enumerate(self.slots):
            value = z[i] + (added or {}).get(i, np.zeros(1))
            if slot.startswith((SCALE, OFFSET)):
                for name in (n for n in self.rig.fed_with(slot.partition(":")[2]) if n in index):
                    logged = signals[name]
                    signals[name] = logged * value if slot.startswith(SCALE) else logged + value
            else:
                signals[slot] = value
        starts: dict[str, dict[str, Value]] = {n: dict(c.values) for n, c in self._system.components.items()}
        driven: dict[str, Array] = {}
        for name, signal in signals.items():
            part = self.rig.part_of(name)
            if part in starts:
                variable = name[len(part) + 1 :]
                starts[part][variable] = from_si(self._infos[part], variable, float(signal[0]))
                if np.ptp(signal) > 0:
                    own = self._unit(name)
                    driven[name] = (signal - own.offset) / own.factor
        parts = {n: replace(c, values=starts[n]) for n, c in self._system.components.items()}
        return Driven(replace(self._system, components=parts), driven, self._outputs, self.time)

    def _unit(self, name: str) -> Conversion:
        part = self.rig.part_of(name)
        return to_si(self._infos[part], name[len(part) + 1 :])

    def _in_si(self, values: Array) -> Array:
        units = self._units
        return values * np.array([u.factor for u in units]) + np.array([u.offset for u in units])


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
