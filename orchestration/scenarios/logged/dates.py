"""Written dates and times of the day as loggers write them, in seconds from the first; a clock over midnight.

Knows no file: what cannot be read is told by its row, and whoever asked says where that is.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.orchestration.arrays import Array

if TYPE_CHECKING:
    import pandas as pd

HOUR, DAY = 3600.0, 86400.0

_MINUTES = re.compile(r"\d+:\d\d\.\d+")
_CLOCK = re.compile(r"\d+:\d\d(:\d\d(\.\d+)?)?")
_STAMP = re.compile(
    r"(?P<date>[\w./-]*?\d[\w./-]*|\d+ \w+ \d+|\w+ \d+,? \d+)(?P<between>T|,? +)(?P<clock>\d+:.*)"
)
_DATES = (
    (r"\d{4}([-/.])\d+\1\d+", ("%Y-%m-%d",)),
    (r"\d+\.\d+\.\d{4}", ("%d.%m.%Y",)),
    (r"\d+\.\d+\.\d{2}", ("%d.%m.%y",)),
    (r"\d+([-/])\d+\1\d{4}", ("%d-%m-%Y", "%m-%d-%Y")),
    (r"\d+([-/])\d+\1\d{2}", ("%d-%m-%y", "%m-%d-%y", "%y-%m-%d")),
    (r"\d+([- ])[A-Za-z]{3}\1\d{4}", ("%d-%b-%Y",)),
)
"""Dates by their look, each with the orders of day, month and year that it may have."""


class NoTimeError(Exception):
    """The cell in a row, counted from 0, is no time; in the sentence `{}` stands for the cell."""

    def __init__(self, row: int, sentence: str) -> None:
        super().__init__(sentence)
        self.row, self.sentence = row, sentence


def _refuse(wrong: pd.Series, sentence: str) -> None:
    """Raise NoTimeError at the first of some rows, if there is any."""
    for row in np.flatnonzero(wrong)[:1].tolist():
        raise NoTimeError(row, sentence)


def seconds(cells: Any) -> Array:
    """Seconds from the first filled cell of dates or durations, NaN where there is none."""
    found = (cells - cells.dropna().iloc[0]) if cells.notna().any() else cells
    return np.asarray(found.dt.total_seconds(), dtype=np.float64)


def written_seconds(text: pd.Series, form: str | None, header: str) -> tuple[Array, str]:
    """Seconds from the first of some written dates or times of the day, and the form that they have.

    `form` is that of the dates if somebody says it, as `%d/%m/%Y %H:%M:%S`; advice names the column by its
    `header`. NoTimeError is raised at the first that cannot be read, or may mean two days.
    """
    _refuse(text == "", "the time is missing")
    if form is not None and "%" in form:
        return _by_forms(text, header, [form])
    text = text.str.replace(r"(:\d\d),(\d+)", r"\1.\2", regex=True)
    first = str(text.iloc[0])
    if text.str.fullmatch(_MINUTES).any():
        return _of_minutes(text)
    if _CLOCK.fullmatch(first):
        return _of_clock(text, header)
    stamp = _STAMP.fullmatch(first)
    look = stamp["date"] if stamp else first
    orders = next((orders for pattern, orders in _DATES if re.fullmatch(pattern, look)), None)
    if orders is None or stamp is None:
        raise NoTimeError(
            0,
            f"{first!r} is no date with a time that can be read; write it as 2026-11-22 08:59:31, or give "
            f"its form, as {_as_said(header, '%d/%m/%Y %H:%M:%S')}",
        )
    clock = stamp["clock"]
    if orders[0] == "%Y-%m-%d" and not re.search(r"[AaPp]\.?[Mm]", clock):
        text = text.str.replace(r"^(\d{4})[/.](\d+)[/.](\d+)", r"\1-\2-\3", regex=True)
        return _by_forms(text, header, ["ISO8601"])
    if "." not in look:
        text = text.str.replace(r"^(\w+)[-/ ](\w+)[-/ ]", r"\1-\2-", regex=True)
    seconds = ":%S" if clock.count(":") > 1 else ""
    hours = f"%I:%M{seconds} %p" if clock[-1] in "Mm" else f"%H:%M{seconds}"
    return _by_forms(text, header, [f"{order}{stamp['between']}{hours}" for order in orders])


def _as_said(header: str, form: str) -> str:
    """How a user says the form of the dates under a header."""
    return argument("units", {header: form})


def _by_forms(text: pd.Series, header: str, forms: list[str]) -> tuple[Array, str]:
    """Seconds by the one form that all rows have, or by forms that all give the same seconds."""
    import pandas as pd

    found: dict[str, Array] = {}
    worst = 0
    for form in forms:
        stamps = pd.to_datetime(text, format=form, errors="coerce", utc=form == "ISO8601")
        if "%f" not in form and "%S" in form:
            stamps = stamps.fillna(pd.to_datetime(text, format=form.replace("%S", "%S.%f"), errors="coerce"))
        if not stamps.hasnans:
            found[form] = seconds(stamps)
        worst = max(worst, int(np.argmax(stamps.isna())))
    if not found:
        raise NoTimeError(worst, "{} is not of the form of the rows before; correct it")
    (form, values), *others = found.items()
    if any(not np.array_equal(values, other) for _, other in others):
        raise NoTimeError(
            0,
            f"{text.iloc[0]!r} may begin with the day or the month, which gives other times; say which, as "
            f"{_as_said(header, form.replace('-', '/'))}, or write dates as 2026-11-22",
        )
    return values, f"date {form.replace('%', '')}" if form != "ISO8601" else "date"


def _of_clock(text: pd.Series, header: str) -> tuple[Array, str]:
    """Seconds of HH:MM:SS, going on after midnight."""
    import pandas as pd

    told = f"write it so, or give its form, as {_as_said(header, '%H:%M')} or %M:%S"
    wrong = ~text.str.fullmatch(r"\d+:\d\d:\d\d(\.\d+)?")
    _refuse(wrong, f"{{}} is not of the form HH:MM:SS; {told}")
    values = pd.to_timedelta(text).dt.total_seconds().to_numpy(dtype=float)
    midnights = np.diff(values, prepend=values[0]) < -DAY / 2
    return values + DAY * np.cumsum(midnights), "HH:MM:SS"


def _of_minutes(text: pd.Series) -> tuple[Array, str]:
    """Seconds of M:SS.S, which may go on with H:MM:SS.S, or with 0:00.0 after an hour."""
    wrong = ~text.str.fullmatch(r"(\d+:)?\d+:\d\d(\.\d+)?")
    _refuse(wrong, "{} is not of the form M:SS.S of other rows; correct it")
    values = np.array([_seconds_of(cell) for cell in text])
    within_hours = bool((values < HOUR).all())
    hours = (np.diff(values, prepend=values[0]) < -HOUR / 2) & within_hours
    return values + HOUR * np.cumsum(hours), "M:SS.S"


def _seconds_of(cell: str) -> float:
    """Seconds of a time written with colons; its last number is seconds."""
    seconds = 0.0
    for part in cell.split(":"):
        seconds = 60 * seconds + float(part)
    return seconds
