"""Headers, separators and decimal marks of what loggers write, each rule by itself."""

from __future__ import annotations

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.logged.layout import (
    decimal_of,
    headers_of,
    is_value,
    name_and_unit,
    plain,
    refuse_open_quotes,
    separator_of,
    split,
    with_suffix,
)


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("T1 [degC]", "T1", "degC"),
        ("T1 (degC)", "T1", "degC"),
        ("speed in rad/s", "speed", "rad/s"),
        ("speed / rpm", "speed", "rpm"),
        ("valve (open)", "valve (open)", None),
        ("base", "base", None),
    ],
)
def test_a_header_is_a_name_and_a_unit(header: str, name: str, unit: str | None) -> None:
    assert name_and_unit(header) == (name, unit)


def test_names_are_compared_without_spaces_and_capitals() -> None:
    assert plain(" Shaft Temperature ") == plain("shaft_temperature") == "shaft_temperature"


def test_a_unit_may_end_a_name_in_several_ways() -> None:
    assert list(with_suffix("speed_rad_s")) == [("speed", "rad_s"), ("speed_rad", "s")]
    assert list(with_suffix("plain")) == []


@pytest.mark.parametrize(
    ("lines", "separator"),
    [
        (["time;T", "0;21,5", "10;21,6"], ";"),
        (["time,T", "0,21.5", "10,21.6"], ","),
        (["time\tT", "0\t21.5"], "\t"),
        (["time T", "0 21.5", "10 21.6"], " "),
    ],
)
def test_the_separator_is_that_which_leaves_single_values(lines: list[str], separator: str) -> None:
    assert separator_of("a.csv", lines) == (separator, 2)


def test_what_has_no_columns_is_refused() -> None:
    with pytest.raises(InputError, match="no rows below its only line"):
        separator_of("a.csv", ["hello"])
    with pytest.raises(InputError, match="no columns are found"):
        separator_of("a.csv", ["hello", "world"])


def test_a_unit_in_brackets_stays_with_its_name() -> None:
    assert split("time [s]  T [degC]", " ") == ["time [s]", "T [degC]"]
    assert split('"a,b", c', ",") == ["a,b", "c"]


@pytest.mark.parametrize(
    ("cell", "value"), [("-1.5e3", True), ("08:59", True), ("12 ms", True), ("off", False)]
)
def test_numbers_times_and_counts_are_values(cell: str, value: bool) -> None:
    assert is_value(cell) == value


@pytest.mark.parametrize(
    ("cells", "mark"),
    [
        (["21,5", "21,6", "1"], "comma"),
        (["1.234,5"], "comma"),
        (["1,234.5"], "point"),
        (["1,234", "5,678"], ""),
        (["1.234", "5.678"], "point"),
        (["1", "2"], ""),
    ],
)
def test_the_decimal_mark_is_what_some_cells_say_without_doubt(cells: list[str], mark: str) -> None:
    assert decimal_of(cells) == mark


def test_units_may_have_a_row_of_their_own_and_notes_stand_above() -> None:
    rows = {0: ["Logger 7"], 1: ["time", "T"], 2: ["s", "[degC]"], 3: ["0", "21.5"], 4: ["10", "21.6"]}
    assert headers_of("a.csv", rows, 2, []) == ((["time", "T"], ["s", "degC"]), 3)
    with pytest.raises(InputError, match="there is no header row"):
        headers_of("a.csv", {0: ["0", "1"], 1: ["10", "2"]}, 2, [])


def test_a_quote_that_is_never_closed_is_told_with_its_row() -> None:
    with pytest.raises(InputError, match=r"row 2: a quote .* takes in the 2 lines below"):
        refuse_open_quotes("a.csv", 'time,T\n0,"21.5\n10,21.6\n20,21.7', ",")
    refuse_open_quotes("a.csv", 'time,note\n0,"a note\nof two lines"\n10,x', ",")
