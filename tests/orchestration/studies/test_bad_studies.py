"""Bad studies end in one sentence and exit code 2 before anything runs, with nothing left behind."""

import logging
import os
import sqlite3
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from tests.command import refused
from warmlink.fmus.files import lock, unlock
from warmlink.orchestration.cli import main
from warmlink.orchestration.files import fresh_folder, locked_folder
from warmlink.orchestration.studies.workers import FmuSet

COMPARE = ["compare", "--controllers", "lag", "--duty-cycles", "work.toml"]


@pytest.fixture(autouse=True)
def _in_the_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    text = (folder / "study.toml").read_text()
    bad = {
        "unknown": text.replace("compensator.gain", "compensator.gian"),
        "empty": text.replace('max = "8 um/W"', 'max = "2 um/W"'),
        "nan": text.replace("at_most = 0.08", "at_most = nan"),
        "broken": "title = ",
    }
    for name, content in bad.items():
        (folder / f"{name}.toml").write_text(content)


@pytest.mark.parametrize("command", ["tune", "sweep"])
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["absent.toml"], "absent.toml: no such study"),
        (["broken.toml"], "not readable as TOML"),
        (["unknown.toml"], "did you mean gain"),
        (["empty.toml"], "nothing lies between"),
        (["nan.toml"], "nan is no bound"),
        (["study.toml", "--jobs", "0"], "--jobs 0"),
        (["study.toml", "--fmus", "wasm"], "--fmus wasm"),
        (["study.toml", "--scheduler", "tcp://127.0.0.1:9"], "no Dask scheduler answers there"),
        (["study.toml", "--scheduler", "nonsense"], "no Dask scheduler answers there"),
        (["study.toml", "--out", "study.toml/here"], "cannot be written"),
    ],
)
def test_a_bad_study_is_refused(
    command: str,
    arguments: list[str],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("warmlink.orchestration.studies.processes.CONNECT_TIMEOUT_S", 0.3)
    assert sentence in refused([command, *arguments], capsys, monkeypatch)


def test_what_dask_says_of_itself_is_not_shown(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")

    def slow(*given: object, **more: object) -> None:
        for name in ("distributed.core", "distributed.client", "distributed.comm.tcp", "tornado.application"):
            logging.getLogger(name).error("Event loop was unresponsive for 3 s")
        raise OSError("timed out")

    monkeypatch.setattr(distributed, "Client", slow)
    told = refused(["sweep", "study.toml", "--scheduler", "tcp://127.0.0.1:9"], capsys, monkeypatch)
    assert "no Dask scheduler answers there" in told


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--controllers", "magic"], "magic: no such controller"),
        (["--duty-cycles", "nothing"], "nothing: no such"),
        (["--duty-cycles", ","], "--duty-cycles: names none"),
        (["--mismatch", "nothing"], "nothing: no such mismatch"),
        (["--mismatch", ","], "--mismatch: names none"),
        (["--with", "mine.py:MyLaw"], "there is no file"),
        (["--with", "mine.py"], "names no law"),
        (["--jobs", "0"], "--jobs 0"),
    ],
)
def test_a_bad_comparison_is_refused(
    arguments: list[str],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert sentence in refused([*COMPARE, *arguments], capsys, monkeypatch)


def test_a_locked_storage_and_a_busy_folder_are_refused(
    folder: Path, fmus: FmuSet, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.studies.storage.LOCK_TIMEOUT_S", 0.1)
    monkeypatch.setattr("warmlink.orchestration.files.ENDING_SECONDS", 0.1)
    with locked_folder(folder / "busy"):
        for command in (["tune", "study.toml"], ["sweep", "study.toml"], COMPARE):
            assert "busy: another warmlink is writing there" in refused(
                [*command, "--out", "busy"], capsys, monkeypatch
            )
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(text.replace("[tune]", '[tune]\nstorage = "sqlite:///locked.db"'))
    other = sqlite3.connect("locked.db")
    other.execute("CREATE TABLE held (x)")
    other.execute("BEGIN EXCLUSIVE")
    try:
        assert "locked" in refused(["tune", "study.toml"], capsys, monkeypatch)
    finally:
        other.close()


@pytest.mark.parametrize("command", [["tune", "study.toml"], ["sweep", "study.toml"], COMPARE])
@pytest.mark.parametrize("jobs", ["0", "-3", "1000000"])
def test_a_bad_number_of_processes_is_refused_before_fmus_are_built(
    command: list[str],
    jobs: str,
    tmp_path_factory: pytest.TempPathFactory,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cache = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("WARMLINK_CACHE", str(cache))
    assert f"--jobs {jobs}: not a number of processes" in refused(
        [*command, "--jobs", jobs], capsys, monkeypatch
    )
    assert not list(cache.rglob("*.fmu"))


def test_a_scheduler_that_is_not_there_is_refused_before_fmus_are_built(
    tmp_path_factory: pytest.TempPathFactory,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("warmlink.orchestration.studies.processes.CONNECT_TIMEOUT_S", 0.3)
    cache = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("WARMLINK_CACHE", str(cache))
    told = refused(["sweep", "study.toml", "--scheduler", "tcp://127.0.0.1:9"], capsys, monkeypatch)
    assert "no Dask scheduler answers there" in told
    assert not list(cache.rglob("*.fmu"))


@pytest.mark.skipif(os.name == "nt", reason="has no such locks")
def test_the_folder_is_held_until_the_results_are_in_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    free: list[bool] = []

    def watched(out: Path, *how: Any) -> AbstractContextManager[Path]:
        handle, nobody = lock(out)
        unlock(handle)
        free.append(nobody)
        return fresh_folder(out, *how)

    monkeypatch.setattr("warmlink.orchestration.results.fresh_folder", watched)
    for command in (["tune", "study.toml", "--trials", "1"], ["sweep", "study.toml"], COMPARE):
        monkeypatch.setattr("sys.argv", ["warmlink", *command, "--no-report", "--out", command[0]])
        with pytest.raises(SystemExit) as stop:
            main()
        assert stop.value.code == 0, capsys.readouterr().err
    assert free == [False] * 4  # a table of trials while they run, too
    for command, file in (("tune", "trials.csv"), ("sweep", "sweep.parquet"), ("compare", "compare.csv")):
        assert Path(command, file).is_file()
