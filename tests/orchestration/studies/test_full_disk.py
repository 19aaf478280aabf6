"""A disk that is full at the first, the second, ... the last write of a command: nothing finished is lost."""

import errno
import io
import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("optuna")
import sqlalchemy

from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.packaging.native.library import loaded
from warmlink.orchestration.cli import main
from warmlink.orchestration.studies import session
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.workers import FmuSet

from .test_workers import short

really_mkdir = os.mkdir


STRIDE = 1 if "WARMLINK_EVERY_WRITE" in os.environ else 9
"""Every ninth write, from another one for each command, unless the environment asks for all."""


class Disk:
    """A disk that counts what is written into a folder, and is full at one write and all that follow.

    A write is the making of a folder or a file, each write to it, its closing after that, a renaming, and a
    commit of SQLite.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, only: str = "") -> None:
        self.folder, self.only, self.full_at, self.count = str(folder), only, 0, 0
        really_open = io.open

        def opened(file: Any, mode: str = "r", *rest: Any, **more: Any) -> Any:
            inside = self._holds(file) and any(letter in mode for letter in "wax+")
            if inside:
                self.write()
            stream = really_open(file, mode, *rest, **more)
            return Written(stream, self) if inside else stream

        monkeypatch.setattr(io, "open", opened)
        for name in ("mkdir", "replace"):
            monkeypatch.setattr(os, name, self._counted(getattr(os, name)))
        sqlalchemy.event.listen(sqlalchemy.Engine, "commit", self._commit)

    def write(self) -> None:
        self.count += 1
        if self.full_at and self.count >= self.full_at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def close(self) -> None:
        sqlalchemy.event.remove(sqlalchemy.Engine, "commit", self._commit)

    def _holds(self, file: Any) -> bool:
        path = os.path.abspath(file) if isinstance(file, str | os.PathLike) else ""  # noqa: PTH100
        return path.startswith(self.folder) and path.endswith(self.only)

    def _counted(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def counted(path: Any, *rest: Any, **more: Any) -> Any:
            if self._holds(path) and not (function is really_mkdir and os.path.isdir(path)):  # noqa: PTH112
                self.write()
            return function(path, *rest, **more)

        return counted

    def _commit(self, connection: Any) -> None:
        if self.only:
            return
        try:
            self.write()
        except OSError:
            full = sqlite3.OperationalError("database or disk is full")
            raise sqlalchemy.exc.OperationalError("COMMIT", None, full) from None


class Written:
    """A file that is written to a disk."""

    def __init__(self, stream: Any, disk: Disk) -> None:
        self._stream, self._disk, self._changed = stream, disk, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def __enter__(self) -> "Written":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def write(self, content: Any) -> Any:
        self._disk.write()
        self._changed = True
        return self._stream.write(content)

    def close(self) -> None:
        self._stream.close()
        if self._changed:
            self._disk.write()


class Formula:
    """Workers for whom a run's error is a formula, so that a command takes no time."""

    done = 0

    def __init__(self, fmus: FmuSet, jobs: int) -> None:
        pass

    def __enter__(self) -> "Formula":
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        for place, case in enumerate(cases):
            Formula.done += 1
            error = 1 + 1e6 * float(case.values.get("compensator", {}).get("gain", 1e-5)) + len(case.label[1])
            yield place, Outcome(error, error / 2, error / 3, None, 5.0, 2.0, 0.01, 0.01, 0.1)


COMMANDS = {
    "tune": (["tune", "study.toml", "--exact", "--trials", "3"], ["trials.csv", "winner.ssv"]),
    "sweep": (["sweep", "study.toml", "--exact"], ["sweep.parquet"]),
    "compare": (
        ["compare", "--exact", "--duty-cycles", "work.toml,pause.toml", "--mismatch", "nominal"],
        ["compare.csv"],
    ),
}


@pytest.fixture
def run(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[list[str]], tuple[int, str]]:
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(text.replace("points = 3", "points = 2"))
    monkeypatch.chdir(folder)
    monkeypatch.setattr(session, "LocalWorkers", Formula)

    def given(arguments: list[str]) -> tuple[int, str]:
        monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        return int(stop.value.code or 0), capsys.readouterr().err

    return given


@pytest.fixture
def disk(folder: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[Disk]:
    (folder / "out").mkdir()
    disk = Disk(folder / "out", monkeypatch, getattr(request, "param", ""))
    yield disk
    disk.close()


def lines(folder: Path) -> int:
    ledger = folder / "runs.jsonl"
    return ledger.read_bytes().count(b"\n") if ledger.is_file() else 0


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_disk_that_is_full_at_any_write_costs_nothing_that_is_finished(
    name: str, folder: Path, run: Callable[[list[str]], tuple[int, str]], disk: Disk
) -> None:
    arguments, tables = COMMANDS[name]
    arguments = [*arguments, "--no-report", "--out"]
    Formula.done = 0
    assert run([*arguments, "out/whole"])[0] == 0
    writes, runs = disk.count, Formula.done
    whole = [(folder / "out" / "whole" / table).read_bytes() for table in tables]
    assert writes > 15
    for k in range(1 + len(name) % STRIDE, writes + 1, STRIDE):
        out = folder / "out" / str(k)
        disk.count, disk.full_at, Formula.done = 0, k, 0
        code, said = run([*arguments, f"out/{k}"])
        kept = lines(out)
        assert code == 2, (k, writes)
        assert said.count("\n") == 1, said
        assert "no space left" in said.lower() or "disk is full" in said
        # What is lost is at most the run that could not be written down.
        assert kept >= Formula.done - 1
        disk.full_at, Formula.done = 0, 0
        assert run([*arguments, f"out/{k}"])[0] == 0
        assert Formula.done == runs - kept
        assert [(out / table).read_bytes() for table in tables] == whole
        assert not list(out.glob(".*"))


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("disk", ["report.html"], indirect=True)
def test_a_disk_that_is_full_at_the_report_costs_the_results_of_that_time(
    name: str, folder: Path, run: Callable[[list[str]], tuple[int, str]], disk: Disk
) -> None:
    arguments, tables = COMMANDS[name]
    assert run([*arguments, "--out", "out/a"])[0] == 0
    for k in range(1, disk.count + 1):
        disk.count, disk.full_at = 0, k
        code, said = run([*arguments, "--out", "out/b"])
        assert code == 2
        assert "every finished run is kept, and the same command writes the results" in said
        assert lines(folder / "out" / "b") > 0
        disk.full_at = 0
    assert run([*arguments, "--out", "out/b"])[0] == 0
    for table in tables:
        assert (folder / "out" / "b" / table).read_bytes() == (folder / "out" / "a" / table).read_bytes()


class NoRoom(FmuSet):
    """FMUs that no disk takes any more."""

    def files(self) -> dict[str, Path]:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "ThermalLink.fmu")


class NoRoomToUnpack(FmuSet):
    """FMUs that no disk takes any more once they are unpacked."""

    @property
    def unpacked(self) -> Path:
        raise NoRoomError("ThermalLink.fmu: cannot be unpacked into unpacked (No space left on device)")


def test_a_worker_without_disk_ends_the_study_rather_than_the_run(folder: Path) -> None:
    for fmus, failed in ((NoRoom, "written"), (NoRoomToUnpack, "unpacked into unpacked")):
        said = rf"ThermalLink\.fmu: cannot be {failed} \(No space left on device\).*runs are kept"
        with LocalWorkers(fmus("native", {}), 1) as workers, pytest.raises(NoRoomError, match=said):
            list(workers.run([short(folder)]))


def test_a_library_for_which_there_is_no_room_leaves_nothing_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker died of it at each attempt, without a word, and its runs were recorded as the cause."""

    def full(path: Path, content: bytes) -> None:
        path.touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"No space left on device.*name another folder in TMPDIR"):
        loaded(b"a library")
    assert list(tmp_path.iterdir()) == []
