"""Arrays of which each turn of a loop needs its own element alone become numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from warmlink.controllers.export.program.statements import (
    For,
    Invoke,
    Operation,
    Read,
    Set,
    Slot,
    Statement,
    Value,
    flat,
    read_by,
    reads,
)


def contracted(body: list[Statement], slots: Iterable[Slot]) -> list[Statement]:
    """The statements with numbers in place of arrays that only one turn of a loop writes and reads."""
    everywhere = _counts(body)
    found = {id(slot) for slot in slots if slot.shape and _within(body, slot, everywhere, ())}
    for slot in slots:
        if id(slot) in found:
            slot.shape = ()
    return [_rewritten(each, found) for each in body] if found else body


def of_loops(body: list[Statement], slots: Iterable[Slot]) -> dict[int, list[Slot]]:
    """Numbers that only one loop needs, anew at each turn: by the identity of the innermost such loop."""
    everywhere, found = _counts(body), dict[int, list[Slot]]()
    for slot in slots:
        loop = None if slot.array else _innermost(body, slot, everywhere)
        if loop is not None and _writes_first(loop.body, slot):
            found.setdefault(id(loop), []).append(slot)
    return found


def _innermost(body: list[Statement], slot: Slot, everywhere: dict[int, int]) -> For | None:
    for each in body:
        if isinstance(each, For):
            inside = sum(read.slot is slot for inner in flat([each]) for read in reads(inner))
            if inside and inside == everywhere[id(slot)]:
                return _innermost(each.body, slot, everywhere) or each
    return None


def _counts(body: list[Statement]) -> dict[int, int]:
    """How often each variable is read or written."""
    counts: dict[int, int] = {}
    for each in flat(body):
        for read in reads(each):
            counts[id(read.slot)] = counts.get(id(read.slot), 0) + 1
    return counts


def _within(body: list[Statement], slot: Slot, everywhere: dict[int, int], loops: tuple[str, ...]) -> bool:
    """Whether one loop has all that touches a variable, at its own turn, and writes it first."""
    for each in body:
        if not isinstance(each, For):
            continue
        touched = [read for inner in flat([each]) for read in reads(inner) if read.slot is slot]
        if not touched:
            continue
        if len(touched) != everywhere[id(slot)]:
            return False
        inside = (*loops, each.variable)
        index = touched[0].index
        ours = (
            index is not None
            and not index.tables
            and all(read.index == index for read in touched)
            and {name for name, _ in index.terms} == set(inside)
        )
        return _writes_first(each.body, slot) if ours else _within(each.body, slot, everywhere, inside)
    return False


def _writes_first(body: list[Statement], slot: Slot) -> bool:
    for each in body:
        if isinstance(each, For) and any(r.slot is slot for inner in flat([each]) for r in reads(inner)):
            return False
        if isinstance(each, Invoke) and any(read.slot is slot for read in reads(each)):
            return False
        if isinstance(each, Set):
            if any(read.slot is slot for read in read_by(each.value)):
                return False
            if each.to.slot is slot:
                return True
    return False


def _rewritten(statement: Statement, found: set[int]) -> Statement:
    if isinstance(statement, For):
        return For(statement.variable, statement.count, [_rewritten(each, found) for each in statement.body])
    if isinstance(statement, Set):
        return Set(_number(statement.to, found), _value(statement.value, found))
    given = [(slot, _value(value, found)) for slot, value in statement.given]
    asked = None if statement.asked is None else _value(statement.asked, found)
    return replace(statement, given=given, asked=asked)


def _number(read: Read, found: set[int]) -> Read:
    return Read(read.slot) if id(read.slot) in found else read


def _value(value: Value, found: set[int]) -> Value:
    if isinstance(value, Read):
        return _number(value, found)
    if isinstance(value, Operation):
        return Operation(value.kind, tuple(_value(each, found) for each in value.of))
    return value
