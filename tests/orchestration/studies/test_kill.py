"""Killed or interrupted: resumed, the table is the same, and no process is left behind."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

import pytest

from tests.warm import ran

pytest.importorskip("optuna")
psutil = pytest.importorskip("psutil")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")]

KILLS = int(os.environ.get("WARMLINK_KILLS", "1"))
"""How often each study is killed at a moment drawn at random."""

COMPARE = (
    "compare --controllers lag,analytic --duty-cycles work.toml,pause.toml --mismatch nominal,draw_1,draw_2"
)
STUDIES = {
    "tune": ("tune study.toml", "trials.csv"),
    "sweep": ("sweep study.toml", "sweep.parquet"),
    "compare": (COMPARE, "compare.csv"),
}


@pytest.fixture
def _longer(folder: Path) -> None:
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(
        text.replace("points = 3", "points = 4").replace("trials = 14", "trials = 8")
    )


PYTHON = [sys.executable, "-m", "warmlink.orchestration.cli"]


def command(text: str, out: str) -> list[str]:
    return [*text.split(), "--no-report", "--out", out]


@contextmanager
def begun(folder: Path, text: str, out: str) -> Iterator[subprocess.Popen[str]]:
    """A command that runs; afterwards neither it nor a process of its is there any more."""
    process = subprocess.Popen(
        [*PYTHON, *command(text, out)], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    seen: set[psutil.Process] = set()
    try:
        yield process
        if process.poll() is None:
            seen = descendants(process)
            process.kill()
    finally:
        process.kill()
        process.communicate()
        assert psutil.wait_procs(seen, timeout=10)[1] == []


def descendants(process: subprocess.Popen[str]) -> set[psutil.Process]:
    return set(psutil.Process(process.pid).children(recursive=True))


def workers_of(process: subprocess.Popen[str]) -> list[psutil.Process]:
    return [child for child in descendants(process) if "spawn_main" in " ".join(child.cmdline())]


def finished_runs(folder: Path) -> int:
    ledger = folder / "runs.jsonl"
    return ledger.read_bytes().count(b"\n") if ledger.is_file() else 0


def wait_for_runs(folder: Path, count: int, process: subprocess.Popen[str]) -> None:
    give_up = time.monotonic() + 120
    while finished_runs(folder) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < give_up
        time.sleep(0.005)


def finished(folder: Path, text: str, out: str) -> str:
    with chdir(folder):
        done = ran(*command(text, out))
    assert done.returncode == 0, done.stderr
    return done.stdout.partition(out)[0]


@pytest.mark.usefixtures("_longer")
@pytest.mark.parametrize("name", STUDIES)
def test_a_study_killed_at_random_goes_on_to_the_same_table(folder: Path, name: str) -> None:
    text, table = STUDIES[name]
    said = finished(folder, text, "whole")
    runs = finished_runs(folder / "whole")
    draw, kills = random.Random(8), 0
    whole = (folder / "whole" / table).read_bytes()
    while kills < KILLS:
        before = finished_runs(folder / "part")
        with begun(folder, text, "part") as process:
            # Counted in runs, since the time that a study takes depends on what is built already.
            wait_for_runs(folder / "part", draw.randint(before, runs), process)
            try:
                # Where only the results are left to be written, it is let come to that, and often to its end.
                process.wait(draw.uniform(0.0, 0.3 if before < runs else 3.0))
            except subprocess.TimeoutExpired:
                kills += 1
                continue
        # It came to its end in spite of the kills before: the next ones have another one to disturb.
        assert (folder / "part" / table).read_bytes() == whole
        shutil.rmtree(folder / "part")
    assert finished(folder, text, "part") == said
    assert (folder / "part" / table).read_bytes() == whole


def test_a_worker_that_is_killed_costs_nothing(folder: Path) -> None:
    text, table = STUDIES["sweep"]
    text += " --exact"
    finished(folder, text, "whole")
    with begun(folder, text, "part") as process:
        wait_for_runs(folder / "part", 3, process)
        workers_of(process)[0].kill()
        assert process.wait(120) == 0
    assert (folder / "part" / table).read_bytes() == (folder / "whole" / table).read_bytes()


@pytest.mark.parametrize("name", ["tune", "compare"])
def test_ctrl_c_ends_in_order_and_keeps_what_is_finished(folder: Path, name: str) -> None:
    text, _ = STUDIES[name]
    with begun(folder, f"{text} --exact", "part") as process:
        wait_for_runs(folder / "part", 3, process)
        children = descendants(process)
        # As at a terminal, it goes to all of them that are still there.
        for each in [psutil.Process(process.pid), *children]:
            with suppress(psutil.NoSuchProcess):
                each.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        assert psutil.wait_procs(children, timeout=10)[1] == []
    assert process.returncode == 130
    lines = [line for line in said.splitlines() if "once for this version" not in line]  # with a cold cache
    assert lines == ["warmlink: interrupted; finished runs are kept, and the same command continues"]
    assert finished_runs(folder / "part") >= 3


def test_ctrl_c_pressed_twice_ends_at_once(folder: Path) -> None:
    with begun(folder, f"{COMPARE} --exact", "part") as process:
        wait_for_runs(folder / "part", 2, process)
        children = descendants(process)
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        assert psutil.wait_procs(children, timeout=10)[1] == []
    assert process.returncode in (130, -signal.SIGINT)
