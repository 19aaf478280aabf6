"""Simulation of a measured run with the derivatives by all freed variables, in one pass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.integrator import Courses, Integrator, Steps, staying
from warmlink.orchestration.diagnosis.model.simulation import (
    NotSimulatedError,
    SimulatedRun,
    Simulation,
    halved,
    parts_before,
)
from warmlink.orchestration.diagnosis.model.steps import Levels, Resolution, controlled, hermite

_AT_ONCE = 100.0
"""Multiple of the states' median rate from which one settles at once."""

_Tables = tuple[Array, Array, Array]
"""States at the points between steps, and slopes at both ends of each step, sensitivities beside them."""


class Forward(Simulation):
    """Solves a run's equations in one piece.

    Parameters
    ----------
    equations : the compiled rig
    run, known : as of a simulation
    grid : how finely, or another simulation of the run: each of its steps is halved
    """

    def __init__(
        self, equations: Equations, run: Run, known: Mapping[str, float], grid: Resolution | Forward
    ) -> None:
        super().__init__(equations.rig, equations.slots, run, known)
        self.equations, self._grid = equations, grid
        starts = zip(self.rig.parameters, equations.parameter_values, strict=True)
        self._p = np.array([known.get(name, start) for name, start in starts])
        # Instruments are fitted to the same course.
        self._kept: tuple[bytes, tuple[int, ...], _Tables] | None = None
        discrete = np.array([self.rig.variables[name].is_discrete for name in self.rig.externals], dtype=bool)
        self._levels = Levels(run.time, self._table, discrete, run.time[run.fitted][-1:])
        self._laid_for = self.start_values()

    @cached_property
    def steps(self) -> Steps:
        """What the steps are in time; found when they are first needed."""
        if isinstance(self._grid, Forward):
            return self._levels.steps(halved(self._grid.time))
        z = self._laid_for
        begun, _ = self.equations.begin(z, self._p, self._table[:, 0])
        integrator = Integrator(self.equations, z, self._p)
        return controlled(integrator, self._levels, begun, self._grid, self._thin)

    def refine(self, z: Array) -> None:
        """Lay the steps anew where they are short enough with these values."""
        if np.array_equal(z, self._laid_for):
            return
        if isinstance(self._grid, Forward):
            self._grid.refine(z)
        self._laid_for = z.copy()
        self.__dict__.pop("steps", None)
        self._kept = None

    @property
    def time(self) -> Array:
        """Points between steps in s."""
        return self.steps.time

    @cached_property
    def _thin(self) -> NDArray[np.int64]:
        """States that settle at once, as the cells of hardly any mass where a link is measured to its ends.

        They are right at the ends of a step of a minute, but their slopes there are the last trace of their
        settling: a cubic with them would leave the course by many K.
        """
        z, inputs = self.start_values(), self._table[:, 0]
        begun, _ = self.equations.begin(z, self._p, inputs)
        own = np.abs(np.diag(np.array(self.equations.linear(begun, z, self._p, inputs, 0.0)[1])))
        return np.flatnonzero(own > _AT_ONCE * np.median(own))

    def __call__(self, z: Array, times: Array, wanted: Sequence[int] | None = None) -> SimulatedRun:
        """Simulate; derivatives through the states and by the slots themselves."""
        slots = tuple(range(z.size) if wanted is None else wanted) if self.equations.columns else ()
        tables = self._course(z, slots)
        values, slopes, by_slot, direct = self._interpolated(z, self.steps, tables, times, slots)
        return SimulatedRun(values, slopes, by_slot + direct)

    def _course(self, z: Array, slots: tuple[int, ...]) -> _Tables:
        """The course, integrated once for as long as no derivatives are asked for that it has not."""
        if self._kept is None or self._kept[0] != z.tobytes() or not set(slots) <= set(self._kept[1]):
            self._kept = z.tobytes(), slots, self._integrate(z, staying(slots), slots)
        _, there, tables = self._kept
        if there == slots:
            return tables
        columns = [0, *(1 + there.index(slot) for slot in slots)]
        states, left, right = (each[:, :, columns] for each in tables)
        return states, left, right

    def responses(self, z: Array, times: Array, courses: Courses) -> Array:
        """Derivatives by the courses' values; the outputs follow the courses through the states alone."""
        return self._interpolated(z, self.steps, self._integrate(z, courses), times)[2]

    def sooner(self, z: Array, times: Array, rows: NDArray[np.int64], parts: int) -> SimulatedRun:
        """What each part of the time before a row adds, if the inputs of the row act from then on.

        Differences of whole courses: what bends, such as a pad that a warmer shaft turns off, bends in each.
        """
        edges = parts_before(self.run, rows, parts)
        steps = self._levels.steps(np.unique([*self.time, *edges.ravel()]))
        last, at = steps.time.size - 1, np.searchsorted(steps.time, edges)
        x, _ = self.equations.begin(z, self._p, self._table[:, 0])
        course = Integrator(self.equations, z, self._p)
        logged = course(steps, x[:, None])
        tables = [np.zeros((1 + rows.size * parts, *each.shape[:2])) for each in logged]
        for table, each in zip(tables, logged, strict=True):
            table[0] = each[:, :, 0]
        for column, (k, part) in enumerate(product(range(rows.size), range(parts)), 1):
            begin, end = at[parts - 1 - part, k], at[parts, k]
            now = course(steps.part(begin, end).on(self._table[:, rows[k]]), logged[0][begin])
            after = course(steps.part(end, last), now[0][-1])
            joined = map(np.concatenate, zip((now[0][:-1], *now[1:]), after, strict=True))
            for table, other in zip(tables, joined, strict=True):
                np.subtract(other[:, :, 0], table[0, begin:], out=table[column, begin:])
        courses = self._drawn(steps, *(np.ascontiguousarray(np.moveaxis(each, 0, 2)) for each in tables))
        values, slopes, changes, _ = self._interpolated(z, steps, courses, times)
        each_part = np.diff(changes.reshape(*values.shape, rows.size, parts), axis=3, prepend=0.0)
        return SimulatedRun(values, slopes, each_part.reshape(*values.shape, -1))

    def _integrate(self, z: Array, courses: Courses, slots: Sequence[int] = ()) -> _Tables:
        """States and sensitivities between steps, and their slopes at both ends of each step.

        The sensitivities are those by courses, which begin at rest or are the slots' own values.
        """
        x, by_slot = self.equations.begin(z, self._p, self._table[:, 0])
        begun = by_slot[:, list(slots)] if slots else np.zeros((x.size, courses.size))
        step = Integrator(self.equations, z, self._p, courses)
        states, left, right = step(self.steps, np.column_stack([x, begun]))
        if not np.isfinite(states[:, :, 0]).all():
            raise NotSimulatedError("with these values of the parameters the simulation is not finite")
        return self._drawn(self.steps, states, left, right)

    def _drawn(self, steps: Steps, states: Array, left: Array, right: Array) -> _Tables:
        """States and slopes; a curve through them gives those of the thin states."""
        if self._thin.size:
            left[:, self._thin], right[:, self._thin] = _drawn(steps, states[:, self._thin])
        return states, left, right

    def _interpolated(
        self, z: Array, steps: Steps, tables: _Tables, times: Array, slots: Sequence[int] = ()
    ) -> tuple[Array, Array, Array, Array]:
        """Outputs at times, their slopes, and derivatives through the states and directly by some slots.

        Cubic Hermite in time, as the states' slopes are known at both ends.
        """
        time, (states, left, right) = steps.time, tables
        k = np.clip(np.searchsorted(time, times, side="right") - 1, 0, time.size - 2)
        # Outputs are computed at the ends of the steps that are asked for alone: of an hourly log few are.
        asked, step = np.unique(k, return_inverse=True)
        points = np.union1d(asked, asked + 1)
        begin = np.searchsorted(points, asked)
        inputs = steps.inputs[np.append(steps.first, steps.first[-1:])[points]]
        y, by_state, direct = self.equations.observe(
            states[points, :, 0].T, z, self._p, inputs.T, time[points]
        )
        # (points, outputs, 1 + slots): value and sensitivity through the states
        through = by_state @ states[points]
        through[:, :, 0] = y
        known = np.concatenate([through, by_state[begin] @ left[asked], by_state[begin + 1] @ right[asked]])
        length = time[k + 1] - time[k]
        s = np.clip((times - time[k]) / length, 0.0, 1.0)
        at = begin[step]
        ends = np.stack([at, at + 1, points.size + step, points.size + asked.size + step], axis=1)
        inside = 6 * s * (1 - s) / length
        rates = -inside, inside, (1 - s) * (1 - 3 * s), s * (3 * s - 2)
        value = _weighted(hermite(s, length), ends, known)
        slope = _weighted(rates, ends, known[:, :, 0])
        by_slot = _weighted((1 - s, s), ends[:, :2], direct[:, :, list(slots)])
        return value[:, :, 0], slope, value[:, :, 1:], by_slot


def _drawn(steps: Steps, states: Array) -> tuple[Array, Array]:
    """Slopes at both ends of each step: parabolas through three points, lines where an input changes."""
    lines = np.diff(states, axis=0) / np.diff(steps.time)[:, None, None]
    left, right = lines.copy(), lines.copy()
    smooth = steps.follows[1:-1] & steps.follows[:-2]
    k = np.flatnonzero(smooth) + 1
    left[k] = right[k - 1] = np.gradient(states, steps.time, axis=0)[k]
    begins, ends = np.append(False, smooth), np.append(smooth, False)
    for other, alone, drawn in ((left, ends & ~begins, right), (right, begins & ~ends, left)):
        other[alone] = 2 * lines[alone] - drawn[alone]
    return left, right


def _weighted(weights: Sequence[Array], places: NDArray[np.int64], table: Array) -> Array:
    """Sums of a table's rows at places, shape (sums, terms), with a weight for each term, shape (sums,)."""
    from scipy.sparse import csr_array

    sums, terms = places.shape
    begins = np.arange(0, sums * terms + 1, terms)
    matrix = csr_array((np.stack(weights, axis=1).ravel(), places.ravel(), begins), shape=(sums, len(table)))
    return np.asarray(matrix @ table.reshape(len(table), -1)).reshape(sums, *table.shape[1:])
