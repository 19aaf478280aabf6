"""`warmlink run` as a user meets it: the answer, the files, and what the README promises of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import exit_code
from tests.pages import plots
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit

README = Path(__file__).parents[3] / "README.md"
FIGURES = {"max_abs_um", "rms_um", "p95_abs_um", "time_to_tolerance_s"}
CONDUCT = {"ready_percent", "ready_wrong_percent", "fine_not_ready_percent", "travel_um_h", "leap_um"}


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """The default run with its report, native FMUs: what it printed, and its folder."""
    folder = tmp_path_factory.mktemp("run") / "out"
    with pytest.MonkeyPatch.context() as patch:
        printed: list[str] = []
        patch.setattr("warmlink.orchestration.command_line.run.answer", printed.append)
        assert exit_code(["run", "--out", str(folder)], patch) == 0
    return "\n".join(printed), folder


def test_the_answer_is_the_one_in_the_readme(outcome: tuple[str, Path]) -> None:
    printed = outcome[0].splitlines()
    promised = re.search(r"```\n(warm_up.*?)\n```", README.read_text("utf-8"), re.DOTALL)
    assert promised is not None
    assert printed[:-1] == promised[1].splitlines()[:-1]


def test_metrics_hold_what_was_asked_for(outcome: tuple[str, Path]) -> None:
    metrics = json.loads((outcome[1] / "metrics.json").read_text("utf-8"))
    assert (metrics["scenario"], metrics["controller"]) == ("warm_up", "observer")
    assert metrics["mismatches"] == ["noisy_sensors", "draw_1"]
    assert (metrics["stop_time_s"], metrics["communication_step_size_s"]) == (7200.0, 1.0)
    assert set(metrics["uncompensated"]) == FIGURES
    assert set(metrics["compensated"]) == FIGURES | CONDUCT
    assert set(metrics["error_budget_um"]) == {"coupling", "discretisation"}
    assert {"controller", "fmus", "reduction_percent", "heat_balance_error_J", "wall_seconds"} <= set(metrics)
    # The heat that went over is some 13 kJ.
    assert abs(metrics["heat_balance_error_J"]) < 20


def test_series_are_read_by_pandas_and_agree_with_the_metrics(outcome: tuple[str, Path]) -> None:
    folder = outcome[1]
    table = pd.read_parquet(folder / "results.parquet")
    assert np.allclose(table, pd.read_csv(folder / "results.csv"), rtol=1e-14, equal_nan=True)
    assert table["time [s]"].iloc[-1] == 7200
    error = table["link.elongation [m]"] - table["compensator.correction [m]"]
    metrics = json.loads((folder / "metrics.json").read_text("utf-8"))
    assert 1e6 * error.abs().max() == pytest.approx(metrics["compensated"]["max_abs_um"])
    assert np.array_equal(table["error [m]"], error)
    assert 1e6 * table["uncompensated_error [m]"].abs().max() == pytest.approx(
        metrics["uncompensated"]["max_abs_um"]
    )


@pytest.mark.parametrize("named", [(), ("error",)])
def test_the_error_of_a_run_is_plotted_from_its_folder(
    outcome: tuple[str, Path], named: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "plot.html"
    assert exit_code(["plot", str(outcome[1]), *named, "--out", str(page)], monkeypatch) == 0
    assert "error" in plots(page)


def test_the_report_needs_no_network(outcome: tuple[str, Path]) -> None:
    page = (outcome[1] / "report.html").read_text("utf-8")
    # Of six lines each has a dash of its own beside its colour.
    assert '"longdashdot"' in plots(outcome[1] / "report.html")
    for heading in ("Error of the tool point", "Temperatures", "Heat flows", "Settings", "Versions"):
        assert f"<h2>{heading}</h2>" in page


def test_json_for_machines_and_no_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["run", "stop_and_go", "--stop", "10 s", "--fmus", "python", "--no-report", "--json"]
    assert exit_code([*arguments, "--out", str(tmp_path / "out")], monkeypatch) == 0
    assert json.loads(capsys.readouterr().out)["scenario"] == "stop_and_go"
    assert not (tmp_path / "out" / "report.html").exists()


@pytest.mark.slow
def test_native_and_python_fmus_give_one_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elongation = {}
    for kind in ("native", "python"):
        folder = tmp_path / kind
        arguments = ["run", "windshield_wiper", "--stop", "1 min", "--fmus", kind, "--no-report"]
        assert exit_code([*arguments, "--out", str(folder)], monkeypatch) == 0
        elongation[kind] = pd.read_parquet(folder / "results.parquet")["link.elongation [m]"].to_numpy()
    assert np.abs(elongation["native"] - elongation["python"]).max() < 1e-9 * elongation["python"].max()


def test_a_start_value_changes_the_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for settings in ([], ["--set", "link.expansion_coefficient=47.2e-6 1/K"]):
        arguments = ["run", "windshield_wiper", "--stop", "10 min", "--no-report", "--json", *settings]
        assert exit_code([*arguments, "--out", str(tmp_path / "out")], monkeypatch) == 0
        found.append(json.loads(capsys.readouterr().out)["uncompensated"]["max_abs_um"])
    assert found[1] == pytest.approx(2 * found[0], rel=1e-9)
    assert found[0] == pytest.approx(14.07, rel=6e-3), "by independent finite elements"


def test_a_start_value_of_the_controller_leaves_none_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for arguments in ([], ["--set", "compensator.gain=1 um/W"]):
        out = ["--stop", "5 min", "--json", "--no-report", "--out", str(tmp_path / "out")]
        assert exit_code(["run", "windshield_wiper", *arguments, *out], monkeypatch) == 0
        found.append(json.loads(capsys.readouterr().out))
    usual, weak = found
    assert weak["uncompensated"] == usual["uncompensated"]
    assert weak["compensated"]["max_abs_um"] != pytest.approx(usual["compensated"]["max_abs_um"], rel=0.1)


def test_parameter_sets_of_plant_and_controller_are_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plant, law = tmp_path / "extended.ssv", tmp_path / "winner.ssv"
    write_ssv({"motor.joint_resistance": 0.5}, plant)
    write_ssv({"gain": SsvValue("gain", "Real", 1.0, parse_unit("um/W"))}, law)
    by_file = ["--parameters", str(plant), "--parameters", str(law)]
    by_hand = ["--set", "motor.joint_resistance=0.5 K/W", "--set", "compensator.gain=1 um/W"]
    found = []
    for arguments in (by_file, by_hand, [*by_file, "--set", "motor.joint_resistance=0 K/W"]):
        out = ["--stop", "5 min", "--json", "--no-report", "--out", str(tmp_path / "out")]
        assert exit_code(["run", "windshield_wiper", *arguments, *out], monkeypatch) == 0
        found.append(json.loads(capsys.readouterr().out)["compensated"])
    assert found[0]["max_abs_um"] == pytest.approx(found[1]["max_abs_um"], rel=1e-12)
    assert found[2]["max_abs_um"] > found[1]["max_abs_um"], "--set comes last"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--parameters", "absent.ssv"], "absent.ssv: no such file"),
        (["six_axis_shift", "--parameters", "absent.ssv"], "absent.ssv: no such file"),
    ],
)
def test_parameter_sets_that_cannot_serve(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code(["run", *arguments], monkeypatch) == 2
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("pattern", "sentence"),
    [
        ("zzz.*", "--record zzz.*: nothing of this name is recorded; choose"),
        (
            "error,link.elongatoin",
            "link.elongatoin: nothing of this name is recorded; did you mean link.elong",
        ),
    ],
)
def test_what_is_not_recorded_cannot_be_chosen(
    pattern: str,
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code(["save", "stop_and_go", "--out", "cell.ssp"], monkeypatch) == 0
    for arguments in (["run", "stop_and_go"], ["simulate", "cell.ssp", "--stop", "1 min"]):
        capsys.readouterr()
        chosen = pattern.replace("error,", "") if arguments[0] == "simulate" else pattern
        assert exit_code([*arguments, "--record", chosen, "--out", "o"], monkeypatch) == 2
        assert sentence in capsys.readouterr().err
        assert not Path("o").exists()


def test_what_is_written_can_be_chosen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = "link.elo*,motor.shaft_temperature,sensors.reading[1]"
    chosen = ["--record", names, "--no-csv", "--no-report"]
    assert (
        exit_code(
            ["run", "stop_and_go", "--stop", "1 min", *chosen, "--out", str(tmp_path / "o")], monkeypatch
        )
        == 0
    )
    assert {path.name for path in (tmp_path / "o").iterdir()} == {
        "command.txt",
        "metrics.json",
        "results.parquet",
    }
    frame = pd.read_parquet(tmp_path / "o" / "results.parquet")
    named = ["motor.shaft_temperature [K]", "link.elongation [m]", "sensors.reading[1] [K]"]
    assert list(frame) == ["time [s]", *named]
    assert len(frame) == 61
