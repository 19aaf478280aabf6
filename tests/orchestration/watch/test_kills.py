"""A watch that is killed at any moment tells the same once it is started again."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.watch import HEADERS, WatchedCell
from tests.orchestration.watch.conftest import RATE, SOUND, lines_of
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.page import write_watch
from warmlink.orchestration.watch.sources.lines import LinesSource
from warmlink.orchestration.watch.sources.protocol import Source
from warmlink.orchestration.watch.sources.rows import Cells
from warmlink.orchestration.watch.state import saved
from warmlink.orchestration.watch.watching import ALARMS, JOURNAL, STATE, Watching, WatchOptions

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes

LIVES = 0.08
"""s of processor time that a watch lives before the first kill, at most; before each other as much more."""


class KilledError(Exception):
    """The end of a process, as far as whoever reads a source can tell."""


class Pipe:
    """Rows that cannot be read again, as those of standard input and of servers."""

    name, headers, comma = "pipe", HEADERS, False

    def __init__(self, rows: np.ndarray, killed: bool) -> None:
        self._rows, self._killed = rows, killed
        self.told: list[str] = []

    def rows(self) -> Iterator[Cells | None]:
        """Rows with pauses between, after which the process may be killed."""
        for k, row in enumerate(self._rows.tolist()):
            yield row
            if k % 7 == 0:
                yield None
        if self._killed:
            raise KilledError

    def place(self) -> None:
        """None: it cannot go back."""

    def close(self) -> None:
        """Nothing is open."""


def begun(folder: Path, source: Source, cell: WatchedCell, rows: int) -> None:
    """Write the state of a watch that has learnt, as a restart finds it."""
    folder.mkdir()
    more = {"events": [], "rows": rows, "doubtful": 0, "place": source.place()}
    saved(folder / STATE, asked_for().facts(source), cell.watcher, cell.gatherer, more)


def watch(folder: Path, source: Source) -> None:
    """Go on to the log's end."""
    watching = Watching(source, asked_for(), folder, write_watch)
    assert watching.restore()
    for _ in watching.run():
        pass


def asked_for() -> WatchOptions:
    return WatchOptions(rig_of("WarmupCell"), {}, ReadOptions(), SOUND * 3600.0, RATE, until_end=True)


def file_in(path: Path, folder: Path) -> Source:
    return LinesSource(path, follow=False, begin=Watching.begin_of(folder))


def events_in(folder: Path) -> list[Any]:
    path = folder / ALARMS
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()] if path.is_file() else []


@pytest.fixture(scope="module")
def whole(sound_cell: tuple[WatchedCell, np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a watch that nobody kills, and beside it its log."""
    cell, rows = sound_cell
    folder = tmp_path_factory.mktemp("watches")
    path = folder / "cell.csv"
    path.write_text("\n".join(lines_of(rows)) + "\n", "utf-8")
    begun(folder / "whole", LinesSource(path, follow=False), cell, 0)
    watch(folder / "whole", file_in(path, folder / "whole"))
    assert any(each["alarm"] for each in events_in(folder / "whole"))
    return folder / "whole"


@pytest.mark.slow
def test_kills_change_nothing(
    sound_cell: tuple[WatchedCell, np.ndarray], whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell, path = sound_cell[0], whole.with_name("cell.csv")
    begun(tmp_path / "killed", LinesSource(path, follow=False), cell, 0)
    monkeypatch.setattr("warmlink.orchestration.watch.watching._SAVED", 0.0)
    draw, told = np.random.default_rng(48), list[bool]()
    while True:
        lives = float(draw.uniform(0.0, LIVES * (1 + len(told))))
        child = os.fork()
        if child == 0:
            # The kernel ends the process when so much of its own time is over, however busy the machine is.
            signal.setitimer(signal.ITIMER_VIRTUAL, lives)
            watch(tmp_path / "killed", file_in(path, tmp_path / "killed"))
            os._exit(0)
        if not os.WIFSIGNALED(os.waitpid(child, 0)[1]):
            break
        told.append(any(each["alarm"] for each in events_in(tmp_path / "killed")))
    assert len(told) > 5, "or there was nothing to be killed"
    assert not told[0], "or none was killed before the alarm"
    assert told[-1], "or none was killed after it"
    assert events_in(tmp_path / "killed") == events_in(whole)


def test_rows_that_cannot_be_read_again_are_kept_until_a_state_knows_them(
    sound_cell: tuple[WatchedCell, np.ndarray], whole: Path, tmp_path: Path
) -> None:
    """And every source gives the same alarms: in pieces from a pipe, and at once from a file."""
    cell, rows = sound_cell
    pieces = tmp_path / "pieces"
    begun(pieces, Pipe(rows, killed=True), cell, 0)
    for begin, end in pairwise((0, 1, 30, 60)):
        with pytest.raises(KilledError):
            watch(pieces, Pipe(rows[begin:end], killed=True))
    with (pieces / JOURNAL).open("a") as stream:
        stream.write("[61, [1.0, ")  # the line that the kill cut off
    assert len(rows) > 70
    watch(pieces, Pipe(rows[60:], killed=False))
    assert events_in(pieces) == events_in(whole)
    assert not (pieces / JOURNAL).read_text()
