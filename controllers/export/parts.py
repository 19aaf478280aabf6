"""A long function in parts that fit on a screen; what several of them need stands in a record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from warmlink.controllers.export.program.statements import (
    Invoke,
    Routine,
    Slot,
    Statement,
    flat,
    touched,
)

SCREEN = 45
"""Lines of statements in a part at most, where statements do not themselves take more."""

LEAST = 15
"""Lines that a part has at least, but for the last one."""


@dataclass(frozen=True)
class Divided:
    """A function's parts, in their order, and the variables that several of them need."""

    parts: list[Routine]
    shared: list[Slot]


def divided(routine: Routine, lines: Callable[[Statement], int]) -> Divided | None:
    """The parts of a function; None where it fits on a screen, or one record is written all over it."""
    if routine.fresh or sum(map(lines, routine.body)) <= SCREEN:
        return None
    pieces = _pieces(routine, lines)
    if len(pieces) < 2:
        return None
    own = {id(slot) for slot in routine.locals}
    used = [{id(slot) for slot in _slots(piece)} for piece in pieces]
    shared = [slot for slot in routine.locals if sum(id(slot) in each for each in used) > 1]
    parts = []
    for k, (piece, names) in enumerate(zip(pieces, used, strict=True), 1):
        alone = [s for s in routine.locals if id(s) in names and s not in shared and id(s) in own]
        arguments, results, kept = (
            [slot for slot in slots if id(slot) in names]
            for slots in (routine.arguments, routine.results, routine.kept)
        )
        about = f"{_computed(piece, shared)}: part {k} of {len(pieces)} of {routine.name}."
        parts.append(Routine(f"{routine.name}_part_{k}", about, piece, arguments, results, kept, alone))
    return Divided(parts, shared)


def _pieces(routine: Routine, lines: Callable[[Statement], int]) -> list[list[Statement]]:
    """Statements in pieces, divided where the fewest variables are needed on both sides."""
    body, pieces = routine.body, []
    long = [lines(each) for each in body]
    own = {id(slot) for slot in routine.locals}
    used = [{id(slot) for slot in _slots([each])} & own for each in body]
    first = {slot: k for k in range(len(body) - 1, -1, -1) for slot in used[k]}
    last = {slot: k for k in range(len(body)) for slot in used[k]}
    across = [sum(first[slot] < k <= last[slot] for slot in first) for k in range(len(body) + 1)]
    start = 0
    while sum(long[start:]) > SCREEN:
        ends = [k for k in range(start + 1, len(body)) if LEAST <= sum(long[start:k]) <= SCREEN]
        # A statement that takes a screen by itself is a piece with those few before it.
        ends = ends or [next(k for k in range(start + 1, len(body) + 1) if sum(long[start:k]) >= LEAST)]
        end = min(reversed(ends), key=across.__getitem__)
        pieces.append(body[start:end])
        start = end
    return [*pieces, body[start:]] if start < len(body) else pieces


def _slots(body: list[Statement]) -> list[Slot]:
    return [slot for statement in flat(body) for slot in touched(statement)]


def _computed(body: list[Statement], shared: list[Slot]) -> str:
    """What a part computes that goes on, by name."""
    ids = {id(slot) for slot in shared}
    names: dict[str, None] = {}
    for statement in flat(body):
        if isinstance(statement, Invoke):
            written = [read.slot for _, read in statement.results]
        else:
            written = [statement.to.slot] if hasattr(statement, "to") else []
        for slot in written:
            if id(slot) in ids or slot.record in ("next", "output", "result", "kept"):
                names.setdefault(slot.name)
    told = [name for name in names if not name.startswith(("value", "unused"))] or [*names]
    return ", ".join(told) or "Nothing"
