"""A name that no file can have is that of no file, in whatever place of the command line it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.orchestration.cli import app, guarded

LONG = "x" * 300


@pytest.mark.parametrize(
    "command",
    [
        f"run {LONG}.csv",
        f"run {LONG}.toml",
        f"run --controller {LONG}.py:Law",
        f"run --parameters {LONG}.ssv",
        f"run --mismatch {LONG}.toml",
        f"run --out {LONG}",
        f"simulate {LONG}.ssp",
        f"simulate cell.ssp --out {LONG}",
        f"check {LONG}.fmu",
        f"check {LONG}.ssp",
        f"diagnose {LONG}.csv",
        f"diagnose {LONG}.toml",
        f"hide --duty {LONG}.csv --out x.csv",
        f"hide --out {LONG}.csv",
        f"compare --parameters {LONG}.ssv",
        f"compare --with {LONG}.py:Law",
        f"compare --out {LONG}",
        f"tune {LONG}.toml",
        f"sweep {LONG}.toml",
        f"design {LONG}.ssp",
        f"design WarmupCell --law regression --out {LONG}.ssv",
        f"build --out {LONG}",
    ],
    ids=lambda command: command.replace(LONG, "LONG"),
)
def test_a_name_too_long_for_any_file_is_refused_in_one_sentence(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        guarded(lambda: app(command.split(), prog_name="warmlink"))
    assert ended.value.code == 2
    (told,) = capfd.readouterr().err.strip().splitlines()
    assert told.startswith("warmlink: ")
    assert list(tmp_path.iterdir()) == []
