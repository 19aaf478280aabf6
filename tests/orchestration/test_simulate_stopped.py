"""Runs of `warmlink simulate` that end early or go on: crashes, time limits, Ctrl-C, checkpoints."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.orchestration.master.streamed import read_folder
from tests.orchestration.simulated import oscillator, simulate
from warmlink.orchestration import simulation
from warmlink.orchestration.master import guard
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves.slave import SlaveError

COMMAND = [sys.executable, "-m", "warmlink.orchestration.cli", "simulate"]


pytestmark = pytest.mark.usefixtures("in_a_fresh_folder")


def test_an_fmu_that_crashes_is_named_and_the_results_are_kept(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = oscillator(fmu, fail_at=0.45, fail_status=5)
    answer, err = simulate(path, "--isolate", "--out", "o", capsys=capsys, expected=1)
    assert "stopped early: b: crash at 0.4 s" in err
    assert answer["stop_time_s"] == pytest.approx(0.4)
    assert len(pd.read_csv("o/results.csv")) == 5
    assert not any("coupling_error" in figures for figures in answer["outputs"].values())


def test_a_step_that_never_returns_meets_the_time_limit(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = oscillator(fmu, fail_at=0.45, fail_status=6)
    _, err = simulate(path, "--isolate", "--time-limit", "1 s", capsys=capsys, expected=1)
    assert "b: time limit at 0.4 s" in err


def interrupted(path: Path, folder: str, *options: str) -> subprocess.CompletedProcess[str]:
    """Run in a process of its own and press Ctrl-C once it has come somewhere."""
    with subprocess.Popen(
        [*COMMAND, str(path), "--out", folder, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        deadline = time.monotonic() + 60
        while not (Path(folder) / "checkpoint").exists():
            assert process.poll() is None, process.stderr
            assert time.monotonic() < deadline
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    return subprocess.CompletedProcess([], process.returncode, out, err)


@pytest.mark.skipif(os.name == "nt", reason="needs a shell of POSIX")
@pytest.mark.parametrize("closed", ["2>&-", "<&- >&- 2>&-"])
def test_nobody_has_to_listen(fmu: Path, closed: str) -> None:
    """Files would else get the numbers of the streams that the caller has closed, and be written to."""
    command = shlex.join([*COMMAND, str(oscillator(fmu, 1.0)), "--out", "o", "--isolate"])
    assert subprocess.run(["sh", "-c", f"{command} {closed}"], check=False).returncode == 0
    assert len(pd.read_parquet("o/results.parquet")) == 11


@pytest.mark.skipif(os.name == "nt", reason="sends SIGINT")
def test_ctrl_c_leaves_results_that_a_resumed_run_completes_bit_by_bit(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # 20 s at this pace: long enough for Ctrl-C to hit it on any machine.
    path = oscillator(fmu, 20.0, 0.01)
    stopped = interrupted(path, "o", "--checkpoint", "50", "--real-time", "1")
    assert stopped.returncode == 1, stopped.stderr
    assert "stopped early: interrupted at" in stopped.stderr
    assert "Traceback" not in stopped.stderr
    part = len(read_folder(Path("o")))
    assert 50 <= part < 2001
    assert len(pd.read_parquet("o/results.parquet")) == part
    simulate(path, "--out", "o", "--checkpoint", "50", "--resume", capsys=capsys)
    simulate(path, "--out", "whole", "--no-error-budget", capsys=capsys)
    for name in ("results.csv", "results.parquet"):
        assert (Path("o") / name).read_bytes() == (Path("whole") / name).read_bytes()


def test_a_refused_resume_leaves_the_folder_as_it_was(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = oscillator(fmu, 1.0)
    simulate(path, "--out", "o", "--checkpoint", "5", capsys=capsys)
    before = {p.name: p.read_bytes() for p in Path("o").iterdir()}
    _, err = simulate(path, "--out", "o", "--resume", "--step", "0.2 s", capsys=capsys, expected=2)
    assert "belongs to another run" in err
    assert {p.name: p.read_bytes() for p in Path("o").iterdir()} == before
    Path("o/values.npy").unlink()
    _, err = simulate(path, "--out", "o", "--resume", capsys=capsys, expected=2)
    assert "lacks values that the checkpoint beside it counts on" in err


def test_a_new_run_forgets_an_old_checkpoint(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = oscillator(fmu, 1.0)
    simulate(path, "--out", "o", "--checkpoint", "5", capsys=capsys)
    simulate(path, "--out", "o", "--checkpoint", "100", "--step", "0.2 s", capsys=capsys)
    assert not Path("o/checkpoint").exists()
    assert len(read_folder(Path("o"))) == 6


def fails(result: Result) -> Result:
    raise SlaveError("b", "error", 0.0, "refuses this step")


def is_interrupted(result: Result) -> Result:
    return replace(result, status="stopped", reason="interrupted at 0.5 s")


@pytest.mark.parametrize(
    ("ends", "told"),
    [(fails, "b: error at 0 s: refuses this step"), (is_interrupted, "interrupted at 0.5 s")],
)
@pytest.mark.parametrize("options", [(), ("--tolerance", "1e-9")], ids=["bounded", "with a tolerance"])
def test_a_second_run_that_ends_early_costs_the_bounds_alone(
    fmu: Path,
    ends: Callable[[Result], Result],
    told: str,
    options: Sequence[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = simulation.guarded

    def guarded(work: Callable[[guard.Line | None], Result], *shown: Any) -> Result:
        result = real(work, *shown)
        return result if result.table.points.step_size > 0.06 else ends(result)

    monkeypatch.setattr(simulation, "guarded", guarded)
    path = oscillator(fmu, 1.0)
    # Without a tolerance, what half the step is refused for is no fault of the run that is kept.
    finished = ends is fails and not options
    answer, err = simulate(
        path, "--step", "0.1 s", *options, "--out", "o", capsys=capsys, expected=0 if finished else 1
    )
    if finished:
        assert f"the coupling error is not bounded, for the run at half the step failed: {told}" in err
        assert answer["stopped"] is None
    else:
        assert f"stopped early: {told} in the run at half the step; what was computed up to there" in err
    assert answer["outputs"]["a.y"]["coupling_error"] is None
    assert len(pd.read_csv("o/results.csv")) == 11


def test_two_runs_do_not_write_into_one_folder(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = oscillator(fmu, 10.0, 0.01)
    options = ("--checkpoint", "10", "--out", "o")
    with subprocess.Popen(
        [*COMMAND, str(path), *options, "--real-time", "0.5"], stderr=subprocess.PIPE
    ) as first:
        while not Path("o/checkpoint").exists():
            assert first.poll() is None
            time.sleep(0.02)
        _, err = simulate(path, *options, "--resume", capsys=capsys, expected=2)
        assert "o: another warmlink is writing there" in err
        first.kill()
    simulate(path, *options, "--resume", capsys=capsys)
    assert len(read_folder(Path("o"))) == 1001
