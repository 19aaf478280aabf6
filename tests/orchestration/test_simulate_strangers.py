"""`warmlink simulate` on systems of strangers: other start times, names like ours, counters, no way back."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.orchestration.simulated import oscillator, simulate
from warmlink.orchestration.simulation import experiment_of, largest_step, tolerances_of
from warmlink.orchestration.system.model import DefaultExperiment, FmuPart, System

DESCRIPTION = "modelDescription.xml"


pytestmark = pytest.mark.usefixtures("in_a_fresh_folder")


def other(fmu: Path, *changes: tuple[str, str]) -> Path:
    """The trivial slave with another description."""
    target = Path("other.fmu")
    with zipfile.ZipFile(fmu) as read, zipfile.ZipFile(target, "w") as written:
        for name in read.namelist():
            content = read.read(name)
            for old, new in changes if name == DESCRIPTION else ():
                assert old.encode() in content
                content = content.replace(old.encode(), new.encode())
            written.writestr(name, content)
    return target


@pytest.mark.parametrize(("start", "stop"), [(100.0, 110.0), (-10.0, 0.0)])
def test_the_usual_step_divides_a_run_from_any_start(start: float, stop: float) -> None:
    system = System("late", {}, (), DefaultExperiment(start, stop))
    assert experiment_of(system, None, None) == pytest.approx((stop, 0.02))


@pytest.mark.parametrize(
    ("changes", "longest"),
    [
        ([('name="gain"', 'name="sampler.sample_time"')], 10.0),  # of something inside the FMU
        ([('name="label"', 'name="sample_time"')], 10.0),  # a String
        ([('name="gain"', 'name="sample_time"')], 1.0),
    ],
)
def test_what_is_named_like_a_sample_time_may_be_none(
    fmu: Path, changes: list[tuple[str, str]], longest: float
) -> None:
    system = System("s", {"a": FmuPart("a", other(fmu, *changes))})
    assert largest_step(system, 10.0, 10.0) == longest


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_a_sample_time_that_is_none_does_not_set_the_step(fmu: Path, value: float) -> None:
    made = other(fmu, ('name="gain"', 'name="sample_time"'))
    system = System("s", {"a": FmuPart("a", made, {}, {"sample_time": value})})
    assert largest_step(system, 10.0, 5.0) == 5.0


def test_a_tolerance_is_one_of_real_outputs(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A slave that counts its steps counts others than one that took smaller steps."""
    path = oscillator(fmu, 1.0)
    answer, said = simulate(path, "--tolerance", "1e-3", "--out", "o", capsys=capsys)
    table = pd.read_parquet("o/results.parquet")
    truth = np.max(np.abs(table["a.y [1]"].to_numpy() - np.cos(table["time [s]"].to_numpy())))
    assert truth <= answer["outputs"]["a.y"]["coupling_error"] <= 1e-3
    assert said == ""
    assert set(tolerances_of(System("s", {"a": FmuPart("a", fmu)}), "1e-3", None)) == {"a.y", "a.z"}


def test_without_a_way_back_a_run_beyond_its_tolerance_is_kept_and_told(
    fmu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = other(fmu, ('canGetAndSetFMUstate="true"', ""), ('canSerializeFMUstate="true"', ""))
    answer, said = simulate(
        oscillator(made, 1.0), "--tolerance", "1e-6", "--watch", "a.y", "--out", "o", capsys=capsys
    )
    assert answer["outputs"]["a.y"]["coupling_error"] > 1e-6
    assert len(pd.read_parquet("o/results.parquet")) == 501
    told = [
        "no smaller steps were tried: a, b: cannot restore its state, which step doubling needs to repeat a "
        "step; choose a fixed step",
        "a.y: the coupling error is not within the tolerance; allow more, or give a smaller --step",
    ]
    assert answer["remarks"] == told
    assert all(each in said for each in told)
