"""A long function in parts: the same statements in their order, and what several parts need in a record."""

from __future__ import annotations

from warmlink.controllers.export.parts import LEAST, SCREEN, divided
from warmlink.controllers.export.program.statements import (
    KnownNumber,
    Operation,
    Read,
    Routine,
    Set,
    Slot,
    Statement,
)


def lines(statement: Statement) -> int:
    return 1


def chain(count: int, every: int) -> tuple[Routine, list[Slot]]:
    """A function each of whose numbers follows from the one before, but anew after so many of them."""
    given, result = Slot("given", record="argument"), Slot("result", record="result")
    slots = [Slot(f"number_{k}") for k in range(count)]
    body: list[Statement] = []
    for k, slot in enumerate(slots):
        before = given if k % every == 0 else slots[k - 1]
        body.append(Set(Read(slot), Operation("add", (Read(before), KnownNumber(1.0)))))
    body.append(Set(Read(result), Read(slots[-1])))
    return Routine("long", "", body, [given], [result], [], slots), slots


def test_what_fits_on_a_screen_stays_whole() -> None:
    assert divided(chain(SCREEN - 1, SCREEN)[0], lines) is None
    assert divided(chain(SCREEN, SCREEN)[0], lines) is not None


def test_the_parts_are_all_statements_in_their_order_and_of_a_size() -> None:
    routine, _ = chain(200, 7)
    found = divided(routine, lines)
    assert found is not None
    assert [each for part in found.parts for each in part.body] == routine.body
    sizes = [len(part.body) for part in found.parts]
    assert max(sizes) <= SCREEN
    assert min(sizes[:-1]) >= LEAST
    assert [part.name for part in found.parts] == [f"long_part_{k}" for k in range(1, len(sizes) + 1)]


def test_it_is_cut_where_nothing_goes_on_and_then_nothing_is_shared() -> None:
    found = divided(chain(120, 20)[0], lines)
    assert found is not None
    assert found.shared == []
    assert all(len(part.body) % 20 in (0, 1) for part in found.parts)


def test_a_variable_is_shared_or_of_one_part_and_arguments_go_where_they_are_read() -> None:
    routine, slots = chain(120, 1000)
    found = divided(routine, lines)
    assert found is not None
    own = [slot for part in found.parts for slot in part.locals]
    assert len(found.shared) == len(found.parts) - 1  # the number that each part hands on
    assert {*map(id, own), *map(id, found.shared)} == {*map(id, slots)}
    assert not {*map(id, own)} & {*map(id, found.shared)}
    assert [bool(part.arguments) for part in found.parts] == [True] + [False] * (len(found.parts) - 1)
    assert [bool(part.results) for part in found.parts] == [False] * (len(found.parts) - 1) + [True]
