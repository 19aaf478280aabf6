"""Whether a function may write a result over an argument of the same size."""

from __future__ import annotations

from warmlink.controllers.export.program.statements import (
    For,
    Index,
    Invoke,
    Read,
    Set,
    Slot,
    Statement,
    flat,
    read_by,
    reads,
    touched,
)


def may_overwrite(body: list[Statement], result: Slot, argument: Slot) -> bool:
    """Whether no element of the argument is read once its place in the result has been written."""
    writing = [k for k, each in enumerate(body) if _written(each, result)]
    if len(writing) != 1 or any(_touches(each, argument) for each in body[writing[0] + 1 :]):
        return False
    return _element_by_element(body[writing[0]], result, argument)


def _written(statement: Statement, result: Slot) -> bool:
    for each in flat([statement]):
        if isinstance(each, Set) and each.to.slot is result:
            return True
        if isinstance(each, Invoke) and any(read.slot is result for _, read in each.results):
            return True
    return False


def _touches(statement: Statement, slot: Slot) -> bool:
    return any(each is slot for inner in flat([statement]) for each in touched(inner))


def _element_by_element(statement: Statement, result: Slot, argument: Slot) -> bool:
    """Whether a loop writes each element once, and reads the argument there alone, not afterwards."""
    loops, body = list[str](), [statement]
    while len(body) == 1 and isinstance(body[0], For):
        loops.append(body[0].variable)
        body = body[0].body
    writes = [k for k, each in enumerate(body) if _written(each, result)]
    if not loops or len(writes) != 1 or not isinstance(body[writes[0]], Set):
        return False
    to = body[writes[0]].to  # type: ignore[union-attr]
    if to.index is None or to.index.tables or sorted(name for name, _ in to.index.terms) != sorted(loops):
        return False
    for k, each in enumerate(body):
        for read in _read(each):
            if read.slot is argument and (read.index != to.index or k > writes[0]):
                return False
    return True


def stays(statement: Statement) -> bool:
    """Whether an assignment, or a loop of one, gives each element the value that it has."""
    inner = statement.body[0] if isinstance(statement, For) and len(statement.body) == 1 else statement
    return isinstance(inner, Set) and inner.to == inner.value


def may_follow(statement: Statement, slot: Slot, lost: set[int]) -> bool:
    """Whether a loop of one assignment reads of a variable none of the elements that are lost, nor loses any.

    An element may be read where it is written. Those that it writes are lost after it.
    """
    count, inner = (statement.count, statement.body[0]) if isinstance(statement, For) else (1, statement)
    assert isinstance(inner, Set)
    written = _places(inner.to.index, count)
    for read in read_by(inner.value):
        if read.slot is not slot:
            continue
        places = _places(read.index, count)
        elsewhere = {a for a, b in zip(places, written, strict=True) if a != b}
        if lost & {*places} or elsewhere & {*written}:
            return False
    lost.update(written)
    return True


def _places(index: Index | None, count: int) -> list[int]:
    """Which elements a loop of one variable goes through."""
    assert index is not None
    return [_place(index, turn) for turn in range(count)]


def _place(index: Index, turn: int) -> int:
    tables = sum(int(slot.values[_place(inner, turn)]) for slot, inner in index.tables)
    return index.constant + sum(pace * turn for _, pace in index.terms) + index.of_tables * tables


def _read(statement: Statement) -> list[Read]:
    found: list[Read] = []
    for each in flat([statement]):
        found += read_by(each.value) if isinstance(each, Set) else reads(each)
    return found
