"""What a law's functions are made of, in no language yet: assignments, loops and calls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from math import isnan
from typing import Any

SIDE = "side"
"""Variable of a loop over two that lie side by side."""


@dataclass(eq=False)
class Slot:
    """A variable.

    Attributes
    ----------
    name : within its record
    shape : () for a number; an array lies element after element
    record : `state`, `next`, `input`, `output`, `design`, `recall`, `clock`; `argument`, `result` or `kept`
        (both) of a function; `local`
    condition : whether it holds true or false
    values, whole : of a constant, and whether they are whole numbers
    paired : whether it holds two of each number side by side, of which a loop over `SIDE` takes one
    unit, about : what it is
    """

    name: str
    shape: tuple[int, ...] = ()
    record: str = "local"
    condition: bool = False
    values: Any = None
    whole: bool = False
    paired: bool = False
    unit: str = ""
    about: str = ""

    @property
    def array(self) -> bool:
        """Whether it has elements."""
        return bool(self.shape) or self.paired

    @property
    def size(self) -> int:
        """Number of elements."""
        count = 2 if self.paired else 1
        for each in self.shape:
            count *= each
        return count


@dataclass(frozen=True)
class Index:
    """Place of an element: a number, loop variables times numbers, and `of_tables` times what tables hold."""

    constant: int = 0
    terms: tuple[tuple[str, int], ...] = ()
    tables: tuple[tuple[Slot, Index], ...] = ()
    of_tables: int = 1

    def text(self) -> str:
        """The place as C and Structured Text alike have it."""
        times = "" if self.of_tables == 1 else f"{self.of_tables} * "
        parts = [
            *(name if pace == 1 else f"{pace} * {name}" for name, pace in self.terms if pace),
            *(f"{times}{slot.name}[{inner.text()}]" for slot, inner in self.tables),
        ]
        if not parts:
            return str(self.constant)
        text = " + ".join(parts)
        if self.constant:
            text += f" {'+' if self.constant > 0 else '-'} {abs(self.constant)}"
        return text.replace("+ -", "- ")


@dataclass(frozen=True)
class KnownNumber:
    """A number."""

    value: float


@dataclass(frozen=True)
class Read:
    """An element of a variable; without an index a variable as a whole."""

    slot: Slot
    index: Index | None = None

    @property
    def place(self) -> Index | None:
        """Where the element lies; of one of two side by side, by the loop over them."""
        if self.index is None or not self.slot.paired:
            return self.index
        of = self.index
        terms = (*((name, 2 * pace) for name, pace in of.terms), (SIDE, 1))
        return Index(2 * of.constant, terms, of.tables, 2)


@dataclass(frozen=True)
class Operation:
    """A function of values: a key of `expressions.FUNCTIONS`, or `ratio` and `root`, which are guarded."""

    kind: str
    of: tuple[Value, ...]


Value = KnownNumber | Read | Operation


@dataclass
class Set:
    """An assignment."""

    to: Read
    value: Value


@dataclass
class For:
    """A loop from 0 to below `count`."""

    variable: str
    count: int
    body: list[Statement]


@dataclass
class Invoke:
    """A call, where `asked` holds: values of numbers, variables of arrays, by the function's own.

    With `fresh` what it would write to the next states goes into a record of that kind by itself.
    """

    function: Routine
    given: list[tuple[Slot, Value]]
    results: list[tuple[Slot, Read]]
    asked: Value | None = None
    fresh: bool = False


Statement = Set | For | Invoke


@dataclass
class Routine:
    """A function of a law, without a language.

    Attributes
    ----------
    arguments, results, kept : its variables that a call gives, takes, and lets it change
    used : which of the traced function's arguments it uses
    over : by the place of a result that of the traced function's argument which it may overwrite
    """

    name: str
    about: str
    body: list[Statement]
    arguments: list[Slot] = field(default_factory=list)
    results: list[Slot] = field(default_factory=list)
    kept: list[Slot] = field(default_factory=list)
    locals: list[Slot] = field(default_factory=list)
    used: list[bool] = field(default_factory=list)
    over: dict[int, int] = field(default_factory=dict)

    def slots(self) -> list[Slot]:
        """Every variable that it reads or writes, those of functions that it calls left aside."""
        found: dict[int, Slot] = {}
        for statement in flat(self.body):
            for slot in touched(statement):
                found.setdefault(id(slot), slot)
        return list(found.values())

    @property
    def fresh(self) -> bool:
        """Whether it needs a record of states for what a call makes."""
        return any(isinstance(s, Invoke) and s.fresh for s in flat(self.body))

    def calls(self) -> list[Routine]:
        """Functions that it calls, each once."""
        found = {id(s.function): s.function for s in flat(self.body) if isinstance(s, Invoke)}
        return list(found.values())

    def records(self) -> list[str]:
        """Records that it, or a function that it calls, reads or writes: `state`, `input`, ..."""
        named = {slot.record for slot in self.slots()}
        for each in (s for s in flat(self.body) if isinstance(s, Invoke)):
            named.update(set(each.function.records()) - ({"next"} if each.fresh else set()))
        return [name for name in ("state", "next", "input", "output", "recall", "clock") if name in named]


def flat(body: list[Statement]) -> Iterator[Statement]:
    """Assignments, calls and loops, those in loops too."""
    for statement in body:
        yield statement
        if isinstance(statement, For):
            yield from flat(statement.body)


def touched(statement: Statement) -> Iterator[Slot]:
    """Variables that a statement reads or writes itself."""
    for each in reads(statement):
        yield from _slots(each)


def reads(statement: Statement) -> Iterator[Read]:
    """Everything that a statement reads or writes itself."""
    if isinstance(statement, Set):
        yield statement.to
        yield from read_by(statement.value)
    elif isinstance(statement, Invoke):
        for _, value in statement.given:
            yield from read_by(value)
        yield from (read for _, read in statement.results)
        if statement.asked is not None:
            yield from read_by(statement.asked)


def read_by(value: Value) -> Iterator[Read]:
    """Everything that a value reads."""
    if isinstance(value, Read):
        yield value
    elif isinstance(value, Operation):
        for each in value.of:
            yield from read_by(each)


def _slots(read: Read) -> Iterator[Slot]:
    yield read.slot
    pending = [read.index] if read.index else []
    while pending:
        for table, inner in pending.pop().tables:
            yield table
            pending.append(inner)


def kinds_of(body: Iterable[Statement]) -> Iterable[str]:
    """Kinds of what statements compute; `no_number` where NaN is among it."""
    for statement in flat(list(body)):
        values: list[Value] = []
        if isinstance(statement, Set):
            values = [statement.value]
        elif isinstance(statement, Invoke):
            values = [value for _, value in statement.given]
            values += [statement.asked] if statement.asked is not None else []
        while values:
            value = values.pop()
            if isinstance(value, Operation):
                yield value.kind
                values.extend(value.of)
            elif isinstance(value, KnownNumber) and isnan(value.value):
                yield "no_number"
