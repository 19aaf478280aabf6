"""A run's values as files that pandas and other tools read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from warmlink.orchestration.master.result import Result


def write_series(result: Result, folder: Path) -> None:
    """Write `results.csv` and `results.parquet`: a column a variable, with its unit in the name."""
    from pyarrow import csv, parquet

    columns: dict[str, ArrayLike] = {"time [s]": result.times}
    for name in result.table.names:
        columns[result.table.heading(name)] = result[name]
    table = _table(columns)
    csv.write_csv(table, folder / "results.csv")
    parquet.write_table(table, folder / "results.parquet")


def _table(columns: dict[str, ArrayLike]) -> object:
    """Arrow table of float columns; built from buffers, since anything else would load pandas first."""
    import pyarrow

    arrays = []
    for values in columns.values():
        flat = np.ascontiguousarray(values, dtype=np.float64)
        arrays.append(
            pyarrow.Array.from_buffers(pyarrow.float64(), flat.size, [None, pyarrow.py_buffer(flat)])
        )
    return pyarrow.Table.from_arrays(arrays, names=list(columns))
