"""Where recorded values go: the memory, or a file that is valid at every moment."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.line import Line
from warmlink.orchestration.master.table import Table

VALUES, COLUMNS = "values.npy", "columns.json"
BLOCK_ROWS = 4096


class Store(Protocol):
    """Where recorded blocks go."""

    def open(
        self, names: Sequence[str], units: Mapping[str, str | None], points: CommunicationPoints
    ) -> NDArray[np.float64]:
        """Give a block to fill."""

    def put(self, first: int, rows: NDArray[np.float64]) -> None:
        """Take rows, the first of which belongs to point `first`; the block may then be filled anew."""

    def secure(self) -> None:
        """Have everything taken survive the process, as far as that can be had."""

    def values(self, first: int, rest: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take the last rows and give all, shape (rows, columns)."""


class Memory:
    """Keeps one block for the whole run.

    Parameters
    ----------
    line : Line, optional
        Gives the memory where the run is guarded.
    """

    def __init__(self, line: Line | None = None) -> None:
        self._line = line

    def open(
        self, names: Sequence[str], units: Mapping[str, str | None], points: CommunicationPoints
    ) -> NDArray[np.float64]:
        """Give the whole array."""
        shape = points.count + 1, len(names)
        return np.full(shape, np.nan) if self._line is None else self._line.block(*shape)

    def put(self, first: int, rows: NDArray[np.float64]) -> None:
        """Nothing to do: the block is never full before the end."""

    def secure(self) -> None:
        """Nothing to do: the memory goes with the process."""

    def values(self, first: int, rest: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give what was filled."""
        return rest


class Folder:
    """Writes `values.npy` and `columns.json` into a folder, block by block.

    The header of `values.npy` counts the rows that were written before it was, so that the file can be
    read whenever the run ends, be it by a kill.

    Parameters
    ----------
    folder : Path
        Made where it does not exist.
    keep : int
        Rows that an interrupted run left there and that its checkpoint counts on; 0 begins anew.
    """

    def __init__(self, folder: Path, *, keep: int = 0) -> None:
        self.folder = folder
        self._keep = keep
        self._file: BinaryIO | None = None
        self._columns = 0

    def open(
        self, names: Sequence[str], units: Mapping[str, str | None], points: CommunicationPoints
    ) -> NDArray[np.float64]:
        """Give a block of 4096 rows.

        Raises
        ------
        InputError
            Where the folder cannot be written, or does not hold the rows to keep.
        """
        about = {
            "columns": [{"name": name, "unit": units[name]} for name in names],
            "start_time_s": points.start_time,
            "step_size_s": points.step_size,
            "steps": points.count,
        }
        scratch = self.folder / (COLUMNS + ".new")
        path = self.folder / VALUES
        self._columns = len(names)
        kept = self._header(0, write=False) + self._keep * 8 * self._columns
        if self._keep and (not path.exists() or path.stat().st_size < kept):
            raise InputError(f"{path}: lacks values that the checkpoint beside it counts on; start anew")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            scratch.write_text(json.dumps(about, indent=1), encoding="utf-8")
            scratch.replace(self.folder / COLUMNS)
            self._file = path.open("r+b" if self._keep else "w+b")
        except OSError as fault:
            raise InputError(
                f"{self.folder}: cannot be written ({fault.strerror}); choose another folder"
            ) from None
        return np.full((min(BLOCK_ROWS, points.count + 1), len(names)), np.nan)

    def put(self, first: int, rows: NDArray[np.float64]) -> None:
        """Write rows to their place, then count them."""
        assert self._file is not None
        start = self._header(first + len(rows), write=False)
        self._file.seek(start + first * 8 * self._columns)
        self._file.write(np.ascontiguousarray(rows, dtype="<f8").tobytes())
        self._file.flush()
        self._header(first + len(rows), write=True)
        self._file.flush()

    def secure(self) -> None:
        """Have everything written reach the disk."""
        assert self._file is not None
        os.fsync(self._file.fileno())

    def values(self, first: int, rest: NDArray[np.float64]) -> NDArray[np.float64]:
        """Write the last rows, drop what lies behind them, and map the file."""
        assert self._file is not None
        self.put(first, rest)
        self._file.truncate(self._header(0, write=False) + (first + len(rest)) * 8 * self._columns)
        self._file.close()
        return _map(self.folder / VALUES)

    def _header(self, rows: int, *, write: bool) -> int:
        """Write NumPy's header, which leaves room for any number of rows; give its length."""
        from io import BytesIO

        stream = BytesIO()
        shape = (rows, self._columns)
        np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
        if write:
            assert self._file is not None
            self._file.seek(0)
            self._file.write(stream.getvalue())
        return len(stream.getvalue())


def read_folder(folder: Path) -> Table:
    """Read what a run wrote into a folder, finished or not; the values stay on disk.

    Raises
    ------
    InputError
        Where there are no results.
    """
    try:
        about = json.loads((folder / COLUMNS).read_text(encoding="utf-8"))
        values = _map(folder / VALUES)
        names = [column["name"] for column in about["columns"]]
        units = {column["name"]: column["unit"] for column in about["columns"]}
        points = CommunicationPoints(about["start_time_s"], about["step_size_s"], about["steps"])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(
            f"{folder}: holds no results that can be read ({error}); give a run's folder"
        ) from error
    return Table(names, units, points, values)


def _map(path: Path) -> NDArray[np.float64]:
    # An array without rows or columns cannot be mapped.
    values: NDArray[np.float64] = (
        np.load(path) if path.stat().st_size <= 128 else np.load(path, mmap_mode="r")
    )
    return values
