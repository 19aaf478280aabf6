"""The scripts in `examples/` run, stay short, and keep the numbers that they assert."""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_runs_and_checks_a_number(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    text = script.read_text("utf-8")
    assert len(text.splitlines()) < 60
    assert "\nassert " in text
    assert f"({script.name})" in (EXAMPLES / "README.md").read_text("utf-8")
    runpy.run_path(str(script), run_name="__main__")
