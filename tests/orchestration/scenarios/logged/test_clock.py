"""Times of a sheet in seconds from its first row."""

from __future__ import annotations

import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.logged.clock import times
from warmlink.orchestration.scenarios.logged.layout import headings
from warmlink.orchestration.scenarios.logged.sheet import Place, Sheet


def read(
    cells: list[object], unit: str | None = None, dates: list[str] | None = None
) -> tuple[list[float], str]:
    frame = pd.DataFrame({0: cells} | ({1: dates} if dates else {}))
    frame.index = pd.Index(range(2, len(cells) + 2))
    names = ["time", "date"][: frame.shape[1]]
    sheet = Sheet("log.csv", headings((names, [None] * len(names))), frame, "point", False, "text")
    date = Place(1, "date", None, "date", "header", chosen=False) if dates else None
    values, taken = times(sheet, Place(0, "time", unit, "time", "header", chosen=False), date)
    return values.tolist(), taken


def test_numbers_count_in_the_unit_of_the_header_or_of_the_cells() -> None:
    assert read([5.0, 6.5], "min") == ([0.0, 90.0], "min")
    assert read(["5 ms", "25 ms"]) == ([0.0, 0.02], "ms")


def test_a_time_that_elsewhere_stands_for_no_reading_is_a_time() -> None:
    assert read([0, 300, 999], "s")[0] == [0, 300, 999]


def test_counts_since_1970_need_no_unit() -> None:
    assert read([1_795_000_000.0, 1_795_000_060.0]) == ([0.0, 60.0], "s since 1970")
    assert read([1_795_000_000_000.0, 1_795_000_000_500.0]) == ([0.0, 0.5], "ms since 1970")
    count = 1_795_000_000_000_000_000
    assert read([count, count + 3_000_000_000]) == ([0.0, 3.0], "ns since 1970")
    with pytest.raises(InputError, match=r"log\.csv: column 'time' has no unit; head it as 'time \[s\]'"):
        read([0.0, 60.0])


@pytest.mark.parametrize(
    ("cells", "form", "seconds"),
    [
        ([50, 55, 57], "%S", [0, 5, 7]),
        ([50.5, 55.0, 57.25], "%S", [0, 4.5, 6.75]),
        (["50", "55", "57"], "%S", [0, 5, 7]),
        ([20261101015950, 20261101020000], "%Y%m%d%H%M%S", [0, 10]),
        ([59, 130, 10000], "%H%M%S", [0, 31, 3541]),
    ],
)
def test_numbers_may_have_a_form_of_dates(cells: list[object], form: str, seconds: list[float]) -> None:
    assert read(cells, form)[0] == seconds


def test_a_date_stands_beside_the_time_of_the_day() -> None:
    assert read(["23:59:50", "00:00:10"], dates=["2026-11-22", "2026-11-23"])[0] == [0.0, 20.0]


@pytest.mark.parametrize(
    ("cells", "unit", "sentence"),
    [
        ([0.0, 2.0, 1.0], "s", "row 4, column 'time': 1 s comes after 2 s; times must increase"),
        ([0.0, None, 2.0], "s", "row 3, column 'time': the time is missing"),
        (["1 s", "2 s"], "min", "its header says min, its cells s"),
        (["0.5", "x", "1.5"], "s", "row 3, column 'time': 'x' is no time"),
        (["2026-11-22 08:00:00", "soon"], None, "row 3, column 'time': 'soon' is not of the form"),
        (
            ["2026-10-25 02:59:00", "2026-10-25 02:01:00"],
            None,
            "the clock goes back by an hour, as at the end of summer time",
        ),
    ],
)
def test_what_is_no_later_time_is_refused(cells: list[object], unit: str | None, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read(cells, unit)


def test_a_wrong_date_beside_the_time_is_quoted() -> None:
    with pytest.raises(InputError, match=r"row 3, .*'2026-11-31 00:00:10' is a date or a time that does not"):
        read(["23:59:50", "00:00:10"], dates=["2026-11-30", "2026-11-31"])


def test_a_column_without_any_time_is_refused() -> None:
    with pytest.raises(InputError, match="row 2, column 'time': the time is missing"):
        read([pd.NaT, pd.NaT])


def test_a_sheet_without_rows_is_refused() -> None:
    with pytest.raises(InputError, match="there are no rows under the header"):
        read([])
