"""A log of a machine of other structure than the model that watches it, whose thermometer slips."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.strange_machine import Demand, Machine, Room
from benchmarks.watch import HEADERS, WatchedCell, rows_of
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.sources.protocol import Source
from warmlink.orchestration.watch.sources.rows import LoggedRow, RowReader

SOUND, SLIPS, HOURS = 4.0, 4.8, 5.6
"""h that are declared sound, after which a thermometer slips by 3 K, and that the log lasts."""

RATE = 1.0
"""False alarms per day for which the tests work out thresholds: rarer ones need more made-up days."""

WORK = [each for _ in range(9) for each in (Demand(2400, 3.2, 2.4), Demand(1200))]

BASE = HEADERS.index("base_temperature [degC]")


@pytest.fixture(scope="session")
def table() -> np.ndarray:
    """Rows of a log, sound but for its end."""
    machine, draw = Machine(4), np.random.default_rng(4)
    rows = rows_of(machine.run(WORK, 4, Room()), draw, 0.0)
    rows = rows[rows[:, 0] < 3600 * HOURS][::3]
    rows[rows[:, 0] > 3600 * SLIPS, BASE] += 3.0
    return rows


def lines_of(table: np.ndarray) -> list[str]:
    """A log as lines of CSV, headers first."""
    rows = [",".join(repr(value) for value in row) for row in table.tolist()]
    return [",".join(HEADERS), *rows]


@pytest.fixture(scope="session")
def log(table: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same as a file."""
    path = tmp_path_factory.mktemp("log") / "cell.csv"
    path.write_text("\n".join(lines_of(table)) + "\n", "utf-8")
    return path


@pytest.fixture(scope="session")
def sound_cell(table: np.ndarray) -> tuple[WatchedCell, np.ndarray]:
    """A watcher that has learnt from the sound part, and the rows after it; fork it to use it."""
    cell = WatchedCell.made(4, SOUND / 24, RATE)
    until = int(np.argmax(table[:, 0] > 3600 * (SOUND + 0.2)))
    for row in table[:until].tolist():
        read = cell.reader.read(row)
        assert read is not None
        for tick in cell.gatherer.add(read):
            list(cell.watcher.add(tick))
    assert cell.watcher.limits is not None
    return cell, table[until:]


ROWS = 40


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def read(source: Source, count: int = ROWS, enough: Callable[[], bool] = lambda: False) -> list[str]:
    """So many rows of a source in SI, as text."""
    reader = RowReader(source.name, source.headers, rig_of("WarmupCell"), ReadOptions(), source.comma)
    found: list[LoggedRow | None] = []
    give_up = time.monotonic() + 20
    for cells in source.rows():
        if cells is not None:
            found.append(reader.read(cells))
        if len(found) >= count or enough() or time.monotonic() > give_up:
            break
    source.close()
    return [repr(each) for each in found]


@pytest.fixture(scope="session")
def expected(table: np.ndarray) -> list[str]:
    reader = RowReader("table", HEADERS, rig_of("WarmupCell"), ReadOptions())
    return [repr(reader.read(row)) for row in table[:ROWS].tolist()]
