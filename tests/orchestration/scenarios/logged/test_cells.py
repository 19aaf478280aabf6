"""Cells of a column as numbers: what stands for no reading, what is refused, and what an input holds."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.orchestration.scenarios.logged.cells import (
    as_input,
    numbers,
    said_of_empty,
    signal,
    without_gaps,
)
from warmlink.orchestration.scenarios.logged.layout import headings
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet

SCALARS = {scalar.name: scalar for scalar in MOTOR.scalars()}


def sheet(cells: list[object], header: str = "T [degC]", decimal: str = "") -> Sheet:
    frame = pd.DataFrame({0: cells})
    frame.index = pd.Index(range(1, len(cells) + 1))
    return Sheet("log.csv", headings(([header], [None])), frame, decimal, bool(decimal), "text")


def place(variable: str, unit: str) -> Place:
    return Place(0, variable, unit, f"motor.{variable}", "header", chosen=False)


@pytest.mark.parametrize(
    ("cells", "values", "lost"),
    [
        (["20.5", " 21 ", "", "22"], [20.5, 21.0, np.nan, 22.0], []),
        (["20.5", "ERR", "21", "22"], [20.5, np.nan, 21.0, 22.0], [1]),
        ([20.5, 9.9e37, 21.0, np.inf], [20.5, np.nan, 21.0, np.nan], [1, 3]),
        ([20.5, 999.9, 21.0, -9999.0], [20.5, np.nan, 21.0, np.nan], [1, 3]),
        ([900.0, 999.9, 950.0, 980.0], [900.0, 999.9, 950.0, 980.0], []),
    ],
)
def test_what_stands_for_no_reading_is_none(
    cells: list[object], values: list[float], lost: list[int]
) -> None:
    found, rows = numbers(sheet(cells), 0)
    np.testing.assert_array_equal(found, values)
    assert rows.tolist() == lost


def test_a_number_among_words_is_itself_whatever_mark_the_text_has() -> None:
    cells = [1.234, "overload", 2.345, 3.5, np.float32(0.25), Decimal("1.125"), None, 7, "4,5"]
    found, rows = numbers(sheet(cells, decimal="comma"), 0)
    np.testing.assert_array_equal(found, [1.234, np.nan, 2.345, 3.5, 0.25, 1.125, np.nan, 7.0, 4.5])
    assert rows.tolist() == [1]


@pytest.mark.parametrize(
    ("unit", "si", "cells", "lost"),
    [
        ("rpm", "speed", [0.0, 999.0, 0.0], []),
        ("rpm", "speed", [0.0, 65535.0, 0.0], [1]),
        ("rpm", "speed", [0.0, 9999.0, 30.0], [1]),
        ("N.m", "torque", [0.0, 999.0, 0.0], []),
        ("N.m", "torque", [0.0, 999.0, 2.5], [1]),
        ("degC", "ambient_temperature", [0.0, 999.0, 0.0], [1]),
    ],
)
def test_beside_zeros_alone_an_ordinary_number_is_a_reading(
    unit: str, si: str, cells: list[object], lost: list[int]
) -> None:
    assert signal(sheet(cells), place(si, unit), SCALARS[si])[2].tolist() == lost


def test_decimal_commas_and_thousands() -> None:
    assert numbers(sheet(["1.234,5", "20,5"], decimal="comma"), 0)[0].tolist() == [1234.5, 20.5]
    with pytest.raises(InputError, match=r"row 2, column 'T \[degC\]': '1,234' may have a decimal mark"):
        numbers(sheet(["20.5", "1,234"]), 0)


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        (["20.5", "2O.5 1", "21", "22"], "row 2, column .*: '2O.5 1' is not a number"),
        (["20.5", "a", "b", "c"], "row 2, .*: 'a' and most cells below are no numbers"),
    ],
)
def test_what_looks_like_a_number_and_most_words_are_refused(cells: list[object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        numbers(sheet(cells), 0)


def test_an_empty_cell_of_an_input_holds_the_last_value_and_that_of_a_pad_is_off() -> None:
    values, none = np.array([1.0, np.nan, 2.0, np.nan]), np.array([], dtype=np.intp)
    assert without_gaps(sheet(["1", "", "2", ""]), place("speed", "rad/s"), values, none).tolist() == [
        1,
        1,
        2,
        2,
    ]
    assert without_gaps(sheet(["1", "", "2", ""]), place("pad_power", "W"), values, none).tolist() == [
        1,
        0,
        2,
        0,
    ]
    pad = without_gaps(sheet(["1", "", "2", ""]), place("pad_temperature", "K"), values, none)
    np.testing.assert_array_equal(pad, [1, np.nan, 2, np.nan])
    unread = without_gaps(
        sheet(["1", "?", "2", ""]), place("pad_power", "W"), values, np.array([1], dtype=np.intp)
    )
    assert unread.tolist() == [1, 1, 2, 0], "a cell that cannot be read does not switch the pad off"


def test_an_input_needs_a_first_value() -> None:
    with pytest.raises(InputError, match=r"row 1, column .*: an input needs a value in the first row"):
        without_gaps(
            sheet(["", "1"]), place("speed", "rad/s"), np.array([np.nan, 1.0]), np.array([], dtype=np.intp)
        )


@pytest.mark.parametrize(
    ("variable", "told"),
    [
        ("speed", "taken for the value before; where it was off, write 0"),
        ("ambient_temperature", "taken for the value before"),
        ("pad_power", "taken for off"),
    ],
)
def test_it_is_said_what_empty_cells_are_taken_for(variable: str, told: str) -> None:
    (sentence,) = said_of_empty(sheet(["1", "", "2", ""]), place(variable, "1"))
    assert sentence == f"log.csv: 2 of 4 cells of {variable} are empty and {told}"
    assert said_of_empty(sheet(["1", ""]), place("pad_temperature", "K")) == []


def test_a_discrete_input_takes_its_values_alone() -> None:
    column, values, told = as_input(
        sheet(["0", "2", ""], "pad_mode"), place("pad_mode", "1"), SCALARS["pad_mode"]
    )
    assert (column.filled, column.cells, values.tolist()) == (2, 3, [0.0, 2.0, 2.0])
    assert len(told) == 1
    with pytest.raises(InputError, match=r"row 2, column 'pad_mode': pad_mode: 1\.5 is not a whole"):
        as_input(sheet(["0", "1.5", "2"], "pad_mode"), place("pad_mode", "1"), SCALARS["pad_mode"])
