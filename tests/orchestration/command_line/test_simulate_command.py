"""`warmlink simulate` as a user meets it: error budget, tolerance, pace, remarks, refusals."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.orchestration.simulated import called, oscillator, simulate
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.model import (
    Connection,
    DefaultExperiment,
    FmuPart,
    System,
)
from warmlink.orchestration.system.write import write_ssp

pytestmark = pytest.mark.usefixtures("in_a_fresh_folder")


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
    assert "--tolerance 0.1 um: fits no output; give a value above 0 in the unit of one" in said
    both = "--tolerance", "0.1 um", "--watch", "a.y"
    _, said = simulate(oscillator(fmu), *both, capsys=capsys, expected=2)
    assert "--tolerance of a.y: um does not convert to 1" in said
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
    sensors = FmuPart("sensors", sampling, {}, {"noise[1]": 0.1, "sample_time": 1.0})
    parts = {"sensors": sensors, "a": FmuPart("a", fmu, {}, {})}
    wires = (Connection("sensors", "reading[1]", "a", "u"),)
    write_ssp(System("late", parts, wires, DefaultExperiment(0.0, 30.0, 1.0)), Path("late.ssp"))
    answer, said = simulate(Path("late.ssp"), "--watch", "a.u,sensors.reading[1]", capsys=capsys)
    assert answer["outputs"]["a.u"]["coupling_error"] == 0.0
    told = "a: follows steps of an FMU's own that are at least as long as those of the run"
    assert told in said
    assert any(told in each for each in answer["remarks"])
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
        (["--step", "1e-320 s"], "communication step size: 9.99989e-321 s is too short for 1 s"),
        (["--checkpoint", "0"], "--checkpoint 0: not a number of communication steps; give a whole number"),
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


def test_a_single_fmu_runs(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called(fmu) == 2
    assert 'the system proposes no stop time; give one, as --stop "1 h"' in capsys.readouterr().err
    assert called(fmu, "--stop", "10 s") == 0
