"""A run's values as files that pandas and other tools read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.recording.result import Result

BLOCK_ROWS = 1 << 12


def series_writers(result: Result) -> dict[str, Callable[[Path], object]]:
    """What writes `results.csv` and `results.parquet`: a column a variable, with its unit in the name.

    Written block by block, so that a run whose values lie on disk never has to fit into the memory.
    """
    import pyarrow
    from pyarrow import csv, parquet

    names = ["time [s]", *(result.table.heading(name) for name in result.table.names)]
    schema = pyarrow.schema([(name, pyarrow.float64()) for name in names])

    def write(writer: Any) -> None:
        with writer:
            for block in _blocks(result):
                writer.write_table(_table(names, block))

    return {
        "results.csv": lambda path: write(csv.CSVWriter(path, schema)),
        "results.parquet": lambda path: write(parquet.ParquetWriter(path, schema)),
    }


def _blocks(result: Result) -> Iterator[NDArray[np.float64]]:
    """Times and values of some thousand points after another, shape (columns, points)."""
    points = result.table.points
    for first in range(0, len(result.table), BLOCK_ROWS):
        values = np.asarray(result.table.values[first : first + BLOCK_ROWS])
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
