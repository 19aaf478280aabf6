"""`warmlink init` writes commented files that run as they are."""

import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pandas as pd
import pytest

from warmlink.orchestration.catalogue import load_own_law
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.command_line.init import KINDS, TEMPLATES, WRITERS
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.studies.study import load_study


def told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    monkeypatch.setattr("sys.argv", ["warmlink", "init", *arguments])
    with suppress(SystemExit):
        main()
    said = capsys.readouterr()
    return said.out + said.err


def test_an_experiment_can_be_diagnosed_as_it_is_and_is_not_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "rig/experiment.toml" in told(monkeypatch, capsys, "experiment", "--out", "rig")
    found = read([Path("rig/experiment.toml")])
    assert [run.heldout for run in found.runs] == [False, True]
    assert len(found.columns) == 6
    assert found.remarks == ()
    assert "experiment.toml: exists already" in told(monkeypatch, capsys, "experiment", "--out", "rig")
    assert "no such kind of file" in told(monkeypatch, capsys, "experimnt")


def uncommented(text: str, but: str) -> str:
    """A template with the entries in use that stand behind a #, those with a word apart."""
    return "\n".join(
        re.sub(r'^# (?=\[|"|\w+ = ["\[{\d])', "", line) for line in text.splitlines() if but not in line
    )


def test_what_is_commented_out_can_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in KINDS["experiment"][1:]:
        WRITERS[Path(name).suffix](tmp_path / name)
    for log in tmp_path.glob("*.csv"):
        table = pd.read_csv(log)
        table.assign(**{"across [K]": 0.0}).to_csv(log, index=False)
    path = tmp_path / "experiment.toml"
    path.write_text(uncommented(path.read_text("utf-8"), "T_next"))
    found = read_experiment(path)
    assert found.runs[1].adapt == 1200
    assert found.cause_labels == ("fan",)
    assert found.calibrated[1].per == "fan"


@pytest.mark.slow
@pytest.mark.parametrize("kind", [each for each in KINDS if each != "causes"])
def test_what_init_says_to_try_ends_well(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The experiment names the causes."""
    monkeypatch.chdir(tmp_path)
    command = told(monkeypatch, capsys, kind).partition("try  ")[2].split()
    monkeypatch.setattr("sys.argv", command)
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 0, capsys.readouterr().err


def test_every_kind_has_its_template() -> None:
    first = {Path(file).stem for _, file, *_ in KINDS.values()}
    assert first == {path.stem for path in TEMPLATES.iterdir()}


def test_scenario_cell_study_and_law_work_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for kind in ("scenario", "cell", "study", "law"):
        printed = told(monkeypatch, capsys, kind, "--out", kind)
        assert f"try  {KINDS[kind][0]} {kind}/{kind}." in printed
    for kind in ("scenario", "cell"):
        scenario = load_scenario(f"{kind}/{kind}.toml")
        assert scenario.values()["sensors"]["noise[1]"] == pytest.approx(0.1)
        assert scenario.stop_time / scenario.step_size == 7200
    assert [axis.name for axis in load_study("study/study.toml").axes] == [
        "compensator.gain",
        "compensator.time_constant",
    ]
    assert load_own_law("law/law.py:MyLaw").name == "MyLaw"


@pytest.mark.parametrize(("kind", "read"), [("cell", load_scenario), ("study", load_study)])
def test_what_is_commented_out_in_a_cell_and_a_study_can_be_used(
    kind: str, read: Callable[[str], object], tmp_path: Path
) -> None:
    text = (TEMPLATES / f"{kind}.toml").read_text("utf-8")
    (tmp_path / "mine.toml").write_text(uncommented(text, "cell.toml"))
    assert read(str(tmp_path / "mine.toml"))


def test_a_schema_that_lies_there_already_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    told(monkeypatch, capsys, "scenario")
    assert "warmlink run cell.toml" in told(monkeypatch, capsys, "cell")
    Path("scenario.json").write_text("{}")
    Path("cell.toml").unlink()
    assert "scenario.json: exists already" in told(monkeypatch, capsys, "cell")
    assert not Path("cell.toml").exists()
    assert Path("scenario.json").read_text() == "{}"
    Path("scenario.json").unlink()
    Path("scenario.json").mkdir()
    assert "scenario.json: exists already" in told(monkeypatch, capsys, "cell")
