"""States and their sensitivities over the steps of a run, together, by ROS2 (`fmus/component/integrator.py`).

The sensitivities are those of its stages with the matrix held, which is of order 2 as the method is for any
matrix. The loop runs in C where the equations were compiled, see `Equations.library`; else here, on CasADi's
own machine.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import chain, pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.integrator import GAMMA, ros2
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.equations import Equations, Indices, bound


@dataclass(frozen=True)
class Steps:
    """Steps: points in s between them, and what acts in each.

    Attributes
    ----------
    time : shape (steps + 1,), or (groups, steps + 1) for as many in each group, which has a start of its own
    inputs : the levels that the inputs take, shape (levels, inputs), row by row
    begins : where the levels of each step begin in those of all, and where the last ones end
    levels, shares : levels that act, step by step, and their shares of its length
    """

    time: Array
    inputs: Array
    begins: Indices
    levels: Indices
    shares: Array

    @property
    def together(self) -> int:
        """Number of steps that follow one another from each start."""
        return self.time.shape[-1] - 1

    @property
    def evaluations(self) -> int:
        """How often the rates are asked for, about: twice on each level that acts in a step."""
        return 2 * int(self.begins[-1] - self.begins[0])

    @property
    def first(self) -> Indices:
        """The level on which each step begins, shape (steps,)."""
        return self.levels[self.begins[:-1]]

    @cached_property
    def follows(self) -> NDArray[np.bool_]:
        """Whether a step begins on the one level on which the one before ends, for each and the end."""
        single = np.diff(self.begins) == 1
        same = single[1:] & single[:-1] & (np.diff(self.first) == 0)
        found = np.concatenate([[False], same, [False]])
        found[:: self.together] = False
        return found

    def part(self, first: int, last: int) -> Steps:
        """Steps that follow one another from one point to another."""
        time, begins = self.time[first : last + 1], self.begins[first : last + 1]
        return replace(self, time=time, begins=begins)

    def on(self, inputs: Array) -> Steps:
        """The same steps on one level of the inputs, shape (inputs,)."""
        each = np.arange(len(self.begins))
        return Steps(self.time, inputs.copy()[None], each, np.zeros_like(each[1:]), np.ones(each.size - 1))


@dataclass(frozen=True)
class Courses:
    """Courses in time that are added to slots, each a broken line over the same nodes.

    `added_to` has for each course the indices of the slots to which it adds; no two add to the same slot.
    The nodes are in s, rising, shape (nodes,); a single one for courses that stay the same.
    """

    added_to: tuple[tuple[int, ...], ...]
    nodes: Array

    @property
    def size(self) -> int:
        """Number of values at nodes, by which there are sensitivities."""
        return len(self.added_to) * self.nodes.size

    def __call__(self, by_slot: Array, time: float) -> Array:
        """Derivatives at a time by the values at the nodes, shape (n, values), from those by slot."""
        if self.nodes.size == 1 and all(len(slots) == 1 for slots in self.added_to):
            return by_slot[:, [slot for (slot,) in self.added_to]]
        at = self._hats(time)
        parts = [np.outer(by_slot[:, list(slots)].sum(axis=1), at) for slots in self.added_to]
        return np.concatenate([np.empty((len(by_slot), 0)), *parts], axis=1)

    def _hats(self, time: float) -> Array:
        """What each node has of the broken lines at a time, shape (nodes,)."""
        at, last = np.zeros(self.nodes.size), self.nodes.size - 1
        k = min(max(int(np.searchsorted(self.nodes, time, side="right")) - 1, 0), max(last - 1, 0))
        share = (time - self.nodes[k]) / (self.nodes[k + 1] - self.nodes[k]) if last else 0.0
        at[min(k + 1, last)] = min(max(share, 0.0), 1.0)
        at[k] = 1.0 - min(max(share, 0.0), 1.0)
        return at


def staying(slots: Iterable[int]) -> Courses:
    """Courses that stay the same, one added to each of some slots."""
    return Courses(tuple((i,) for i in slots), np.zeros(1))


Acting = Sequence[tuple[Array, float]]
"""Inputs that act in a step, shape (inputs,) each, and their shares of it."""

NONE = Courses((), np.zeros(1))
"""For states without sensitivities."""


class Integrator:
    """Steps a system at given values of its slots and parameters.

    Parameters
    ----------
    equations : the system
    z, p : slots and parameters in SI
    courses : what the sensitivities are by: the values of these at their nodes
    """

    def __init__(self, equations: Equations, z: Array, p: Array, courses: Courses = NONE) -> None:
        z, p = np.array(z, dtype=float), np.array(p, dtype=float)
        self._equations, self._of = equations, (equations, z, p, courses)

    def __call__(self, steps: Steps, begun: Array) -> tuple[Array, Array, Array]:
        """Step on from states at each start, shape (..., n, 1 + values), the sensitivities beside each state.

        Returns
        -------
        tuple of numpy.ndarray
            States at the points, shape (..., points, n, 1 + values), and slopes at the start and the end
            of each step, shape (steps, n, 1 + values).
        """
        table = begun.shape[-2:]
        states = np.empty((*steps.time.shape, *table))
        left, right = np.empty((2, len(steps.begins) - 1, *table))
        states[..., 0, :, :] = begun
        compiled = self._equations.library(steps.evaluations) is not None
        fill = self._in_c if compiled else self._on_casadi
        fill(steps, states.reshape(-1, *table), left, right)
        return states, left, right

    @cached_property
    def _on_casadi(self) -> _OnCasadi:
        return _OnCasadi(*self._of)

    @cached_property
    def _in_c(self) -> _InC:
        library = self._equations.library()
        assert library is not None
        return _InC(library, *self._of)


class _OnCasadi:
    """Fills the tables of `Integrator` on CasADi's machine."""

    def __init__(self, equations: Equations, z: Array, p: Array, courses: Courses) -> None:
        self._equations, self._courses, linear = equations, courses, equations.linear
        self._x, self._w, self._time = (np.zeros(linear.size1_in(i)) for i in (0, 3, 4))
        sizes = [linear.nnz_out(i) for i in range(3)]
        self._found, self._ends = np.zeros(sum(sizes)), np.cumsum(sizes)[:-1]
        found = np.split(self._found, self._ends)
        self._buffer, self._evaluate = bound(linear, [self._x, z, p, self._w, self._time], found)
        self._kept = z, p
        self._tables = [np.zeros((self._x.size, count)) for count in (self._x.size, equations.columns)]
        rows = np.arange(self._x.size)
        self._places = [
            np.repeat(rows, np.diff(begins)) * table.shape[1] + columns
            for table, (begins, columns) in zip(self._tables, equations.by_row, strict=True)
        ]

    @np.errstate(over="ignore", invalid="ignore")  # whoever asks refuses what is not finite
    def __call__(self, steps: Steps, states: Array, left: Array, right: Array) -> None:
        self._equations.taken += steps.evaluations
        time = steps.time.ravel().tolist()
        for k, (first, last) in enumerate(pairwise(steps.begins.tolist())):
            at = k + k // steps.together
            start, end = time[at : at + 2]
            acting = list(zip(steps.inputs[steps.levels[first:last]], steps.shares[first:last], strict=True))
            left[k], jacobian = self._slopes(start, acting, states[at])
            if steps.follows[k]:
                right[k - 1] = left[k]
            inverse = _inverse(np.eye(len(jacobian)) - GAMMA * (end - start) * jacobian)
            ending = partial(self._slopes_alone, end, acting)
            states[at + 1] = ros2(left[k], inverse.__matmul__, ending, states[at], end - start)
            if not steps.follows[k + 1]:
                right[k] = ending(states[at + 1])

    def _at(self, inputs: Array) -> Array:
        """Rates, and what is not zero of their derivatives, until next time."""
        self._w[:] = inputs
        self._evaluate()
        return self._found

    def _slopes_alone(self, time: float, acting: Acting, at: Array) -> Array:
        return self._slopes(time, acting, at)[0]

    def _slopes(self, time: float, acting: Acting, at: Array) -> tuple[Array, Array]:
        """Slopes averaged over the inputs that act, each with its share, and the Jacobian for now."""
        self._x[:], self._time[0] = at[:, 0], time
        mean = self._at(acting[0][0])
        if len(acting) > 1:
            mean = np.sum([share * self._at(inputs) for inputs, share in acting], axis=0)
        first, second = self._ends
        parts = mean[first:second], mean[second:]
        for table, places, values in zip(self._tables, self._places, parts, strict=True):
            table.reshape(-1)[places] = values
        jacobian, by_slot = self._tables
        result: Array = jacobian @ at
        result[:, 0] = mean[:first]
        result[:, 1:] += self._courses(by_slot, time)
        return result, jacobian


def _inverse(matrix: Array) -> Array:
    from scipy.linalg.lapack import dgetrf, dgetri  # half the time of `numpy.linalg.inv` at twenty states

    factors, pivots, _ = dgetrf(matrix, overwrite_a=True)
    return np.asarray(dgetri(factors, pivots, overwrite_lu=True)[0])


class _System(ctypes.Structure):
    """`System` of `integrator.c`: eight sizes, and where eight tables are."""

    _fields_ = (
        *((f"size_{i}", ctypes.c_int64) for i in range(8)),
        *((f"table_{i}", ctypes.c_void_p) for i in range(8)),
    )


class _InC:
    """The same in C."""

    def __init__(
        self, library: ctypes.CDLL, equations: Equations, z: Array, p: Array, courses: Courses
    ) -> None:
        linear, self._integrate = equations.linear, library.integrate
        sizes = linear.size1_in(0), 1 + courses.size, linear.size1_in(3)
        work = linear.sz_arg(), linear.sz_res(), linear.sz_iw(), linear.sz_w(), courses.nodes.size
        course_of_slot = np.full(z.size, -1, dtype=np.int64)
        for course, added_to in enumerate(courses.added_to):
            course_of_slot[list(added_to)] = course
        # C has the arrays' addresses alone.
        self._kept = *chain(*equations.by_row), z, p, courses.nodes, course_of_slot
        self._system = _System(*sizes, *work, *(each.ctypes.data for each in self._kept))

    def __call__(self, steps: Steps, states: Array, left: Array, right: Array) -> None:
        tables = steps.time, steps.begins, steps.levels, steps.shares, steps.inputs  # as in `integrator.c`
        laid = (ctypes.c_void_p * len(tables))(*(each.ctypes.data for each in tables))
        filled = (ctypes.c_void_p(each.ctypes.data) for each in (states, left, right))
        count, together = ctypes.c_int64(len(left)), ctypes.c_int64(steps.together)
        gamma = ctypes.c_double(GAMMA)
        if self._integrate(ctypes.byref(self._system), laid, count, together, gamma, *filled):
            raise MemoryError
