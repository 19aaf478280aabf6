"""A folder of results holds those of one command, of one run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from warmlink.orchestration.cli import main
from warmlink.orchestration.results import RESULTS

STUDY = """
controller = "lag"
duty_cycles = ["brief.toml"]
[parameters]
"compensator.gain" = { min = "2 um/W", max = "8 um/W" }
"""
ARGUMENTS = {
    "run": ["run", "--stop", "1 min"],
    "simulate": ["simulate", "cell.ssp", "--stop", "1 min"],
    "compare": ["compare", "--controllers", "lag", "--duty-cycles", "stop_and_go"],
    "tune": ["tune", "study.toml"],
    "sweep": ["sweep", "study.toml"],
    "diagnose": ["diagnose", "run.csv"],
    "reproduce": ["reproduce"],
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("brief.toml").write_text('duty = "stop_and_go"\nstop_time = "10 min"\n')
    Path("study.toml").write_text(STUDY)
    Path("run.csv").write_text("time [s],speed [rad/s]\n0,1\n1,1\n")


def told(arguments: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> str:
    """What is said on standard error where a command succeeds, or after its exit code."""
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    said = capsys.readouterr().err
    return f"{stop.value.code} {said}" if stop.value.code else said


@pytest.mark.parametrize("command", RESULTS)
def test_another_commands_results_are_not_mixed_with_its_own(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = "compare.csv" if command != "compare" else "metrics.json"
    writer = "compare" if command != "compare" else "run"
    Path("mine").mkdir()
    Path("mine", other).write_text("of another command")
    monkeypatch.setattr("warmlink.orchestration.command_line.simulate.temporary_folder", _never)
    said = told([*ARGUMENTS[command], "--out", "mine"], capsys, monkeypatch)
    assert said.startswith(f"2 warmlink: mine: holds {other} of warmlink {writer}; choose another --out"), (
        said
    )
    assert [path.name for path in Path("mine").iterdir()] == [other]


def _never() -> None:
    raise AssertionError("it was to be refused before")


def test_a_cell_is_run_saved_and_simulated_without_naming_a_folder(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("mine.toml").write_text('duty = "stop_and_go"\nstop_time = "1 min"\n')
    assert not told(["run", "mine.toml"], capsys, monkeypatch).startswith("2")
    files = {path.name for path in Path("out/mine").iterdir()}
    assert files <= set(RESULTS["run"])
    rows = Path("out/mine/results.csv").read_bytes()
    assert not told(["save", "mine.toml", "--out", "mine.ssp"], capsys, monkeypatch).startswith("2")
    arguments = ["simulate", "mine.ssp", "--stop", "2 min", "--no-error-budget"]
    assert not told(arguments, capsys, monkeypatch).startswith("2")
    assert {path.name for path in Path("out/mine/simulate").iterdir()} == set(RESULTS["simulate"])
    assert Path("out/mine/results.csv").read_bytes() == rows
    # What the run before left, and this one does not write, would be taken for this one's.
    Path("out/mine/notes.txt").write_text("mine")
    assert not told(["run", "mine.toml", "--no-report", "--no-csv"], capsys, monkeypatch).startswith("2")
    left = {"command.txt", "metrics.json", "results.parquet", "notes.txt", "simulate"}
    assert {path.name for path in Path("out/mine").iterdir()} == left
    assert json.loads(Path("out/mine/metrics.json").read_text())["scenario"] == "mine"


def test_results_of_another_command_line_are_kept(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("mine.toml").write_text('duty = "stop_and_go"\nstop_time = "1 min"\n')
    run = ["run", "mine.toml", "--no-report"]
    first = told(run, capsys, monkeypatch)
    assert "kept" not in first
    nominal = Path("out/mine/results.csv").read_bytes()
    assert "kept" not in told(run, capsys, monkeypatch)
    second = told([*run, "--set", "motor.joint_conductance=2 W/K"], capsys, monkeypatch)
    kept = Path("out/mine/earlier-1")
    assert f"the results that were in out/mine (of warmlink run mine.toml) are kept in {kept}" in second
    assert (kept / "results.csv").read_bytes() == nominal
    assert (kept / "command.txt").read_text() == "warmlink run mine.toml\n"
    assert Path("out/mine/results.csv").read_bytes() != nominal
    told(run, capsys, monkeypatch)
    assert Path("out/mine/results.csv").read_bytes() == nominal
    assert "joint_conductance" in Path("out/mine/earlier-2/command.txt").read_text()


def test_the_winner_of_another_instance_goes_with_the_study_that_had_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("optuna")
    link = '"link.conductivity" = { min = "150 W/(m*K)", max = "170 W/(m*K)" }\n'
    for text in (STUDY + link, STUDY):
        Path("study.toml").write_text(text)
        told(["tune", "study.toml", "--trials", "1", "--no-report"], capsys, monkeypatch)
    assert {path.name for path in Path("out/study/tune").glob("*.ssv")} == {"winner.ssv"}
    Path("mine").mkdir()
    Path("mine/winner-link.ssv").touch()
    said = told(["sweep", "study.toml", "--out", "mine"], capsys, monkeypatch)
    assert said.startswith("2 warmlink: mine: holds winner-link.ssv of warmlink tune")


def test_a_studys_table_while_it_runs_is_no_earlier_result_and_replaces_none(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("optuna")
    first = ["tune", "study.toml", "--trials", "2", "--no-report"]
    assert "kept" not in told(first, capsys, monkeypatch)
    folder = Path("out/study/tune")
    names = {path.name for path in folder.iterdir()}
    assert {"trials.csv", "winner.ssv", "command.txt"} <= names
    assert not any(name.startswith("earlier") for name in names)
    table, winner = ((folder / name).read_bytes() for name in ("trials.csv", "winner.ssv"))
    more = ["tune", "study.toml", "--trials", "3", "--no-report"]
    assert "(of warmlink tune study.toml --trials 2) are kept in" in told(more, capsys, monkeypatch)
    assert (folder / "earlier-1/trials.csv").read_bytes() == table
    assert (folder / "earlier-1/winner.ssv").read_bytes() == winner
    assert not (folder / "earlier-2").exists()
    assert len((folder / "trials.csv").read_text("utf-8").splitlines()) == 4
