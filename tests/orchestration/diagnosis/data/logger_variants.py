"""One run in any form that a logger may give it, and what has to come of it."""

from collections.abc import Callable
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_experiment
from warmlink.orchestration.diagnosis.data.options import ReadOptions, read_options

NAMES = ("time", "speed", "torque", "ambient_temperature", "base_temperature", "elongation")
UNITS = ("s", "rad/s", "N.m", "degC", "degC", "um")
ROWS = [
    [
        f"{15 * i}",
        "3.43" if i < 30 else "0",
        "2.5",
        f"{22 + i / 64:.4f}",
        f"{22.25 + i / 8:.3f}",
        f"{i * 1.25}",
    ]
    for i in range(60)
]
BEGIN = datetime(2026, 11, 22, 23, 52, 1)
"""A start from which the run goes over midnight."""

TEXT = Callable[[], str | bytes]


def headed(form: str, units: tuple[str, ...] = UNITS) -> list[str]:
    return [form.format(name, unit) for name, unit in zip(NAMES, units, strict=True)]


PLAIN = headed("{} [{}]")


def text(
    separator: str = ",", header: list[str] = PLAIN, rows: list[list[str]] = ROWS, decimal: str = "."
) -> str:
    lines = [header, *([cell.replace(".", decimal) for cell in row] for row in rows)]
    return "\n".join(separator.join(line) for line in lines) + "\n"


def timed(form: str | Callable[[int, datetime], str], header: str = "time", step: int = 15) -> str:
    """The file with other times, written by a form of `strftime` or by the number of the row."""

    def stamp(i: int) -> str:
        at = BEGIN + timedelta(seconds=step * i)
        return at.strftime(form) if isinstance(form, str) else form(i, at)

    return text(header=[header, *PLAIN[1:]], rows=[[stamp(i), *row[1:]] for i, row in enumerate(ROWS)])


class Variant(NamedTuple):
    """A file, what is said of it, and what is expected: the same numbers, or a part of the refusal."""

    content: str | bytes | pd.DataFrame | Callable[[Path], None]
    refused: str = ""
    units: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    decimal: str = ""
    suffix: str = ".csv"
    missing: int = 0
    replaced: int = 0
    within: float = 0.0

    @property
    def told(self) -> ReadOptions:
        return read_options(self.units, self.names, self.decimal)


def given(variant: Variant, folder: Path) -> Path | pd.DataFrame:
    path = folder / f"run{variant.suffix}"
    if isinstance(variant.content, pd.DataFrame):
        return variant.content
    if callable(variant.content):
        variant.content(path)
    else:
        content = variant.content
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@cache
def plain() -> Experiment:
    """Give the run in the form that every other is compared with."""
    with TemporaryDirectory() as folder:
        return read_experiment(given(Variant(text()), Path(folder)))


def check(variant: Variant, folder: Path) -> None:
    """Read a variant: it gives the plain run's numbers, or is refused, in a sentence for each mistake."""
    source = given(variant, folder)
    if variant.refused:
        with pytest.raises(InputError) as refusal:
            read_experiment(source, variant.told)
        first, *more = str(refusal.value).split("\n")
        assert variant.refused in first
        assert all(each.startswith(("and ", first.partition(":")[0])) for each in more), more
        return
    (read,), (wanted,) = read_experiment(source, variant.told).runs, plain().runs
    assert np.array_equal(read.time, wanted.time) or variant.within
    assert np.allclose(read.time, wanted.time, rtol=variant.within, atol=0)
    for kind in ("inputs", "readings"):
        one, other = getattr(read, kind), getattr(wanted, kind)
        assert one.keys() == other.keys()
        for variable, values in one.items():
            there = np.isfinite(values)
            assert np.allclose(values[there], other[variable][there], rtol=variant.within, atol=0), variable
    gaps = sum(int(np.isnan(values).sum()) for values in read.readings.values())
    assert gaps == variant.missing
    assert len(read.remarks) == variant.missing + variant.replaced
    assert all("row 22, column" in remark or "row 2, column" in remark for remark in read.remarks)
