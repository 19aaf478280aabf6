"""Tables of a file: what is read, what is refused, and in which words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.written.entries import (
    Bounds,
    Flag,
    Names,
    Number,
    OneOf,
    Quantity,
    Text,
    Value,
    Whole,
)
from warmlink.orchestration.written.tables import Table, json_schema, read_table


@dataclass(frozen=True)
class Piece(Table):
    """A piece."""

    time: Annotated[float, Quantity("s", positive=True)]
    speed: Annotated[float, Quantity("rad/s", least=0)] = 0.0

    def __post_init__(self) -> None:
        if self.speed > self.time:
            raise InputError("is too fast; give a speed below the time")


@dataclass(frozen=True)
class Mine(Table):
    """A file.

    Of which this is not for editors.
    """

    title: Annotated[str | None, Text()] = None
    sure: Annotated[bool, Flag()] = False
    count: Annotated[int, Whole(1, 9)] = 1
    share: Annotated[float, Number("share", above=0, at_most=1)] = 0.5
    range: Annotated[tuple[float, float], Bounds("m")] = (0.0, 1.0)
    kind: Annotated[str, OneOf(("grid", "random"))] = "grid"
    names: Annotated[tuple[str, ...], Names("lag")] = ("lag",)
    words: tuple[Annotated[str, Text("word")], ...] = ()
    piece: tuple[Piece, ...] = ()
    last: Piece | None = None
    set: Mapping[str, Annotated[str | float, Value()]] = field(default_factory=dict)


def test_quantities_are_read_in_si_units_and_the_rest_as_it_is() -> None:
    piece = {"time": "2 min", "speed": 3}
    read = read_table(Mine, {"piece": [piece], "range": ["1 mm", 2], "set": {"link.length": "1 m"}}, "mine")
    assert read == Mine(piece=(Piece(120.0, 3.0),), range=(0.001, 2.0), set={"link.length": "1 m"})


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            3,
            "mine: 3 is not a table; write a table with any of count, kind, last, names, piece, range, "
            "set, share, sure, title",
        ),
        ({"titel": "x"}, "mine: titel is not known; did you mean title?"),
        ({"title": 3}, 'mine: title: 3 is no text; write "..."'),
        ({"sure": 1}, "mine: sure: 1 is neither true nor false; write true or false"),
        ({"count": True}, "mine: count: true is not a whole number from 1 to 9; give one"),
        ({"share": 0}, "mine: share: 0 is no share; give a number above 0, at most 1"),
        ({"range": [1]}, "mine: range: a list is no pair of bounds; give [lowest, highest]"),
        ({"range": [2, 1]}, "mine: range: from 2 to 1 m is no range; give bounds of at least 0 m"),
        ({"kind": "gird"}, "mine: kind: 'gird' is not known; did you mean grid?"),
        ({"names": []}, 'mine: names: is no list of names; write ["lag"]'),
        ({"names": ["a", "a"]}, "mine: names: names one twice; keep one"),
        ({"words": 3}, 'mine: words: 3 is not a list; write words = ["word"]'),
        ({"words": ["a", 3]}, 'mine: words 2: 3 is no text; write "word"'),
        ({"piece": 3}, "mine: piece: 3 is not a list of tables; write [[piece]] above each of them"),
        ({"piece": [{"time": 1}, 3]}, "mine: piece 2: 3 is not a table; write a table with time"),
        ({"piece": [{}]}, 'mine: piece 1: time is missing; write time = "20 min"'),
        ({"piece": [{"tmie": 3}]}, "mine: piece 1: tmie is not known; did you mean time?"),
        ({"piece": [{"time": "0 s"}]}, "mine: piece 1.time: 0 s is not positive; give a value above 0 s"),
        ({"piece": [{"time": "3 kg"}]}, "mine: piece 1.time: kg does not convert to s"),
        ({"piece": [{"time": 1, "speed": 2}]}, "mine: piece 1: is too fast; give a speed below the time"),
        ({"last": {"time": 1, "spede": 2}}, "mine: last: spede is not known; did you mean speed?"),
        ({"set": 3}, "mine: set: 3 is not a table; write [set] above its entries"),
        ({"set": {"a.b": True}}, 'mine: set."a.b": true is not a value'),
        ({"set": {"link": {"width": 1}}}, 'mine: set.link: put the whole name in quotes, as "link.width"'),
    ],
)
def test_a_mistake_ends_in_one_sentence_that_names_the_place(given: Any, sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        read_table(Mine, given, "mine")
    assert str(refusal.value).startswith(sentence)
    assert "\n" not in str(refusal.value)


def test_all_mistakes_come_in_one_answer() -> None:
    given = {"titel": "x", "sure": 1, "piece": [{"tmie": 3}, {"time": "3 kg"}], "last": {}}
    with pytest.raises(InputError) as refusal:
        read_table(Mine, given, "mine")
    places = [line.partition(";")[0] for line in str(refusal.value).split("\n")]
    assert places == [
        "mine: piece 1: tmie is not known",
        "mine: titel is not known",
        "mine: sure: 1 is neither true nor false",
        "mine: piece 2.time: kg does not convert to s",
        "mine: last: time is missing",
    ]
    with pytest.raises(InputError) as refusal:
        read_table(Mine, {"piece": [{"time": 0}] * 13}, "mine")
    assert len(str(refusal.value).split("\n")) == 11
    assert str(refusal.value).endswith("\nand 3 more")


def test_the_schema_tells_the_units_and_knows_no_null() -> None:
    schema = json_schema(Mine)
    piece = schema["$defs"]["Piece"]["properties"]
    assert schema["description"] == "A file."
    assert piece["time"]["description"] == "above 0, with its unit, or a bare number in s"
    assert piece["speed"]["type"] == ["string", "number"]
    assert schema["properties"]["kind"]["enum"] == ["grid", "random"]
    assert schema["properties"]["last"] == {"$ref": "#/$defs/Piece"}
    assert "null" not in str(schema)
