"""Results of a run as columns of numbers, wherever they are: in memory, in a file, in a folder."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.arguments import path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.safe_text import of_cell
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import settle
from warmlink.orchestration.master.recording.recorder import VALUES, values_in
from warmlink.orchestration.text_files import is_file, is_folder, shown

if TYPE_CHECKING:
    import pandas

TIME = "time [s]"


@dataclass(frozen=True)
class Columns:
    """Columns of numbers by their names with units, in the order of their times.

    Attributes
    ----------
    frame : as it was read
    where : what is said to hold it
    """

    frame: pandas.DataFrame = field(repr=False)
    where: str

    @property
    def names(self) -> list[str]:
        """Names with units, the time among them."""
        return [str(name) for name in self.frame.columns]

    @cached_property
    def time(self) -> Array:
        """Times in s, never falling, shape (rows,)."""
        return self._numbers(TIME)[self._order]

    def __getitem__(self, name: str) -> Array:
        """A column, shape (rows,), NaN where a cell is empty; InputError where one holds no number."""
        return self._numbers(name)[self._order]

    @cached_property
    def _order(self) -> Any:
        times = self._numbers(TIME)
        if not np.isfinite(times).all():
            row = int(np.argmin(np.isfinite(times)))
            raise InputError(f"{self.where}: row {row + 1} has no time; give each row one, in s")
        return np.argsort(times, kind="stable")

    def _numbers(self, name: str) -> Array:
        import pandas

        column = self.frame[self.frame.columns[self.names.index(name)]]
        found = None if column.dtype.kind in "mMc" else pandas.to_numeric(column, errors="coerce")
        wrong = column.notna() if found is None else found.isna() & column.notna()
        if found is None or wrong.any():
            row = int(np.argmax(wrong))
            raise InputError(
                f"{self.where}: {name}: row {row + 1} holds {shown(str(column.iloc[row]))}, which is no "
                "number; give results of run or simulate"
            )
        return found.to_numpy(dtype=np.float64, na_value=np.nan)


def columns_of(results: Any) -> Columns:
    """Results of a run as columns, wherever they are; raises InputError where there are none."""
    import pandas

    if isinstance(results, pandas.DataFrame):
        return _checked(results, "the results")
    if hasattr(results, "to_frame"):
        return _checked(results.to_frame(), "the results")
    path = path_given("results", results)
    if not is_folder(path):
        return _read(path)
    settle(path)
    places = [place for name in ("results.parquet", "results.csv") if is_file(place := path / name)]
    values = path / VALUES
    # A run that writes as it goes has written after the results there: these are those of the run before.
    if is_file(values) and not any(_changed(place) >= _changed(values) for place in places):
        table = values_in(path)
        if table is not None and len(table):
            told = f"drawn are the values that it wrote, as far as {table.times[-1]:g} s"
            remark(f"{path}: the last run there did not end; {told}")
            return _checked(table.to_frame(), str(values))
        if places:
            remark(f"{path}: the last run there did not come to a value; drawn is the run before")
    if not places:
        raise InputError(f"{path}: no results there; give a folder with results.parquet, or the file itself")
    return _read(places[0])


def _changed(path: Path) -> int:
    return path.stat().st_mtime_ns


def _read(path: Path) -> Columns:
    import pandas

    if not is_file(path):
        raise InputError(f"{path}: no results there; give a folder with results.parquet, or the file itself")
    try:
        with warnings.catch_warnings():
            # A row that is longer than the header would move all others by a column.
            warnings.simplefilter("error", pandas.errors.ParserWarning)
            parquet = path.suffix == ".parquet"
            found = pandas.read_parquet(path) if parquet else pandas.read_csv(path, index_col=False)
            found = found if parquet else found.rename(columns=of_cell)
    except (OSError, ValueError, LookupError, TypeError, NotImplementedError, Warning) as fault:
        told = (str(fault).splitlines() or [type(fault).__name__])[0].rpartition("C error: ")[2]
        if told.startswith("EOF inside string"):
            told = 'a quote (") opens a cell and none closes it'
        raise InputError(f"{path}: cannot be read ({told[:160]}); give results of run or simulate") from None
    return _checked(found, str(path))


def _checked(frame: pandas.DataFrame, where: str) -> Columns:
    """Columns of a table; InputError where it has no time, no rows, or two columns of one name."""
    found = Columns(frame, where)
    if TIME not in found.names:
        raise InputError(f"{where}: has no column {TIME!r}; give results of run or simulate")
    if frame.empty:
        raise InputError(f"{where}: has no rows; give results of a run that came to its first point")
    if len(set(found.names)) < len(found.names):
        raise InputError(f"{where}: two of its columns have one name; rename one")
    return found
