"""`warmlink simulate` as a user meets it: error budget, isolation, checkpoints, pace, Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.trivial_fmu import build_trivial_fmu
from tests.orchestration.master.streamed import read_folder
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master import guard
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.model import (
    Component,
    Connection,
    DefaultExperiment,
    System,
    Value,
)
from warmlink.orchestration.system.write import write_ssp

COMMAND = [sys.executable, "-m", "warmlink.orchestration.cli", "simulate"]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    try:
        return build_trivial_fmu(tmp_path_factory.mktemp("fmu"))
    except InputError as fault:
        pytest.skip(str(fault))


@pytest.fixture(autouse=True)
def _in_a_fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def oscillator(fmu: Path, stop: float = 10.0, step: float = 0.1, **b: Value) -> Path:
    """a'' = -a from a = 1: two integrators in a loop."""
    a = Component("a", fmu, {}, {"y": 1.0, "rate": -1.0})
    parts = {"a": a, "b": Component("b", fmu, {}, dict(b))}
    wires = (Connection("a", "y", "b", "u"), Connection("b", "y", "a", "u"))
    path = Path("oscillator.ssp")
    write_ssp(System("oscillator", parts, wires, DefaultExperiment(0.0, stop, step)), path)
    return path


def called(path: Path, *options: str) -> int:
    """Exit code of the command, run in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["warmlink", "simulate", str(path), *options])
        with pytest.raises(SystemExit) as stop:
            main()
    return int(stop.value.code or 0)


def simulate(
    path: Path, *options: str, capsys: pytest.CaptureFixture[str], expected: int = 0
) -> tuple[dict[str, Any], str]:
    """Answer as JSON, and what was said beside it."""
    code = called(path, "--json", *options)
    out, err = capsys.readouterr()
    assert code == expected, err
    return json.loads(out) if out else {}, err


def test_the_error_budget_covers_the_true_error(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer, _ = simulate(oscillator(fmu, 3.0, 0.01), "--out", "o", capsys=capsys)
    table = pd.read_parquet("o/results.parquet")
    times = table["time [s]"].to_numpy()
    for name, exact in (("a.y", np.cos(times)), ("b.y", np.sin(times))):
        truth = np.max(np.abs(table[f"{name} [1]"].to_numpy() - exact))
        assert truth <= answer["outputs"][name]["coupling_error"] <= 10 * truth
    assert not Path("o/values.npy").exists()


@pytest.mark.parametrize("watch", [("--watch", "b.u", "--watch", "a.y"), ("--watch", "b.u,a.y")])
def test_watched_variables_alone_are_bounded(
    fmu: Path, watch: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    answer, _ = simulate(oscillator(fmu), *watch, capsys=capsys)
    bounded = {name for name, figures in answer["outputs"].items() if "coupling_error" in figures}
    assert bounded == {"b.u", "a.y"}
    assert {"b.y", "a.z"} <= set(answer["outputs"])


def test_a_tolerance_sets_the_step(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer, _ = simulate(
        oscillator(fmu, 1.0), "--tolerance", "1e-3", "--watch", "a.y", "--out", "o", capsys=capsys
    )
    table = pd.read_parquet("o/results.parquet")
    truth = np.max(np.abs(table["a.y [1]"].to_numpy() - np.cos(table["time [s]"].to_numpy())))
    assert truth <= answer["outputs"]["a.y"]["coupling_error"] <= 1e-3
    _, said = simulate(oscillator(fmu), "--tolerance", "0.1 um", capsys=capsys, expected=2)
    assert "--tolerance 0.1 um: fits no output" in said
    _, said = simulate(oscillator(fmu), "--tolerance", "1", "--real-time", "1", capsys=capsys, expected=2)
    assert "needs a second run" in said


def test_with_a_tolerance_a_resumed_run_goes_on_to_smaller_steps(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The checkpoint is the first attempt's; a later one begins anew."""
    options = "--tolerance=1e-3", "--watch=a.y", "--step=0.1 s", "--out=o"
    kept = "--error-budget", "--checkpoint=5", "--resume"
    found = []
    for _ in range(2):
        answer, _ = simulate(oscillator(fmu, 1.0), *options, *kept, capsys=capsys)
        assert answer["outputs"]["a.y"]["coupling_error"] <= 1e-3
        found.append(pd.read_parquet("o/results.parquet"))
    pd.testing.assert_frame_equal(*found)


def test_who_follows_an_fmu_that_samples_as_often_as_the_run_steps_is_named(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sampling = FmuStore("native").files(["TemperatureSensors"])["TemperatureSensors"]
    sensors = Component("sensors", sampling, {}, {"noise[1]": 0.1, "sample_time": 1.0})
    parts = {"sensors": sensors, "a": Component("a", fmu, {}, {})}
    wires = (Connection("sensors", "reading[1]", "a", "u"),)
    write_ssp(System("late", parts, wires, DefaultExperiment(0.0, 30.0, 1.0)), Path("late.ssp"))
    answer, said = simulate(Path("late.ssp"), "--watch", "a.u,sensors.reading[1]", capsys=capsys)
    assert answer["outputs"]["a.u"]["coupling_error"] == 0.0
    assert "a: follows steps of an FMU's own that are as long as those of the run" in said
    assert "sensors: follows" not in said
    _, said = simulate(Path("late.ssp"), "--watch", "a.u", "--step", "2 s", capsys=capsys)
    assert "follows" not in said


@pytest.mark.parametrize("option", ["--no-error-budget", "--checkpoint=5", "--real-time=100"])
def test_the_run_is_not_repeated_where_that_was_not_asked(
    fmu: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    answer, _ = simulate(oscillator(fmu, 1.0), option, capsys=capsys)
    assert not any("coupling_error" in figures for figures in answer["outputs"].values())


def test_the_table_for_people(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called(oscillator(fmu, 1.0), "--watch", "a.y") == 0
    out = capsys.readouterr().out
    assert "coupling error" in out
    assert next(line for line in out.splitlines() if "a.y" in line).split()[-1].startswith("±")


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
    _, err = simulate(path, "--isolate", "--time-limit", "2 s", capsys=capsys, expected=1)
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
    real = guard.guarded

    def guarded(work: Callable[[guard.Line | None], Result], *shown: Any) -> Result:
        result = real(work, *shown)
        return result if result.table.points.step_size > 0.06 else ends(result)

    monkeypatch.setattr(guard, "guarded", guarded)
    path = oscillator(fmu, 1.0)
    answer, err = simulate(path, "--step", "0.1 s", *options, "--out", "o", capsys=capsys, expected=1)
    assert f"stopped early: {told} in the run at half the step; what was computed up to there is kept" in err
    assert answer["outputs"]["a.y"]["coupling_error"] is None
    assert len(pd.read_csv("o/results.csv")) == 11


def test_a_pace_is_kept(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = oscillator(fmu, 4.0)
    began = time.monotonic()
    answer, _ = simulate(path, "--real-time", "4", capsys=capsys)
    assert time.monotonic() - began >= 1.0
    assert answer["largest_lag_s"] >= 0.0


def test_remarks_are_told(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # A loop of gain 4 a step: explicit stepping makes it grow.
    path = oscillator(fmu, 40.0, 2.0)
    answer, err = simulate(path, capsys=capsys)
    assert any("unstable" in remark for remark in answer["remarks"])
    assert "unstable" in err


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["--time-limit", "3 s"],
            "--time-limit: applies only to FMUs in processes of their own; add --isolate",
        ),
        (["--isolate", "--time-limit", "0 s"], "--time-limit: 0 s is not positive"),
        (["--stepping", "fast"], "--stepping fast: not known; choose auto, plain or compiled"),
        (["--stepping", "compiled", "--real-time", "1"], "goes neither with isolated slaves nor with a pace"),
        (["--real-time", "0"], "--real-time 0: not a pace"),
        (["--real-time", "nan"], "--real-time nan: not a pace"),
        (["--watch", "a.nothing"], "a.nothing: no slave has such a variable"),
        (["--stop", "1e18 s", "--step", "1 s"], "keeps at most 2 GB in memory"),
        (["--checkpoint", "0"], "checkpoints: every 0 steps is not above 0"),
        (["--checkpoint", "5", "--out", "oscillator.ssp/here"], "cannot be written"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_refused_in_one_sentence(
    fmu: Path, options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = oscillator(fmu, 1.0)
    before = sorted(Path().rglob("*"))
    _, err = simulate(path, *options, capsys=capsys, expected=2)
    assert sentence in err
    assert err.count("\n") == 1, err
    assert sorted(Path().rglob("*")) == before


def test_two_runs_do_not_write_into_one_folder(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = oscillator(fmu, 10.0, 0.01)
    options = ("--checkpoint", "10", "--out", "o")
    with subprocess.Popen(
        [*COMMAND, str(path), *options, "--real-time", "0.1"], stderr=subprocess.PIPE
    ) as first:
        while not Path("o/checkpoint").exists():
            assert first.poll() is None
            time.sleep(0.02)
        _, err = simulate(path, *options, "--resume", capsys=capsys, expected=2)
        assert "o: another warmlink is writing there" in err
        first.kill()
    simulate(path, *options, "--resume", capsys=capsys)
    assert len(read_folder(Path("o"))) == 1001


def test_a_single_fmu_is_sent_to_check(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called(fmu) == 2
    assert "is a single FMU, no system; look at it with `warmlink check" in capsys.readouterr().err
