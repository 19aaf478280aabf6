"""Written times without any file: seconds from the first, or the row that is none and why."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest

from warmlink.orchestration.scenarios.logged.dates import NoTimeError, seconds, written_seconds


@pytest.mark.parametrize(
    ("texts", "form", "values", "taken"),
    [
        (["2026-11-22T08:59:31", "2026-11-22T09:00:01.5"], None, [0, 30.5], "date"),
        (["22.11.2026 23:59:50", "23.11.2026 00:00:10"], None, [0, 20], "date d.m.Y H:M:S"),
        (["13/11/26 10:00", "13/11/26 10:01"], None, [0, 60], "date d-m-y H:M"),
        (["11/12/26 1:00:00 PM", "11/12/26 1:00:30 PM"], "%m/%d/%y %I:%M:%S %p", [0, 30], "date"),
        (["23:59:58", "00:00:03"], None, [86398, 86403], "HH:MM:SS"),
        (["59:59.5", "0:00.5"], None, [3599.5, 3600.5], "M:SS.S"),
        (["59:59.5", "1:00:00.5"], None, [3599.5, 3600.5], "M:SS.S"),
        (["11/22/2026 10:00:00 p.m.", "11/22/2026 10:00:30 p.m."], None, [0, 30], "date m-d-Y I:M:S p"),
        (["11/22/2026 11:59:30PM", "11/23/2026 12:00:00AM"], None, [0, 30], "date m-d-Y I:M:S p"),
        (["11/22/2026 1:00PM", "11/22/2026 1:02PM"], "%m/%d/%Y %I:%M%p", [0, 120], "date m/d/Y I:M p"),
        (["2026.11.22 01:00:00 PM", "2026.11.22 01:00:30 PM"], None, [0, 30], "date Y-m-d I:M:S p"),
        (["Nov 22, 2026 10:00:00", "Nov 22, 2026 10:00:30,5"], None, [0, 30.5], "date b-d-Y H:M:S"),
        (["22.11.2026 10:00:00", "22.11.2026 10:00:01,5"], "%d.%m.%Y %H:%M:%S", [0, 1.5], "date d.m.Y H:M:S"),
        (["23:58", "23:59", "00:00"], "%H:%M", [86280, 86340, 86400], "H:M"),
        (["58:30", "59:30", "00:30"], "%M:%S", [3510, 3570, 3630], "M:S"),
        (["2026-11-01T01:59:50Z", "2026-11-01T03:00:00+01:00"], None, [0, 10], "date"),
        (["58.5", "59.5", "0.5"], "%S", [58.5, 59.5, 60.5], "S"),
        (["11:59 PM", "12:01 AM"], "%I:%M %p", [86340, 86460], "I:M p"),
    ],
)
def test_seconds_and_form(texts: list[str], form: str | None, values: list[float], taken: str) -> None:
    found, told = written_seconds(pd.Series(texts), form, "when")
    assert found.tolist() == values
    assert told.startswith(taken)


@pytest.mark.parametrize(
    ("texts", "row", "sentence"),
    [
        (["2026-11-22 08:00:00", ""], 1, "the time is missing"),
        (["soon", "later"], 0, "'soon' is no date with a time that can be read"),
        (["2026-11-22 08:00:00", "2026-11-22 8 o'clock"], 1, "{} is not of the form of the rows before"),
        (["08:00:00", "08:01"], 1, "{} is not of the form HH:MM:SS"),
        (["0:01.5", "90"], 1, "{} is not of the form M:SS.S of other rows"),
        (["01/02/2026 10:00", "02/02/2026 10:00"], 0, "may begin with the day or the month"),
        (
            ["22.11.2026 10:00 or so", "22.11.2026 10:01"],
            0,
            "'22.11.2026 10:00 or so' is no date with a time",
        ),
        (["30.01.2026 10:00", "31.02.2026 10:00"], 1, "{} is a date or a time that does not exist"),
        (["2026-02-31 10:00:00", "2026-03-01 10:00:00"], 0, "{} is a date or a time that does not exist"),
        (["2026-02-28T10:00:00Z", "2026-02-31T10:00:00Z"], 1, "{} is a date or a time that does not exist"),
        (["10:00:00", "10:75:00"], 1, "HH:MM:SS with minutes and seconds below 60"),
        (["10:00:75", "10:01:00"], 0, "HH:MM:SS with minutes and seconds below 60"),
        (["0:01.5", "0:75.0"], 1, "seconds below 60"),
        (["08:00:00", "999999999:00:00"], 1, "{} is not of the form HH:MM:SS"),
        (["2026-11-01T01:59:50", "2026-11-01T01:00:00-05:00"], 0, "{} has no offset from UTC, as other rows"),
        (["2026-11-01T01:59:50Z", "2026-11-01 02:00"], 1, "{} has no offset from UTC, as other rows"),
        (["2026-10-25 08:00:00", "2026-10-26"], 1, "{} lacks the time of the day, or its minutes"),
        (["2026-10-25 08:00:00", "2026-10-25 09"], 1, "{} lacks the time of the day, or its minutes"),
    ],
)
def test_the_first_that_is_none_is_told_by_its_row(texts: list[str], row: int, sentence: str) -> None:
    with pytest.raises(NoTimeError) as wrong:
        written_seconds(pd.Series(texts), None, "when")
    assert wrong.value.row == row
    assert sentence in wrong.value.sentence


def test_advice_names_the_column() -> None:
    with pytest.raises(NoTimeError) as wrong:
        written_seconds(pd.Series(["08:01", "08:02"]), None, "when")
    assert "when" in wrong.value.sentence


@pytest.mark.parametrize(
    ("texts", "form", "row", "sentence"),
    [
        (["22.11.2026 10:00", "soon"], "%d.%m.%Y %H:%M", 1, "is not of the form that"),
        (["22/11/2026 10:00"], "%m/%d/%Y %H:%M", 0, "does not exist by the form that"),
        (["22/11/2026 10:00"], "%Q", 0, "is no form of dates"),
        (["22/11/2026 10:00"], "%d/%d", 0, "is no form of dates"),
        (["22/11/2026 10:00"], "%", 0, "is no form of dates"),
    ],
)
def test_a_form_that_does_not_fit_is_named(texts: list[str], form: str, row: int, sentence: str) -> None:
    with pytest.raises(NoTimeError) as wrong:
        written_seconds(pd.Series(texts), form, "when")
    assert wrong.value.row == row
    assert sentence in wrong.value.sentence
    assert form in wrong.value.sentence


@pytest.mark.parametrize(
    "texts", [["03-04-2026 10:00:00", "04-04-2026 10:00:00"], ["3/4/26 1:00PM", "4/4/26 1:00PM"]]
)
def test_advice_on_swapped_days_can_be_followed(texts: list[str]) -> None:
    text = pd.Series(texts)
    with pytest.raises(NoTimeError, match=f"'{texts[0]}' may begin") as wrong:
        written_seconds(text, None, "when")
    found = re.search(r"%d.*%[Sp]|%d.*%M(?= %p)", wrong.value.sentence)
    assert found is not None
    assert written_seconds(text, found[0], "when")[0].tolist() == [0, 86400]


def test_a_column_of_dates_without_any_date() -> None:
    assert np.isnan(seconds(pd.Series([pd.NaT, pd.NaT]))).all()


def test_dates_centuries_apart() -> None:
    dates = pd.Series(pd.to_datetime(["1700-01-01", "2200-01-01"]).as_unit("ns"))
    assert seconds(dates).tolist() == [0.0, 182621 * 86400.0]
