"""Statements put in order: neighbouring loops of as many turns become one where no number changes."""

from __future__ import annotations

from collections.abc import Iterable

from warmlink.controllers.export.program.statements import (
    For,
    Index,
    Invoke,
    KnownNumber,
    Read,
    Set,
    Statement,
    flat,
    read_by,
)


def tidied(body: list[Statement]) -> list[Statement]:
    """The statements with neighbouring loops joined."""
    done: list[Statement] = []
    for each in body:
        this = For(each.variable, each.count, tidied(each.body)) if isinstance(each, For) else each
        before = _loop_before(done, this)
        if before is None:
            done.append(this)
            continue
        assert isinstance(this, For)
        earlier = done[before]
        assert isinstance(earlier, For)
        between = done[before + 1 :]
        joined = For(this.variable, this.count, tidied([*earlier.body, *this.body]))
        done[before:] = [*between, joined]
    return done


def _loop_before(done: list[Statement], this: Statement) -> int | None:
    """Place of the loop that a loop can be joined with, past assignments of known numbers."""
    if not isinstance(this, For):
        return None
    for k in range(len(done) - 1, -1, -1):
        other = done[k]
        if isinstance(other, For):
            free = all(_apart([other], each) for each in done[k + 1 :])
            alike = other.variable == this.variable and other.count == this.count
            return k if alike and free and _joinable(other, this) else None
        if not (isinstance(other, Set) and isinstance(other.value, KnownNumber)):
            return None
    return None


def _apart(body: Iterable[Statement], one: Statement) -> bool:
    """Whether statements do not touch what one assigns."""
    assert isinstance(one, Set)
    return all(read.slot is not one.to.slot for read, _ in _touched(body))


def _joinable(first: For, second: For) -> bool:
    """Whether two loops do the same as one: what either writes, the other touches at the same place alone."""
    if any(isinstance(each, Invoke) for each in flat([first, second])):
        return False
    touched = [*_touched([first])], [*_touched([second])]
    for mine, others in (touched, touched[::-1]):
        for place, written in mine:
            if not written:
                continue
            for read, _ in others:
                if read.slot is place.slot and not _same_turn(place.index, read.index, first.variable):
                    return False
    return True


def _same_turn(a: Index | None, b: Index | None, variable: str) -> bool:
    return a is not None and a == b and any(name == variable for name, _ in a.terms)


def _touched(body: Iterable[Statement]) -> list[tuple[Read, bool]]:
    """Everything that statements read, and write (true)."""
    found = []
    for each in flat(list(body)):
        if isinstance(each, Set):
            found.append((each.to, True))
            found += [(read, False) for read in read_by(each.value)]
    return found
