"""Written times without any file: seconds from the first, or the row that is none and why."""

from __future__ import annotations

import pandas as pd
import pytest

from warmlink.orchestration.scenarios.logged.dates import NoTimeError, written_seconds


@pytest.mark.parametrize(
    ("texts", "form", "seconds", "taken"),
    [
        (["2026-11-22T08:59:31", "2026-11-22T09:00:01.5"], None, [0, 30.5], "date"),
        (["22.11.2026 23:59:50", "23.11.2026 00:00:10"], None, [0, 20], "date d.m.Y H:M:S"),
        (["13/11/26 10:00", "13/11/26 10:01"], None, [0, 60], "date d-m-y H:M"),
        (["11/12/26 1:00:00 PM", "11/12/26 1:00:30 PM"], "%m/%d/%y %I:%M:%S %p", [0, 30], "date"),
        (["23:59:58", "00:00:03"], None, [86398, 86403], "HH:MM:SS"),
        (["59:59.5", "0:00.5"], None, [3599.5, 3600.5], "M:SS.S"),
        (["59:59.5", "1:00:00.5"], None, [3599.5, 3600.5], "M:SS.S"),
    ],
)
def test_seconds_and_form(texts: list[str], form: str | None, seconds: list[float], taken: str) -> None:
    found, told = written_seconds(pd.Series(texts), form, "when")
    assert found.tolist() == seconds
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
