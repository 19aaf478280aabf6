"""`warmlink init` writes commented files that run as they are."""

from contextlib import suppress
from pathlib import Path

import pytest

from warmlink.orchestration.cli import main
from warmlink.orchestration.command_line.init import KINDS, TEMPLATES
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import read


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
    assert "experiment.toml: is there already" in told(monkeypatch, capsys, "experiment", "--out", "rig")
    assert "no such kind of file" in told(monkeypatch, capsys, "experimnt")


def test_what_is_commented_out_can_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, write in KINDS["experiment"].items():
        write(tmp_path / name)
    path = tmp_path / "experiment.toml"
    lines = path.read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("title"))
    used = [
        line.removeprefix("# ") if i > first and "T_next" not in line else line
        for i, line in enumerate(lines)
    ]
    path.write_text("\n".join(used))
    found = read_experiment(path)
    assert found.runs[1].adapt == 1200
    assert found.cause_labels == ("fan",)
    assert found.calibrated[1].per == "fan"


def test_every_kind_has_its_template() -> None:
    assert {next(iter(files)) for files in KINDS.values()} == {path.name for path in TEMPLATES.iterdir()}
