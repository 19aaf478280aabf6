"""A joined component that goes through whole runs in one call, several runs side by side."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.table import RecordedTable
from warmlink.fmus.packaging.native.library import loaded, processor

Array = NDArray[np.float64]

Given = Mapping[str, Mapping[str, Any]]
"""Parameters of a run, by part and name."""

Played = Mapping[str, RecordedTable]
"""Tables that a run plays, by the part in whose place they stand."""

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
    starting : CasADi function from the parameters to what the C core starts from
    table : CasADi function from what such parts settle and the time to what they give
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
    starting: Any
    table: Any
    parameters: Mapping[str, float]
    recorded: tuple[str, ...]
    sample_times: tuple[str, ...]
    micro_step: float
    given: tuple[str, ...]
    inputs: Mapping[str, float]

    def periods(self, given: Given) -> tuple[float, ...] | None:
        """Sample times in s of a run with such start values; runs go side by side only if these are equal.

        None for a run that is not for this library: this machine's processor does not know its instructions,
        or an input that nothing feeds has another value than here.
        """
        known = self.level is None or self.level <= (processor()[1] or "")
        if not known or any(_value(given, *start) != start[1] for start in self.inputs.items()):
            return None
        return tuple(_value(given, name, self.parameters[name]) for name in self.sample_times)

    def run(
        self,
        given: Sequence[Given],
        count: int,
        step: float,
        drive: Array | None = None,
        played: Sequence[Played] = (),
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Take so many communication steps (in s) from 0 s on, in at most `lanes` runs of equal `periods`.

        A `drive` stands in place of what the parts give that nothing drives: a row for each instant, which
        holds for the micro steps before it, shape (instants, given). Tables that are `played` in a run stand
        in place of what parts of their names give.
        Gives recorded values, shape (runs, recorded, count + 1), and whether the parameters and all that
        passed between the parts were finite and within their bounds, shape (runs,).
        """
        periods = self.periods(given[0])
        assert periods is not None
        schedule = count, step, periods, self.micro_step
        tasks, times, steps = task_list(*schedule)
        free, driven, states, refused = self._started(given)
        if drive is None:
            every = [*played, *[played[-1] if played else {}] * (self.lanes - len(played))]
            settled = (each.tobytes() for each in free.T)
            tables = [self._table(*each, schedule) for each in zip(settled, every, strict=True)]
        else:
            tables = [_by_change(drive)] * self.lanes
            times = np.round(np.where(tasks == _ADVANCE, times + steps, times), 6)
        pointers = np.array([each.ctypes.data for each in tables], dtype=np.uintp)
        rows = np.empty((self.lanes, len(self.recorded), count + 1))
        arrays = (tasks, times, steps, pointers, driven, states, rows, refused)
        sizes = ctypes.c_long(tasks.size), ctypes.c_long(count + 1)
        loaded(self.library).rollout(*sizes, *(each.ctypes for each in arrays))
        return rows[: len(given)], refused[0, : len(given)] == 0

    def _table(self, settled: bytes, played: Played, schedule: tuple[Any, ...]) -> Array:
        """What is given from instant to instant, as `_by_change`."""
        if not played:
            return _table(self.table, settled, schedule)
        instants = _instants(schedule)
        rows = _values(self.table, settled, instants)
        for part, table in played.items():
            own = dict(zip(table.names, table.over(instants).T, strict=True))
            for i, name in enumerate(self.given):
                if name.rpartition(".")[0] == part:
                    rows[:, i] = own[name.rpartition(".")[2]]
        return _by_change(rows)

    def _started(self, given: Sequence[Given]) -> list[Array]:
        """What each run starts from, side by side, the last run in the lanes that are left."""
        own = [{f"{part}.{k}": v for part, of in each.items() for k, v in of.items()} for each in given]
        rows = [[values.get(name, start) for name, start in self.parameters.items()] for values in own]
        p = np.array(rows + rows[-1:] * (self.lanes - len(rows)), np.float64)
        return [aligned(each.toarray()) for each in self.starting(p.T)]


def _value(given: Given, name: str, start: float) -> float:
    """A run's value by its full name; by default it starts as ever."""
    part, _, own = name.rpartition(".")
    return float(given.get(part, {}).get(own, start))


@lru_cache(maxsize=8)
def task_list(count: int, step: float, periods: tuple[float, ...], micro_step: float) -> tuple[Any, ...]:
    """What is done in a run, when and with which step: numbers of tasks, times and steps in s.

    As the C core of an FMU does it: micro steps from instant to instant, then the clocks that are due, one
    after the other; at a communication point the values are recorded last.
    """
    due = [period * np.arange(1, int(count * step / period + _CLOSE) + 1) for period in periods]
    due.append(step * np.arange(count + 1))
    instants, place = np.unique(np.round(np.concatenate(due) / (_CLOSE * micro_step)), return_inverse=True)
    instants *= _CLOSE * micro_step
    gaps = np.diff(instants)
    micro = np.maximum(1, np.ceil(gaps / micro_step - _CLOSE)).astype(int)
    within = np.arange(micro.sum()) - np.repeat(np.cumsum(micro) - micro, micro)
    size = np.repeat(gaps / micro, micro)
    before = np.repeat(instants[:-1], micro) + within * size
    sizes = [before.size, *map(len, due)]
    times = np.concatenate([before, *due])
    tasks = np.repeat([_ADVANCE, *(_FIRST_CLOCK + clock for clock in range(len(periods))), _RECORD], sizes)
    steps = np.concatenate([size, np.repeat([*periods, step], sizes[1:])])
    order = np.argsort(np.append(np.repeat(np.arange(1, instants.size), micro), place), kind="stable")
    return tasks[order].astype(np.int8), times[order], steps[order]


@lru_cache(maxsize=32)
def _table(function: Any, settled: bytes, schedule: tuple[Any, ...]) -> Array:
    """What parts that nothing drives give, from what they settled, as `_by_change`."""
    return _by_change(_values(function, settled, _instants(schedule)))


def _values(function: Any, settled: bytes, instants: Array) -> Array:
    """What such parts give at instants in s, shape (instants, given)."""
    return np.array(function(np.frombuffer(settled), instants[None]).toarray().T)


def _instants(schedule: tuple[Any, ...]) -> Array:
    """Instants in s at which anything is done."""
    _, done, _ = task_list(*schedule)
    return np.asarray(done[np.append(True, np.diff(done) != 0)])


def _by_change(rows: Array) -> Array:
    """A row for each change, of those for each instant.

    It begins with the number of the instant from which it holds; that of the last one never comes.
    """
    changes = np.flatnonzero(np.append(True, np.any(rows[1:] != rows[:-1], axis=1)))
    return np.vstack([np.column_stack([changes, rows[changes]]), np.full(rows.shape[1] + 1, -1.0)])


def aligned(values: Array) -> Array:
    """A copy that begins where vectors may be loaded from."""
    room = np.empty(values.size + 8)
    first = -(room.ctypes.data // 8) % 8
    room[first : first + values.size] = values.ravel()
    return room[first : first + values.size].reshape(values.shape)
