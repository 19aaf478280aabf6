"""A joined component that goes through whole runs in one call, several runs side by side."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.packaging.native.lanes import runs_here
from warmlink.fmus.packaging.native.library import loaded

Array = NDArray[np.float64]

_CLOSE = 1e-9
"""Share of a micro step by which two instants may differ and be one."""

_ADVANCE, _RECORD, _FIRST_CLOCK = 0, 1, 2
"""What the C core is told to do next."""


@dataclass(frozen=True)
class Rollout:
    """A joined component, compiled for whole runs.

    Attributes
    ----------
    library : a shared library
    level : oldest processor that it runs on; None for any
    lanes : runs that go side by side
    starting : CasADi function, serialised, from the parameters to what the C core starts from
    parameters : start values by name, in the order of the parameters
    recorded : names of the outputs that are recorded
    sample_times : parameter of each clock
    micro_step : in s
    """

    library: bytes
    level: str | None
    lanes: int
    starting: str
    parameters: Mapping[str, float]
    recorded: tuple[str, ...]
    sample_times: tuple[str, ...]
    micro_step: float

    @property
    def runs_here(self) -> bool:
        """Whether this machine's processor knows the library's instructions."""
        return runs_here(self.level)

    def periods(self, given: Mapping[str, float]) -> tuple[float, ...]:
        """Sample times in s of a run with such parameters; runs go side by side only if these are equal."""
        return tuple(given.get(name, self.parameters[name]) for name in self.sample_times)

    def run(
        self, given: Sequence[Mapping[str, float]], count: int, step: float
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Run from 0 s on.

        Parameters
        ----------
        given : parameters of each run by name, at most `lanes` runs with equal `periods`
        count : number of communication steps
        step : communication step size in s

        Returns
        -------
        tuple
            Recorded values, shape (runs, recorded, count + 1), and whether the parameters and all that passed
            between the parts were finite and within their bounds, shape (runs,).
        """
        tasks, times, steps = task_list(count, step, self.periods(given[0]), self.micro_step)
        started = [self._started(values) for values in given]
        started += [started[-1]] * (self.lanes - len(given))
        *columns, refused = zip(*started, strict=True)
        sources, settled, states = (self._side_by_side(column) for column in columns)
        rows = aligned((count + 1, len(self.recorded) + 1, self.lanes))
        arrays = (tasks, times, steps, sources, settled, states, rows)
        loaded(self.library).rollout(
            ctypes.c_long(tasks.size), *(ctypes.c_void_p(each.ctypes.data) for each in arrays)
        )
        values = np.ascontiguousarray(rows.transpose(2, 1, 0)[: len(given)])
        return values[:, :-1], np.all(values[:, -1] == 0, axis=1) & (np.ravel(refused)[: len(given)] == 0)

    def _started(self, given: Mapping[str, float]) -> list[Array]:
        p = np.array([given.get(name, start) for name, start in self.parameters.items()])
        return [np.array(each).ravel() for each in _function(self.starting)(p)]

    def _side_by_side(self, column: Sequence[Array]) -> Array:
        held = aligned((column[0].size, self.lanes))
        held[:] = np.stack(column, axis=1)
        return held


@lru_cache(maxsize=8)
def task_list(count: int, step: float, periods: tuple[float, ...], micro_step: float) -> tuple[Any, ...]:
    """What is done in a run, when and with which step: numbers of tasks, times and steps in s.

    As the C core of an FMU does it: micro steps from instant to instant, then the clocks that are due, one
    after the other; at a communication point the values are recorded last.
    """
    stop = count * step
    points = step * np.arange(count + 1)
    found = [(points, np.full(points.size, _RECORD), np.full(points.size, step))]
    for clock, period in enumerate(periods):
        samples = period * np.arange(1, int(stop / period + _CLOSE) + 1)
        found.append((samples, np.full(samples.size, _FIRST_CLOCK + clock), np.full(samples.size, period)))
    instants, place = np.unique(
        np.round(np.concatenate([times for times, _, _ in found]) / (_CLOSE * micro_step)),
        return_inverse=True,
    )
    instants *= _CLOSE * micro_step
    gaps = np.diff(instants)
    micro = np.maximum(1, np.ceil(gaps / micro_step - _CLOSE)).astype(int)
    within = np.arange(micro.sum()) - np.repeat(np.cumsum(micro) - micro, micro)
    size = np.repeat(gaps / micro, micro)
    before = np.repeat(instants[:-1], micro) + within * size
    found.append((before, np.full(before.size, _ADVANCE), size))
    times, tasks, steps = (np.concatenate(column) for column in zip(*found, strict=True))
    place = np.concatenate([place, np.repeat(np.arange(1, instants.size), micro)])
    rank = np.where(tasks == _ADVANCE, -1.0, np.where(tasks == _RECORD, np.inf, tasks))
    order = np.lexsort((times, rank, place))
    return tasks[order].astype(np.int8), times[order].copy(), steps[order].copy()


def aligned(shape: tuple[int, ...]) -> Array:
    """Zeros that begin where vectors may be loaded from."""
    size = int(np.prod(shape))
    room = np.zeros(size + 8)
    first = -(room.ctypes.data // 8) % 8
    return room[first : first + size].reshape(shape)


@lru_cache(maxsize=16)
def _function(text: str) -> Any:
    import casadi

    return casadi.Function.deserialize(text)
