"""A run's values as files that pandas and other tools read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warmlink.orchestration.master.result import Result


def write_series(result: Result, folder: Path) -> None:
    """Write `results.csv` and `results.parquet`: a column a variable, with its unit in the name."""
    import pyarrow
    from pyarrow import csv, parquet

    columns: Mapping[str, Any] = {
        "time [s]": result.times,
        **{result.table.heading(name): result[name] for name in result.table.names},
    }
    table = pyarrow.table(columns)
    csv.write_csv(table, folder / "results.csv")
    parquet.write_table(table, folder / "results.parquet")
