"""A run's values as files that pandas and other tools read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.names import instead
from warmlink.orchestration.console import remark
from warmlink.orchestration.master.recording.result import Table

BLOCK_ROWS = 1 << 12


def series_writers(
    table: Table, patterns: Sequence[str] = (), csv: bool = True
) -> dict[str, Callable[[Path], object]]:
    """What writes `results.csv` and `results.parquet`: a column a variable, with its unit in the name.

    Written block by block, so that a run whose values lie on disk never has to fit into the memory.

    Parameters
    ----------
    table : the run's values
    patterns : names of variables, such as `link.*`; every variable if there are none. One without a match is
        remarked on, as the run is over
    csv : whether results.csv is written beside results.parquet, which is less than half its size
    """
    import pyarrow
    import pyarrow.csv
    from pyarrow import parquet

    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in table.names):
            remark(f"--record {pattern}: nothing that was recorded; {instead(pattern, table.names)}")
    names = [name for name in table.names if any(fnmatchcase(name, p) for p in patterns)] or table.names
    headings = ["time [s]", *(table.heading(name) for name in names)]
    columns = [table.names.index(name) for name in names]
    schema = pyarrow.schema([(heading, pyarrow.float64()) for heading in headings])

    def write(writer: Any) -> None:
        with writer:
            for block in _blocks(table, columns):
                # From buffers, since anything else would load pandas first.
                arrays = [
                    pyarrow.Array.from_buffers(
                        pyarrow.float64(), column.size, [None, pyarrow.py_buffer(column)]
                    )
                    for column in np.ascontiguousarray(block)
                ]
                writer.write_table(pyarrow.Table.from_arrays(arrays, names=headings))

    writers: dict[str, Callable[[Path], object]] = {
        "results.parquet": lambda path: write(parquet.ParquetWriter(path, schema, use_dictionary=False))
    }
    if csv:
        writers["results.csv"] = lambda path: write(pyarrow.csv.CSVWriter(path, schema))
    return writers


def _blocks(table: Table, columns: Sequence[int]) -> Iterator[NDArray[np.float64]]:
    """Times and values of some thousand points after another, shape (1 + columns, points)."""
    times = table.times
    for first in range(0, len(table), BLOCK_ROWS):
        values = np.asarray(table.values[first : first + BLOCK_ROWS])[:, columns]
        yield np.vstack([times[first : first + BLOCK_ROWS], values.T])
