"""Tables over time that a component plays, row after row: of any length, as a recorded shift.

A column is held until the next row, or linear between rows. The declaration says what the columns are
(`Played`); the rows are data: of the declaration in Python, a file among the resources of an FMU.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warmlink.fmus.component.arithmetic import Number, real, symbolic
from warmlink.fmus.component.variables import Output
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead

Array = NDArray[np.float64]

EARLY = 1e-6
"""s by which rounding, also that of a master that adds its steps up, may miss the time of a row."""

_FORMAT = "warmlink table 1"
_HELD, _LINEAR = 0, 1
_HANDLES = count(1)
_TABLES: WeakValueDictionary[int, RecordedTable] = WeakValueDictionary()
"""Tables of this process by the number that stands for them among the settled parameters."""


class RecordedTable:
    """Rows over time: times, and for each column a value in every row, or one for all of them.

    Attributes
    ----------
    times : of the rows in s, which increase, shape (rows,)
    names : of the columns
    columns : their values in SI units, each of shape (rows,) or, where constant, (1,)
    linear : names of the columns that are linear between rows; the others hold until the next row
    """

    def __init__(
        self, times: ArrayLike, columns: Mapping[str, ArrayLike], linear: Collection[str] = ()
    ) -> None:
        """Take rows; InputError if there are none, time does not increase, or a value is not finite."""
        self.times = np.ascontiguousarray(times, dtype=float)
        self.names = tuple(columns)
        self.linear = frozenset(linear)
        if self.times.ndim != 1 or not self.times.size:
            raise InputError("a table needs rows; give at least one time")
        if not np.all(np.isfinite(self.times)):
            raise InputError(f"row {1 + int(np.argmin(np.isfinite(self.times)))}: its time is not finite")
        still = np.flatnonzero(np.diff(self.times) <= 0)
        if still.size:
            row = int(still[0]) + 2
            told = f"row {row}: its time, {self.times[row - 1]:.10g} s, is not after that of the row before"
            raise InputError(f"{told}; put the rows in order, each time once")
        self.columns = tuple(_column(self.times, name, values) for name, values in columns.items())
        unknown = sorted(self.linear - {*self.names})
        if unknown:
            raise InputError(f"linear: {unknown[0]} is no column; {instead(unknown[0], self.names)}")
        self._register()

    def _register(self) -> None:
        self.handle = next(_HANDLES)
        _TABLES[self.handle] = self
        named = enumerate(zip(self.names, self.columns, strict=True))
        self._moving = [k for k, (name, each) in named if name in self.linear and each.size > 1]

    def __reduce__(self) -> tuple[Any, ...]:
        return RecordedTable, (self.times, dict(zip(self.names, self.columns, strict=True)), self.linear)

    @property
    def end(self) -> float:
        """Time in s of the last row, which holds from then on."""
        return float(self.times[-1])

    def ends_before(self, time: float) -> bool:
        """Whether a time in s lies beyond the last row; one row alone is for ever."""
        return self.times.size > 1 and time > self.end + EARLY

    def at(self, time: float) -> Array:
        """The row that holds at a time in s: its time, values, and their rates, shape (1 + 2 columns,).

        A column is its value and the rate times what has passed since the row's time. Before the first row
        that one holds, after the last row the last.
        """
        after = int(self.times.searchsorted(time + EARLY, side="right"))
        i, between = max(after - 1, 0), 0 < after < self.times.size
        begins = self.times.item(i)
        values = [each.item(i) if each.size > 1 else each.item(0) for each in self.columns]
        rates = [0.0] * len(values)
        for k in self._moving if between else ():
            rates[k] = (self.columns[k].item(i + 1) - values[k]) / (self.times.item(i + 1) - begins)
        return np.array([begins, *values, *rates])

    def over(self, times: Array) -> Array:
        """Values of the columns at times in s, shape (times, columns), bit for bit as one by one."""
        after = self.times.searchsorted(times + EARLY, side="right")
        i = np.maximum(after - 1, 0)
        found = np.empty((times.size, len(self.columns)))
        between = (after > 0) & (after < self.times.size)
        j = np.where(between, after, i)
        lasts, passed = np.where(between, self.times[j] - self.times[i], 1.0), times - self.times[i]
        for k, (name, each) in enumerate(zip(self.names, self.columns, strict=True)):
            if each.size == 1:
                found[:, k] = each[0]
            else:
                rates = (each[j] - each[i]) / lasts if name in self.linear else 0.0
                found[:, k] = each[i] + rates * passed
        return found

    def until(self, time: float) -> RecordedTable:
        """The table without the rows that a run up to a time in s does not need."""
        last = int(self.times.searchsorted(time + EARLY, side="right")) + 1  # and where a linear one goes
        if last >= self.times.size:
            return self
        return RecordedTable(
            self.times[:last],
            {name: each[:last] for name, each in zip(self.names, self.columns, strict=True)},
            self.linear,
        )

    @cached_property
    def digest(self) -> str:
        """Digest of the whole content."""
        return hashlib.sha256(self.content({})).hexdigest()

    def content(self, units: Mapping[str, str]) -> bytes:
        """Content of the table's file; `units` of the columns stand in its first line.

        A line of text, filled up with blanks to a multiple of eight bytes, names the columns. Numbers of
        eight bytes follow, lowest byte first: how many rows; for each column whether it is linear (1) or
        held (0) and how many values it has, whole numbers; the times; the columns' values, doubles; and the
        CRC-32 of all before.
        """
        head = heading(self.names, units)
        counts = [self.times.size]
        for name, each in zip(self.names, self.columns, strict=True):
            counts += [_LINEAR if name in self.linear else _HELD, each.size]
        whole = struct.pack(f"<{len(counts)}Q", *counts)
        body = b"".join(
            [head, whole, *(each.astype("<f8").tobytes() for each in (self.times, *self.columns))]
        )
        return body + struct.pack("<Q", zlib.crc32(body))


def read_table(content: bytes, names: Sequence[str], units: Mapping[str, str], where: str) -> RecordedTable:
    """Table in the content of its file; InputError where it is damaged or has other columns."""
    head = heading(names, units)
    if not content.startswith(head):
        found = content[:200].partition(b"\n")[0].decode("utf-8", "replace").strip()
        told = f"begins with {found!r} in place of {head.decode().strip()!r}"
        raise InputError(f"{where}: {told}; write it with warmlink")
    kinds = 2 * len(names)
    whole = len(content) >= len(head) + 8 * (1 + kinds)
    numbers = np.frombuffer(content, "<u8", 1 + kinds, len(head)).tolist() if whole else []
    sizes = [numbers[0], *numbers[2::2]] if whole else []
    total = len(head) + 8 * (2 + kinds + sum(sizes))
    if not sizes or len(content) != total or any(n not in (1, sizes[0]) for n in sizes):
        raise InputError(f"{where}: holds {len(content)} bytes, which are not its rows; write it anew")
    if struct.unpack("<Q", content[-8:])[0] != zlib.crc32(content[:-8]):
        raise InputError(f"{where}: is damaged, its checksum differs; write it anew")
    values = np.frombuffer(content, "<f8", sum(sizes), len(head) + 8 * (1 + kinds)).astype(float)
    times, *columns = np.split(values, np.cumsum(sizes)[:-1])
    linear = [name for name, kind in zip(names, numbers[1::2], strict=True) if kind == _LINEAR]
    return RecordedTable(times, dict(zip(names, columns, strict=True)), linear)


def heading(names: Sequence[str], units: Mapping[str, str]) -> bytes:
    """First line of a table's file."""
    columns = ", ".join(f"{name} [{units.get(name, '1')}]" for name in names)
    told = f"{_FORMAT}: {columns}"
    blanks = -(len(told.encode()) + 1) % 8
    return f"{told}{' ' * blanks}\n".encode()


@dataclass(frozen=True)
class Played:
    """A table that a component plays.

    Attributes
    ----------
    name : of the derived quantity that stands for the table in `table_row`
    columns : outputs whose courses the table's columns are, in this order
    table : the rows
    """

    name: str
    columns: tuple[Output, ...]
    table: RecordedTable

    def __post_init__(self) -> None:
        wanted = tuple(own_name(each.name) for each in self.columns)
        if self.table.names != wanted:
            had = ", ".join(self.table.names)
            raise InputError(
                f"{self.name}: a table of {had or 'nothing'}; give {', '.join(wanted)}, in this order"
            )
        for variable, values in zip(self.columns, self.table.columns, strict=True):
            _check_column(variable, values, own_name(variable.name) in self.table.linear)

    @property
    def file(self) -> str:
        """Name of the table's file among an FMU's resources."""
        return f"{self.name}.table"

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column."""
        return {own_name(each.name): each.unit for each in self.columns}

    @property
    def head(self) -> bytes:
        """First line of the table's file."""
        return heading(self.table.names, self.units)

    @property
    def content(self) -> bytes:
        """Content of the table's file."""
        return self.table.content(self.units)

    def read(self, content: bytes, where: str) -> Played:
        """The same with the table in the content of its file; raises as `read_table`."""
        return Played(self.name, self.columns, read_table(content, self.table.names, self.units, where))

    def until(self, time: float) -> Played:
        """The same without the rows that a run up to a time in s does not need."""
        return replace(self, table=self.table.until(time))

    @property
    def ended(self) -> str:
        """Sentence on a run that goes on after the last row."""
        part = self.name.rpartition(".")[0]
        return (
            f"{part and '.'}{part}: its table ends at {self.table.end:g} s; the last row holds from then on"
        )


def own_name(name: str) -> str:
    """Name of a variable inside its part."""
    return name.rpartition(".")[2]


def table_row(handle: Number, time: Number, columns: int) -> Number:
    """The row that holds at a time in s, as `RecordedTable.at`; a settled parameter stands for the table.

    In CasADi it is a call of a function of so many columns that the C core has by hand.
    """
    if symbolic(handle, time):
        return _by_hand(columns)(handle, time)
    return _TABLES[int(real(handle))].at(float(real(time)))


def values_at(row: Number, time: Number, columns: int) -> Number:
    """Values of the columns at a time in s from the row that holds then, shape (columns,)."""
    return row[1 : 1 + columns] + row[1 + columns :] * (time - row[0])


@cache
def _by_hand(columns: int) -> Any:
    """CasADi function in place of the C: it depends on both arguments, has no slope, and is no number."""
    import casadi

    from warmlink.fmus.calls import by_hand

    handle, time = casadi.MX.sym("handle"), casadi.MX.sym("time")
    unknown = casadi.floor((handle + time) * float("nan"))
    return by_hand("table_row", [handle, time], casadi.vertcat(*[unknown] * (1 + 2 * columns)))


def _column(times: Array, name: str, values: ArrayLike) -> Array:
    found = np.ascontiguousarray(values, dtype=float).reshape(-1)
    if found.size not in (1, times.size):
        raise InputError(
            f"{name}: {found.size} values for {times.size} rows; give one for each, or one for all"
        )
    wild = np.flatnonzero(~np.isfinite(found))
    if wild.size:
        raise InputError(f"{name}: row {int(wild[0]) + 1}: {found[wild[0]]} is not finite; give a number")
    return found[:1].copy() if np.all(found == found[0]) else found


def _check_column(variable: Output, values: Array, linear: bool) -> None:
    """Raise InputError where a column has a value that its variable may not have."""
    name, whole = own_name(variable.name), variable.type != "Real"
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    if whole and linear:
        raise InputError(f"{name}: is a whole number, so it cannot be linear between rows; hold it")
    low, high = (
        (0.0, float(variable.choice.last)) if variable.choice else (variable.minimum, variable.maximum)
    )
    low, high = -np.inf if low is None else low, np.inf if high is None else high
    for wrong, told in (
        (values < low, f"is too low; give at least {low:g}{unit}"),
        (values > high, f"is too high; give at most {high:g}{unit}"),
        (whole & (values != np.round(values)), "is not a whole number; give one"),
    ):
        for row in np.flatnonzero(wrong)[:1].tolist():
            raise InputError(f"{name}: row {row + 1}: {values[row]:.10g}{unit} {told}")
