"""A joined component that goes through whole runs in one call, several runs side by side."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.packaging.native.library import loaded, processor

Array = NDArray[np.float64]

Given = Mapping[str, Mapping[str, Any]]
"""Parameters of a run, by part and name."""

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
    recorded : names of the outputs and states that are recorded
    sample_times : parameter of each clock
    micro_step : in s
    given : names of what those parts give that nothing drives
    inputs : start values by name of the inputs that nothing feeds, which they keep in every run
    """

    library: bytes
    level: str | None
    lanes: int
    starting: str
    parameters: Mapping[str, float]
    recorded: tuple[str, ...]
    sample_times: tuple[str, ...]
    micro_step: float
    given: tuple[str, ...]
    inputs: Mapping[str, float]

    @property
    def runs_here(self) -> bool:
        """Whether this machine's processor knows the library's instructions."""
        return self.level is None or self.level <= (processor()[1] or "")

    def periods(self, given: Given) -> tuple[float, ...]:
        """Sample times in s of a run with such parameters; runs go side by side only if these are equal."""
        split = ((*full.rpartition("."), self.parameters[full]) for full in self.sample_times)
        return tuple(given.get(part, {}).get(name, start) for part, _, name, start in split)

    def takes(self, given: Given) -> bool:
        """Whether a run with such start values leaves the inputs that nothing feeds as they are here."""
        split = ((*name.rpartition("."), start) for name, start in self.inputs.items())
        return all(given.get(part, {}).get(name, start) == start for part, _, name, start in split)

    def run(
        self, given: Sequence[Given], count: int, step: float, drive: Array | None = None
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Take so many communication steps (in s) from 0 s on, in at most `lanes` runs with equal `periods`.

        A `drive` stands in place of what the parts give that nothing drives: a row for each instant, which
        holds for the micro steps before it, shape (instants, given).
        Gives recorded values, shape (runs, recorded, count + 1), and whether the parameters and all that
        passed between the parts were finite and within their bounds, shape (runs,).
        """
        schedule = count, step, self.periods(given[0]), self.micro_step
        tasks, times, steps = task_list(*schedule)
        free, driven, states, refused = self._started(given)
        if drive is None:
            size = len(self.given)
            tables = [_table(self.library, size, self.lanes, each.tobytes(), schedule) for each in free.T]
        else:
            tables = [_by_change(drive)] * self.lanes
            times = np.round(np.where(tasks == _ADVANCE, times + steps, times), 6)
        pointers = np.array([each.ctypes.data for each in tables], dtype=np.uintp)
        rows = np.empty((self.lanes, len(self.recorded), count + 1))
        arrays = (times, steps, pointers, driven, states, rows, refused)
        loaded(self.library).rollout(
            ctypes.c_long(tasks.size),
            ctypes.c_long(count + 1),
            *(_pointer(each) for each in (tasks, *arrays)),
        )
        return rows[: len(given)], refused[0, : len(given)] == 0

    @cached_property
    def _places(self) -> dict[str, dict[str, int]]:
        found: dict[str, dict[str, int]] = {}
        for place, name in enumerate(self.parameters):
            part, _, variable = name.rpartition(".")
            found.setdefault(part, {})[variable] = place
        return found

    def _started(self, given: Sequence[Given]) -> list[Array]:
        """What each run starts from, side by side, the last run in the lanes that are left."""
        p = np.tile(np.fromiter(self.parameters.values(), np.float64), (self.lanes, 1))
        for row, values in zip(p, given, strict=False):
            for part, of in values.items():
                places = self._places.get(part, {})
                known = {places[name]: value for name, value in of.items() if name in places}
                row[[*known]] = [*known.values()]
        p[len(given) :] = p[len(given) - 1]
        started = []
        for each in _function(self.starting)(p.T):
            held = aligned((each.shape[0], self.lanes))
            held[:] = each.toarray()
            started.append(held)
        return started


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
    return tasks[order].astype(np.int8), times[order], steps[order]


@lru_cache(maxsize=32)
def _table(library: bytes, given: int, lanes: int, settled: bytes, schedule: tuple[Any, ...]) -> Array:
    """What parts that nothing drives give, from what they settled, as `_by_change`."""
    _, done, _ = task_list(*schedule)
    instants = done[np.append(True, np.diff(done) != 0)]
    blocks = -(-instants.size // lanes)
    times, free = aligned((blocks, lanes)), aligned((len(settled) // 8, lanes))
    times[:] = instants[-1]
    times.flat[: instants.size] = instants
    free[:] = np.frombuffer(settled)[:, None]
    found = aligned((blocks, given, lanes))
    loaded(library).table(ctypes.c_long(blocks), _pointer(times), _pointer(free), _pointer(found))
    return _by_change(found.transpose(0, 2, 1).reshape(times.size, given))


def _by_change(rows: Array) -> Array:
    """A row for each change, of those for each instant.

    It begins with the number of the instant from which it holds; that of the last one never comes.
    """
    changes = np.flatnonzero(np.append(True, np.any(rows[1:] != rows[:-1], axis=1)))
    return np.vstack([np.column_stack([changes, rows[changes]]), np.full(rows.shape[1] + 1, -1.0)])


def _pointer(array: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


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
