"""Folders that one process writes, and what killed processes leave."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import WRITING, sweep, whole_file
from warmlink.orchestration.files import fresh_file, fresh_folder, locked_folder, settle, temporary_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="locks are those of POSIX")


@pytest.fixture(autouse=True)
def _in_a_hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait no second for whoever may be about to end."""
    monkeypatch.setattr("warmlink.orchestration.files.ENDING_SECONDS", 0.1)


HOLDS = """
import sys, time
from pathlib import Path
from warmlink.orchestration.files import fresh_file, fresh_folder, locked_folder, temporary_folder
with {holder} as folder:
    print(folder, flush=True)
    time.sleep(60)
"""


def holding(holder: str) -> tuple[subprocess.Popen[str], str]:
    """A process that holds a folder, and the folder's path."""
    script = HOLDS.format(holder=holder)
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    return process, process.stdout.readline().strip()


def kill(process: subprocess.Popen[str]) -> None:
    process.send_signal(signal.SIGKILL)
    process.communicate()


def test_a_second_writer_is_refused_until_the_first_is_gone(tmp_path: Path) -> None:
    folder = tmp_path / "out" / "a"
    process, _ = holding(f"locked_folder(Path({str(folder)!r}))")
    with pytest.raises(InputError, match="another warmlink is writing there"), locked_folder(folder):
        pass
    kill(process)
    with locked_folder(folder):
        (folder / "x").write_text("1")
    assert [path.name for path in folder.iterdir()] == ["x"]


def test_a_lock_on_a_new_folder_leaves_nothing_behind(tmp_path: Path) -> None:
    with locked_folder(tmp_path / "out" / "a"):
        pass
    assert not (tmp_path / "out").exists()


def test_a_folder_that_its_owner_removed_meanwhile_is_locked_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import fcntl

    folder, really, locked = tmp_path / "a", fcntl.flock, []

    def flock(handle: int, how: int) -> None:
        really(handle, how)
        if not locked:  # the one before ends between our opening of the folder and our lock on it
            folder.rmdir()
        locked.append(handle)

    monkeypatch.setattr(fcntl, "flock", flock)
    with locked_folder(folder):
        assert folder.is_dir()
        with pytest.raises(InputError, match="is writing there"), locked_folder(folder):
            pass
    assert not folder.exists()


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"), locked_folder(tmp_path / "file" / "folder"):
        pass


def test_what_a_killed_process_was_writing_is_removed_but_not_what_another_is_writing(tmp_path: Path) -> None:
    dead, left = holding(f"fresh_folder(Path({str(tmp_path)!r}))")
    alive, kept = holding(f"fresh_folder(Path({str(tmp_path)!r}))")
    kill(dead)
    assert Path(left).is_dir()
    with fresh_folder(tmp_path) as work:
        (work / "results").write_text("1")
    assert not Path(left).exists()
    assert Path(kept).is_dir()
    kill(alive)
    assert (tmp_path / "results").read_text() == "1"


def test_the_file_that_a_killed_process_was_writing_goes_but_not_what_another_is_writing(
    tmp_path: Path,
) -> None:
    dead, left = holding(f"fresh_file(Path({str(tmp_path / 'a.csv')!r}))")
    alive, kept = holding(f"fresh_file(Path({str(tmp_path / 'a.csv')!r}))")
    kill(dead)
    assert Path(left).is_file()
    with fresh_file(tmp_path / "b.csv") as scratch:
        scratch.write_text("1")
    assert not Path(left).exists()
    assert Path(kept).is_file()
    kill(alive)
    assert (tmp_path / "b.csv").read_text() == "1"


def test_a_file_that_another_process_removes_before_it_is_locked_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import fcntl

    really, locked = fcntl.flock, list[int]()

    def flock(handle: int, how: int) -> None:
        really(handle, how)
        if not locked:  # the other one takes it for what a killed process left
            (scratch,) = tmp_path.iterdir()
            scratch.unlink()
        locked.append(handle)

    monkeypatch.setattr(fcntl, "flock", flock)
    with whole_file(tmp_path / "a") as scratch:
        scratch.write_text("1")
        sweep(tmp_path, WRITING)
        assert scratch.exists()
    assert (tmp_path / "a").read_text() == "1"


def test_temporary_folders_of_killed_runs_are_removed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    dead, _ = holding("temporary_folder()")
    kill(dead)
    with temporary_folder() as folder:
        assert sorted(tmp_path.iterdir()) == [folder]
    assert list(tmp_path.iterdir()) == []


def test_a_temporary_folder_that_cannot_be_made_is_told_in_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "absent"))
    with pytest.raises(InputError, match=r"cannot be written .*TMPDIR"), temporary_folder():
        pass


def test_a_second_writer_is_told_who_is_writing(tmp_path: Path) -> None:
    process, _ = holding(f"locked_folder(Path({str(tmp_path)!r}))")
    with pytest.raises(InputError, match=r"another warmlink is writing there") as refused:
        locked_folder(tmp_path).__enter__()
    if sys.platform == "linux":
        assert f"(process {process.pid})" in str(refused.value)
    kill(process)


SWAP = """
import os, sys
from pathlib import Path
from warmlink.orchestration import files
count = int(sys.argv[1])
def counted(name):
    really = getattr(Path, name)
    def call(*given, **named):
        global count
        count -= 1
        if count < 0:
            os.kill(os.getpid(), 9)
        return really(*given, **named)
    setattr(Path, name, call)
for name in ("unlink", "rename", "replace", "mkdir", "touch", "rmdir"):
    counted(name)
folder = Path("out")
with files.fresh_folder(folder, lambda: [folder / "a", folder / "b"]) as work:
    with open(work / "a", "w") as file:
        file.write("new")
    os.mkdir(work / "below")
    with open(work / "below" / "c", "w") as file:
        file.write("new")
print(count)
"""


def test_wherever_a_process_is_killed_either_the_old_files_are_there_or_the_new_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "out"
    seen, count, ended = set(), 0, False
    while not ended:
        shutil.rmtree(out, ignore_errors=True)
        (out / "below").mkdir(parents=True)
        for name in ("a", "b", "below/c", "others"):
            (out / name).write_text("old")
        done = subprocess.run([sys.executable, "-c", SWAP, str(count)], capture_output=True, check=False)
        ended = done.returncode == 0
        # Without anything being mended, new ones never stand beside old ones that they replace.
        at_once = {name: (out / name).read_text() for name in ("a", "b") if (out / name).exists()}
        assert "new" not in at_once.values() or "b" not in at_once
        settle(out)
        found = {name: (out / name).read_text() for name in ("a", "b", "below/c") if (out / name).exists()}
        assert found in ({"a": "old", "b": "old", "below/c": "old"}, {"a": "new", "below/c": "new"})
        assert (out / "others").read_text() == "old"
        seen.add(found["a"])
        for left in out.glob(f"{WRITING}new-*"):  # was it made just now, somebody may be about to lock it
            os.utime(left, (1e9, 1e9))
        with fresh_folder(out):
            pass  # which replaces nothing, and sweeps
        assert {path.name for path in out.iterdir()} == {*found, "others", "below"} - {"below/c"}
        count += 1
    assert seen == {"old", "new"}
    assert count > 10
