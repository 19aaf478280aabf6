"""The scripts in `examples/` run, stay short, and keep the numbers that they assert."""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRIPTS = sorted([*EXAMPLES.glob("*.py"), *EXAMPLES.glob("*/tutorial.py")])


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_runs_and_checks_a_number(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    text = script.read_text("utf-8")
    beside = script.parent.iterdir() if script.parent != EXAMPLES else [script]
    assert all(len(path.read_text("utf-8").splitlines()) < 60 for path in beside if path.is_file())
    assert "\nassert " in text
    assert f"({script.relative_to(EXAMPLES).as_posix()})" in (EXAMPLES / "README.md").read_text("utf-8")
    runpy.run_path(str(script), run_name="__main__")
