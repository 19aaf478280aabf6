"""A run's values as files that pandas and other tools read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.names import instead
from warmlink.orchestration.console import remark
from warmlink.orchestration.master.recording.result import Table

BLOCK_ROWS = 1 << 12


@dataclass(frozen=True)
class Written:
    """What of a run's values goes into files.

    Attributes
    ----------
    patterns : names of variables, such as `link.*`; every variable if there are none
    csv : whether results.csv is written beside results.parquet, which is less than half its size
    """

    patterns: tuple[str, ...] = ()
    csv: bool = True

    def names(self, table: Table) -> list[str]:
        """Give the matching names, in order; a pattern without any is remarked on, as the run is over."""
        for pattern in self.patterns:
            if not any(fnmatchcase(name, pattern) for name in table.names):
                remark(f"--record {pattern}: nothing that was recorded; {instead(pattern, table.names)}")
        kept = [name for name in table.names if any(fnmatchcase(name, p) for p in self.patterns)]
        return kept or list(table.names)


def series_writers(table: Table, written: Written) -> dict[str, Callable[[Path], object]]:
    """What writes `results.csv` and `results.parquet`: a column a variable, with its unit in the name.

    Written block by block, so that a run whose values lie on disk never has to fit into the memory.
    """
    import pyarrow
    from pyarrow import csv, parquet

    names = written.names(table)
    headings = ["time [s]", *(table.heading(name) for name in names)]
    columns = [table.names.index(name) for name in names]
    schema = pyarrow.schema([(heading, pyarrow.float64()) for heading in headings])

    def write(writer: Any) -> None:
        with writer:
            for block in _blocks(table, columns):
                writer.write_table(_table(headings, block))

    writers: dict[str, Callable[[Path], object]] = {
        "results.parquet": lambda path: write(parquet.ParquetWriter(path, schema))
    }
    if written.csv:
        writers["results.csv"] = lambda path: write(csv.CSVWriter(path, schema))
    return writers


def _blocks(table: Table, columns: Sequence[int]) -> Iterator[NDArray[np.float64]]:
    """Times and values of some thousand points after another, shape (1 + columns, points)."""
    points = table.points
    for first in range(0, len(table), BLOCK_ROWS):
        values = np.asarray(table.values[first : first + BLOCK_ROWS])[:, columns]
        times = points.start_time + np.arange(first, first + len(values), dtype=np.float64) * points.step_size
        yield np.vstack([times, values.T])


def _table(names: list[str], block: NDArray[np.float64]) -> Any:
    """Arrow table of float columns; built from buffers, since anything else would load pandas first."""
    import pyarrow

    arrays = [
        pyarrow.Array.from_buffers(pyarrow.float64(), column.size, [None, pyarrow.py_buffer(column)])
        for column in np.ascontiguousarray(block)
    ]
    return pyarrow.Table.from_arrays(arrays, names=names)
