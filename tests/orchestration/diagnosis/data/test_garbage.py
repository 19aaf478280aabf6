"""Garbage gets a clear sentence or a right answer, never a confident wrong one."""

from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

Columns = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def clean() -> Columns:
    return hide({}, seed=30)


@pytest.fixture(scope="module")
def few(clean: Columns) -> Columns:
    """Rows enough to see that nothing explains what is far beyond any noise."""
    return {name: values[::3] for name, values in clean.items()}


def diagnosed(folder: Path, columns: Columns) -> str:
    path = folder / "garbage.csv"
    write_csv(columns, path)
    return diagnose_experiment(read([path])).verdict


def test_a_dead_channel_is_refused(tmp_path: Path, clean: Columns) -> None:
    columns = {**clean, "tip_temperature [degC]": np.full(clean["time [s]"].size, 22.0)}
    with pytest.raises(InputError, match="never changes"):
        diagnosed(tmp_path, columns)


@pytest.mark.slow
def test_swapped_temperatures_are_not_explained(tmp_path: Path, few: Columns) -> None:
    a, b = "winding_temperature [degC]", "tip_temperature [degC]"
    assert diagnosed(tmp_path, {**few, a: few[b], b: few[a]}) == "unknown"


@pytest.mark.slow
def test_shuffled_inputs_are_not_explained(tmp_path: Path, few: Columns) -> None:
    a, b = "speed [rad/s]", "torque [N.m]"
    assert diagnosed(tmp_path, {**few, a: few[b], b: few[a]}) == "unknown"


@pytest.mark.parametrize("every", [1, 3, 6, 12])
def test_shuffled_rows_are_refused(tmp_path: Path, clean: Columns, every: int) -> None:
    order = np.random.default_rng(every).permutation(clean["time [s]"].size)
    columns = {n: (v if "time" in n else v[order])[::every] for n, v in clean.items()}
    with pytest.raises(InputError, match=r"jumps from row to row .* put the rows in order of time"):
        diagnosed(tmp_path, columns)


@pytest.mark.parametrize("header", ["elongation [um]", "base_temperature [degC]"])
def test_a_column_that_is_written_more_often_than_sampled_is_no_late_sensor(
    tmp_path: Path, clean: Columns, header: str
) -> None:
    held = np.repeat(clean[header][::6], 6)[: clean[header].size]
    write_csv({**clean, header: held}, tmp_path / "held.csv")
    experiment = read([tmp_path / "held.csv"])
    assert "600 of 720 values" in experiment.remarks[-1]
    assert diagnose_experiment(experiment).verdict == "adequate"


@pytest.mark.slow
def test_fahrenheit_called_celsius_is_not_explained(tmp_path: Path, few: Columns) -> None:
    columns = {
        name: 32 + 1.8 * v if name.endswith("temperature [degC]") and "pad" not in name else v
        for name, v in few.items()
    }
    assert diagnosed(tmp_path, columns) == "unknown"


@pytest.mark.slow
def test_millimetres_called_micrometres_are_not_explained(tmp_path: Path, few: Columns) -> None:
    assert diagnosed(tmp_path, {**few, "elongation [um]": few["elongation [um]"] / 1000}) == "unknown"


def test_all_empty_is_refused(tmp_path: Path, clean: Columns) -> None:
    inputs = ("time", "speed", "torque", "pad", "ambient")
    columns = {n: v if n.startswith(inputs) else np.full(v.size, np.nan) for n, v in clean.items()}
    with pytest.raises(InputError, match="at least 20"):
        diagnosed(tmp_path, columns)


@pytest.mark.parametrize("span", [210.0, 60.0, 15.0, 1.0])
def test_too_short_a_run_is_refused(tmp_path: Path, clean: Columns, span: float) -> None:
    """More rows than are asked for, but not once those that follow too fast are averaged."""
    rows = 21 if span > 100 else 721
    columns = {n: np.linspace(0, span, rows) if "time" in n else v[:rows] for n, v in clean.items()}
    with pytest.raises(InputError, match="at least 16 are needed, so give a longer run"):
        diagnosed(tmp_path, columns)


def test_a_column_of_few_readings_is_no_finding(tmp_path: Path, clean: Columns) -> None:
    """Eleven readings say little about their noise, and nothing against the model."""
    tip = "tip_temperature [degC]"
    few = np.where(np.arange(clean[tip].size) % 48 == 0, clean[tip], np.nan)
    assert diagnosed(tmp_path, {**clean, tip: few}) == "adequate"
