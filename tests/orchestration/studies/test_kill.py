"""SIGKILL of the main process and of a worker, in the middle: resumed, the table is the same."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("optuna")
psutil = pytest.importorskip("psutil")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX")]


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "warmlink.orchestration.cli", *arguments, "--no-report"]


def begun(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(command(*arguments), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def wait_for_runs(folder: Path, count: int, process: subprocess.Popen[bytes]) -> None:
    ledger = folder / "runs.jsonl"
    give_up = time.monotonic() + 120
    while not ledger.is_file() or ledger.read_bytes().count(b"\n") < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < give_up
        time.sleep(0.005)


def pool_of(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def finished(folder: Path, *arguments: str) -> None:
    done = subprocess.run(command(*arguments), cwd=folder, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("name", "table"), [("tune", "trials.csv"), ("sweep", "sweep.parquet")])
def test_a_killed_study_goes_on_to_the_same_table(folder: Path, name: str, table: str) -> None:
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(
        text.replace("points = 3", "points = 6").replace('"10 min"', '"20 min"')
    )
    finished(folder, name, "study.toml", "--out", "whole", "--jobs", "1")
    whole = (folder / "whole" / table).read_bytes()

    for runs in (4, 19) if name == "tune" else (9,):
        process = begun(folder, name, "study.toml", "--out", "part", "--jobs", "2")
        wait_for_runs(folder / "part", runs, process)
        if runs == 4:
            pool_of(process)[0].kill()
            wait_for_runs(folder / "part", runs + 3, process)
        orphans = pool_of(process)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        # No worker outlives its parent.
        assert psutil.wait_procs(orphans, timeout=10)[1] == []
        assert not (folder / "part" / table).exists()
    finished(folder, name, "study.toml", "--out", "part", "--jobs", "1")
    assert (folder / "part" / table).read_bytes() == whole
