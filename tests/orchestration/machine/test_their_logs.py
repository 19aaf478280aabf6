"""Logs of machines that nobody here knows: laws are learnt from them, and judged on them, by their roles."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import warmlink as wl
from tests.orchestration.machine.strangers import machine
from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import main
from warmlink.orchestration.replay.compare import Replayed
from warmlink.orchestration.replay.learn import LearntLaw

COLUMNS = {
    "gantry": {
        "speed [rad/s]": "duty.speed",
        "torque [N.m]": "duty.torque",
        "ambient_temperature [K]": "duty.ambient_temperature",
        "base_temperature [K]": "x_link.base_temperature",
        "tip_temperature [K]": "y_link.tip_temperature",
        "x_link.elongation [m]": "x_link.elongation",
        "y_link.elongation [m]": "y_link.elongation",
    },
    "spindle": {
        "speed [1]": "duty.speed",
        "ambient_temperature [K]": "duty.ambient_temperature",
        "base_temperature [K]": "column.base_temperature",
        "tip_temperature [K]": "column.tip_temperature",
        "column.elongation [m]": "column.elongation",
    },
}


@pytest.fixture(scope="module", params=["gantry", "spindle"])
def logged(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, pd.DataFrame]:
    """File of a machine's roles, and a log of an hour of it."""
    path = machine(request.param, tmp_path_factory.mktemp(request.param))
    path.write_text(path.read_text("utf-8").replace('stop_time = "30 min"', 'stop_time = "60 min"'), "utf-8")
    found = wl.run(path, "none", step="10 s").result
    log = {header: found[name] for header, name in COLUMNS[request.param].items()}
    random = np.random.default_rng(1)
    for header, values in log.items():
        if not header.startswith(("speed", "torque", "ambient")):
            log[header] = values + random.normal(0.0, 0.05 if header.endswith("[K]") else 5e-8, values.size)
    return path, pd.DataFrame({"time [s]": found.times, **log})


def whole(log: pd.DataFrame, name: str) -> pd.DataFrame:
    """The log with its growth in one column."""
    parts = [header for header in log if "elongation" in str(header)]
    return log.drop(columns=parts).assign(**{f"{name} [um]": 1e6 * log[parts].sum(axis=1)})


def test_a_law_is_learnt_by_the_roles(logged: tuple[Path, pd.DataFrame]) -> None:
    path, log = logged
    found = wl.design(path, "regression", data=[log])
    assert isinstance(found, LearntLaw)
    assert (found.plant is None) == (path.stem == "spindle"), "whose equations nobody knows"
    assert found.coefficients_um.keys() <= {"base", "tip"}
    (of_log,) = found.logs
    assert np.array_equal(of_log.signals["speed"], log.filter(like="speed").iloc[:, 0])
    growth = log.filter(like="elongation").sum(axis=1)
    assert of_log.measured == pytest.approx(growth, abs=1e-12)
    assert found.held_out_um < 0.1 * 1e6 * growth.max()


def test_controllers_are_judged_by_the_roles(logged: tuple[Path, pd.DataFrame]) -> None:
    path, log = logged
    learnt = wl.design(path, "regression", data=[log]).parameters
    found = wl.compare(["none", "regression"], scenario=path, data=[log], parameters=learnt)
    assert isinstance(found, Replayed)
    assert found.tolerance_um == pytest.approx(10.0), "that of the scenario"
    largest = 1e6 * log.filter(like="elongation").sum(axis=1)[log["time [s]"] > 120].abs().max()
    assert found.over_all("none")["worst_um"] == pytest.approx(largest, rel=1e-6)
    assert found.over_all("regression")["worst_um"] < 0.3 * largest


def test_one_column_may_hold_what_several_outputs_add_up_to(logged: tuple[Path, pd.DataFrame]) -> None:
    path, log = logged
    apart, found = (wl.design(path, "regression", data=[each]) for each in (log, whole(log, "elongation")))
    assert isinstance(apart, LearntLaw)
    assert isinstance(found, LearntLaw)
    assert found.coefficients_um == pytest.approx(apart.coefficients_um, rel=1e-6)


def test_the_truth_is_judged_by_and_not_learnt_from(logged: tuple[Path, pd.DataFrame]) -> None:
    path, log = logged
    true = log.assign(**{"growth [um]": 1.0e6 * log.filter(like="elongation").sum(axis=1) + 1.0})
    found = wl.compare("none", scenario=path, data=[true])
    without = wl.compare("none", scenario=path, data=[log])
    assert isinstance(found, Replayed)
    assert isinstance(without, Replayed)
    differs = found.over_all("none")["worst_um"] - without.over_all("none")["worst_um"]
    assert differs == pytest.approx(1.0, rel=1e-6)


def test_both_commands_take_them(
    logged: tuple[Path, pd.DataFrame],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, log = logged
    monkeypatch.chdir(tmp_path)
    log.to_parquet("log.parquet")
    logs = ["--data", "log.parquet", "--scenario", str(path)]
    judged = [*logs, "--controllers", "none,regression", "--parameters", "law.ssv", "--no-report", "--json"]
    for command in (["design", "--law", "regression", *logs, "--out", "law.ssv"], ["compare", *judged]):
        capsys.readouterr()
        monkeypatch.setattr("sys.argv", ["warmlink", *command])
        with pytest.raises(SystemExit, match="0"):
            main()
    laws = json.loads(capsys.readouterr().out)["laws"]
    assert laws["regression"]["worst_um"] < 0.3 * laws["none"]["worst_um"]


def test_a_machine_with_several_places_for_a_controller_is_refused() -> None:
    with pytest.raises(InputError, match="driven by programs of its own"):
        wl.compare("none", scenario="six_axis_shift", data=["log.csv"])
