"""Seconds of written dates and times of the day, as loggers write them; a clock goes on after midnight.

Knows no file: what cannot be read is told by its row, and the caller says which file and column that is in.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.orchestration.arrays import Array

if TYPE_CHECKING:
    import pandas as pd

MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0

_MINUTES = re.compile(r"\d+:\d\d\.\d+")
_CLOCK = re.compile(r"\d+:\d\d(:\d\d(\.\d+)?)?")
_HALVES = re.compile(r"(?<=\d)\s*([AaPp])\.?\s?[Mm]\.?$")
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
    (r"[A-Za-z]{3} \d+,? \d{4}", ("%b-%d-%Y",)),
)
"""Dates by their look, each with the orders of day, month and year that it may have."""

_DIGITS = {"Y": 4, **dict.fromkeys("mdyHIMS", 2)}
"""Digits of what directives of a form stand for."""

_LOOKS = {"Y": r"\d{4}", "b": "[A-Za-z]{3}", "f": r"\d+", "p": "[AaPp][Mm]"}
"""Patterns of what directives of a form stand for; `dHIMmSy` have one or two digits."""


class NoTimeError(Exception):
    """A cell is no time: its row, counted from 0, and why; `{}` stands for the cell in the sentence."""

    def __init__(self, row: int, sentence: str) -> None:
        super().__init__(sentence)
        self.row, self.sentence = row, sentence


def _refuse(wrong: pd.Series, sentence: str) -> None:
    """Raise NoTimeError at the first of some rows, if there is any."""
    for row in np.flatnonzero(wrong)[:1].tolist():
        raise NoTimeError(row, sentence)


def seconds(cells: Any) -> Array:
    """Seconds from the first filled cell of dates or durations; NaN for an empty one."""
    filled = cells.dropna()
    if filled.empty:
        return np.full(len(cells), np.nan)
    try:
        passed = cells - filled.iloc[0]
    except OverflowError:  # more than 292 years, counted in ns
        passed = cells.dt.as_unit("us") - filled.iloc[0].as_unit("us")
    return np.asarray(passed.dt.total_seconds(), dtype=np.float64)


def as_written(cells: Any, form: str) -> pd.Series:
    """Text of cells that were read as numbers: with the zeros before them if the form is digits alone."""
    text = cells.map(lambda cell: f"{cell:.0f}" if cell == np.floor(cell) else str(cell), na_action="ignore")
    directives = re.fullmatch(f"(?:%[{''.join(_DIGITS)}])+", form)
    digits = sum(_DIGITS[each] for each in form if each != "%") if directives else 0
    return text.fillna("").where(cells.isna(), text.astype(str).str.zfill(digits))


def written_seconds(text: pd.Series, form: str | None, header: str) -> tuple[Array, str]:
    """Seconds of some written dates, from the first, or times of the day, from midnight, and their form.

    `form` is that of the dates if somebody says it, as `%d/%m/%Y %H:%M:%S`; advice names the column by its
    `header`. NoTimeError is raised at the first that cannot be read, or if day and month could be swapped.
    """
    _refuse(text == "", "the time is missing")
    given, text = text, text.str.replace(_HALVES, r" \1M", regex=True)
    if form is not None and "%" in form:
        return _of_form(text, header, form)
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
        raise _no_date(str(given.iloc[0]), header)
    clock = stamp["clock"]
    if orders[0] == "%Y-%m-%d":
        text = text.str.replace(r"^(\d{4})[/.](\d+)[/.](\d+)", r"\1-\2-\3", regex=True)
    elif "." not in look:
        text = text.str.replace(r"^(\w+)[-/ ](\w+),?[-/ ]", r"\1-\2-", regex=True)
    ending = ":%S" if clock.count(":") > 1 else ""
    hours = f"%I:%M{ending} %p" if clock[-1] in "Mm" else f"%H:%M{ending}"
    forms = [f"{order}{stamp['between']}{hours}" for order in orders]
    if orders[0] == "%Y-%m-%d" and "%p" not in hours:
        forms = ["ISO8601"]
        _refuse_unlike(text)
    return _by_forms(text, given, header, forms)


def _refuse_unlike(text: pd.Series) -> None:
    """Raise NoTimeError where ISO dates lack what others have, and would be read as midnight, or as UTC."""
    short = text.str.fullmatch(r"[\d-]+(?:[T ]\d+)?")
    _refuse(short, "{} lacks the time of the day, or its minutes, that other rows have; give it in full")
    has_offset = text.str.contains(r":\d\d.*(?:Z|[+-]\d\d(?::?\d\d)?)$")
    if has_offset.any():
        _refuse(~has_offset, "{} has no offset from UTC, as other rows have; give it, or give none")


def _as_said(header: str, form: str) -> str:
    """How a user says the form of the dates under a header."""
    return argument("units", {header: form})


def _no_date(cell: str, header: str) -> NoTimeError:
    """What to raise if nobody said the form of the dates, and the first cell does not tell it."""
    return NoTimeError(
        0,
        f"{cell!r} is no date with a time that can be read; write it as 2026-11-22 08:59:31, or give "
        f"its form, as {_as_said(header, '%d/%m/%Y %H:%M:%S')}",
    )


def _stamps(text: pd.Series, form: str) -> pd.Series:
    """Instants by a form, whose seconds may have a fraction; NaT for what does not have the form."""
    import pandas as pd

    written = "%S" in form and "%f" not in form
    fractions = [form.replace("%S", f"%S{mark}%f") for mark in ".,"] if written else []
    stamps = pd.to_datetime(text, format=form, errors="coerce", utc=True)
    for fraction in fractions:
        if stamps.hasnans:
            stamps = stamps.fillna(pd.to_datetime(text, format=fraction, errors="coerce", utc=True))
    return stamps


def _of_form(text: pd.Series, header: str, form: str) -> tuple[Array, str]:
    """Seconds by a form that somebody gave; without a date in it they go on after midnight, or the hour."""
    said = _as_said(header, form)
    form = re.sub(r"(?<=%[IMSf])\s*%p", " %p", form)
    try:
        stamps = _stamps(text, form)
    except (ValueError, re.error) as fault:
        raise NoTimeError(
            0, f"{said} is no form of dates ({fault}); write it as {_as_said(header, '%d/%m/%Y %H:%M:%S')}"
        ) from None
    for row in np.flatnonzero(stamps.isna())[:1].tolist():
        wrong = "is a date or a time that does not exist by" if _looks(text.iloc[row], form) else "is not of"
        raise NoTimeError(row, f"{{}} {wrong} the form that {said} gives; correct the cell or the form")
    if re.search("%[aAbBcdDeFGjmuUVwWxyY]", form):
        return seconds(stamps), f"date {form.replace('%', '')}"
    values = np.asarray((stamps - stamps.iloc[0].normalize()).dt.total_seconds(), dtype=np.float64)
    period = DAY if re.search("%[HITcX]", form) else HOUR if "%M" in form else MINUTE
    return _going_on(values, period), form.replace("%", "")


def _looks(cell: str, form: str) -> bool:
    """Whether a cell looks as a form asks for, whatever its numbers are."""
    if form == "ISO8601":
        return (
            re.fullmatch(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:?\d\d)?", cell) is not None
        )
    parts = re.split("%(.)", form)
    looks = [_LOOKS.get(part, r"\d\d?") if i % 2 else re.escape(part) for i, part in enumerate(parts)]
    return re.fullmatch("".join(looks), re.sub(r"(:\d\d)[.,]\d+", r"\1", cell)) is not None


def _by_forms(text: pd.Series, given: pd.Series, header: str, forms: list[str]) -> tuple[Array, str]:
    """Seconds by the one form that all rows have, or by forms that all give the same seconds.

    `given` holds the cells as they are written, for sentences.
    """
    found: dict[str, Array] = {}
    furthest = 0
    for form in forms:
        stamps = _stamps(text, form)
        if not stamps.hasnans:
            found[form] = seconds(stamps)
        furthest = max(furthest, int(np.argmax(stamps.isna())))
    if not found:
        if any(_looks(text.iloc[furthest], form) for form in forms):
            raise NoTimeError(furthest, "{} is a date or a time that does not exist; correct it")
        if furthest == 0:
            raise _no_date(str(given.iloc[0]), header)
        before = f"the form of the rows before, as {given.iloc[furthest - 1]!r}"
        raise NoTimeError(furthest, f"{{}} is not of {before}; correct it")
    (form, values), *others = found.items()
    if any(not np.array_equal(values, other) for _, other in others):
        separator = "/" if "/" in str(given.iloc[0]) else "-"
        raise NoTimeError(
            0,
            f"{given.iloc[0]!r} may begin with the day or the month, which gives other times; say which, as "
            f"{_as_said(header, form.replace('-', separator))}, or write dates as 2026-11-22",
        )
    return values, f"date {form.replace('%', '')}" if form != "ISO8601" else "date"


def _going_on(values: Array, period: float) -> Array:
    """Seconds of a clock that begins anew after a period in s, as if it went on."""
    return values + period * np.cumsum(np.diff(values, prepend=values[0]) < -period / 2)


def _of_clock(text: pd.Series, header: str) -> tuple[Array, str]:
    """Seconds of HH:MM:SS, going on after midnight."""
    told = f"write it so, or give its form, as {_as_said(header, '%H:%M')} or %M:%S"
    wrong = ~text.str.fullmatch(r"\d{1,6}:[0-5]\d:[0-5]\d(\.\d+)?")
    _refuse(wrong, f"{{}} is not of the form HH:MM:SS with minutes and seconds below 60; {told}")
    return _going_on(np.array([_seconds_of(cell) for cell in text]), DAY), "HH:MM:SS"


def _of_minutes(text: pd.Series) -> tuple[Array, str]:
    """Seconds of M:SS.S, which may go on with H:MM:SS.S, or with 0:00.0 after an hour."""
    wrong = ~text.str.fullmatch(r"(\d{1,6}:[0-5]\d|\d{1,8}):[0-5]\d(\.\d+)?")
    _refuse(wrong, "{} is not of the form M:SS.S of other rows, with seconds below 60; correct it")
    values = np.array([_seconds_of(cell) for cell in text])
    within_hours = bool((values < HOUR).all())
    return _going_on(values, HOUR) if within_hours else values, "M:SS.S"


def _seconds_of(cell: str) -> float:
    """Seconds of a time written with colons; its last number is seconds."""
    total = 0.0
    for part in cell.split(":"):
        total = 60 * total + float(part)
    return total
