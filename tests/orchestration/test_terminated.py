"""A command that is told to end (SIGTERM, as by docker stop, SLURM or systemd) keeps what Ctrl-C keeps."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from tests.orchestration.simulated import oscillator
from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="sends SIGTERM, and looks for processes in /proc"),
    pytest.mark.usefixtures("in_a_fresh_folder"),
]
COMMAND = [sys.executable, "-m", "warmlink.orchestration.cli"]
STUDY = """
controller = "lag"
duty_cycles = ["stop_and_go"]
[parameters]
"compensator.gain" = { min = "2 um/W", max = "8 um/W" }
[sweep]
kind = "grid"
points = 1000
"""


def children(process: int) -> list[int]:
    return [int(each) for each in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def ended(
    arguments: list[str], begun: Callable[[int], object], whole_job: bool = False
) -> subprocess.CompletedProcess[str]:
    """Tell a command to end once it has begun, by its process number; at times each of its processes."""
    with subprocess.Popen(
        [*COMMAND, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        deadline = time.monotonic() + 60
        while not begun(process.pid):
            assert process.poll() is None, process.stderr and process.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.02)
        job = [process.pid, *(children(process.pid) if whole_job else [])]
        for each in job[::-1]:
            os.kill(each, signal.SIGTERM)
        out, err = process.communicate(timeout=60)
    assert "Traceback" not in err
    return subprocess.CompletedProcess(arguments, process.returncode, out, err)


@pytest.mark.parametrize("whole_job", [False, True])
@pytest.mark.parametrize("isolate", [False, True])
def test_simulate_keeps_what_was_computed(fmu: Path, whole_job: bool, isolate: bool) -> None:
    path = oscillator(fmu, 1e5)
    options = ["--checkpoint", "100", "--no-error-budget", *(["--isolate"] if isolate else [])]
    done = ended(
        ["simulate", str(path), "--out", "o", *options], lambda _: Path("o/checkpoint").exists(), whole_job
    )
    assert done.returncode == 1, done.stderr
    assert "SIGTERM: the run ends after the present step; send it again" in done.stderr
    assert "stopped early: interrupted at" in done.stderr
    assert len(pd.read_parquet("o/results.parquet")) > 100


@pytest.mark.slow
@pytest.mark.parametrize("whole_job", [False, True])
def test_run_keeps_what_was_computed(whole_job: bool) -> None:
    try:
        FmuStore("native").files(["ThermalLink"])
    except InputError as fault:
        pytest.skip(str(fault))
    seen: list[float] = []

    def begun(process: int) -> bool:
        if children(process):
            seen.append(time.monotonic())
        return bool(seen) and time.monotonic() > seen[0] + 0.5

    arguments = ["run", "--stop", "1000 h", "--step", "10 s", "--no-report", "--out", "o"]
    done = ended(arguments, begun, whole_job)
    assert done.returncode == 1, done.stderr
    assert "stopped early: interrupted at" in done.stderr
    assert len(pd.read_parquet("o/results.parquet")) > 0
    assert json.loads(Path("o/metrics.json").read_text())["stopped"]


@pytest.mark.slow
@pytest.mark.parametrize("whole_job", [False, True])
def test_a_study_keeps_its_finished_runs(whole_job: bool) -> None:
    Path("study.toml").write_text(STUDY)
    runs = Path("o/runs.jsonl")
    arguments = ["sweep", "study.toml", "--exact", "--no-report", "--out", "o"]
    done = ended(arguments, lambda _: runs.exists() and runs.read_bytes().count(b"\n") > 2, whole_job)
    assert done.returncode == 143, done.stderr
    assert "interrupted; finished runs are kept, and the same command continues" in done.stderr
    assert runs.read_bytes().count(b"\n") > 2
    assert not Path("o/sweep.parquet").exists()


def test_a_command_without_anything_to_keep_says_so() -> None:
    code = (
        "import time\n"
        "from warmlink.orchestration import cli\n"
        "cli.app = lambda: print('begun', flush=True) or time.sleep(60)\n"
        "cli.main()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.terminate()
        _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert err == "warmlink: interrupted; there are no results\n"


def test_what_it_means_to_a_program_of_somebody_elses_is_its_own_affair() -> None:
    code = (
        "import os, signal, sys\n"
        "from warmlink.orchestration.master.slaves.under_way import interruption\n"
        "with interruption():\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "print('goes on')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (-signal.SIGTERM, "")
