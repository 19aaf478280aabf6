"""CONTRIBUTING.md: its recipes are followed literally in a copy of the project."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
ROOMS = ("fmus", "controllers", "orchestration", "tests", "benchmarks", "examples")

FILES = re.findall(r"`(\w+/[\w/.]+)`:\n\n```\w+\n(.*?)```", TEXT, re.DOTALL)
PACKAGES = re.findall(r'^    "warmlink\.[\w.]+",$', TEXT, re.MULTILINE)
LINES = re.findall(r"^```markdown\n(\| `[\w/]+/` \| .*\|)\n```$", TEXT, re.MULTILINE)
COMMANDS = re.findall(r"^pytest (\S+)$", TEXT, re.MULTILINE)


@pytest.mark.slow
def test_the_recipes_work(tmp_path: Path) -> None:
    home = tmp_path / "warmlink"
    for room in ROOMS:
        shutil.copytree(ROOT / room, home / room, ignore=shutil.ignore_patterns("__pycache__"))
    declared = (ROOT / "pyproject.toml").read_text("utf-8")
    packages = "packages = [\n"
    listed = declared.replace(packages, "\n".join([packages.strip(), *PACKAGES, ""]), 1)
    (home / "pyproject.toml").write_text(listed, "utf-8")
    shutil.copytree(ROOT / ".typing", home / ".typing", symlinks=True)
    (home / "LICENSE").write_bytes((ROOT / "LICENSE").read_bytes())
    assert [len(FILES), len(PACKAGES), len(LINES), len(COMMANDS)] == [11, 2, 2, 4]
    last = "| `docs/`, `examples/` |"
    (home / "CONTRIBUTING.md").write_text(TEXT.replace(last, "\n".join([*LINES, last]), 1), "utf-8")
    for name, text in FILES:
        assert not (ROOT / name).exists(), f"{name} is there already; the recipe needs another example"
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text(text, "utf-8")

    def done(*arguments: str) -> str:
        environment = {**os.environ, "PYTHONPATH": str(home / ".typing")}
        run = subprocess.run(
            [sys.executable, "-m", *arguments], cwd=home, env=environment, capture_output=True, text=True
        )
        assert run.returncode == 0, run.stdout + run.stderr
        return run.stdout

    told = done("pytest", "-n", "0", "-p", "no:cacheprovider", "--durations", "0", *COMMANDS)
    assert "passed" in told
    shown = json.loads(done("warmlink", "list", "--json"))
    assert "ColdPlate" in shown["components"]
    assert "tip" in shown["controllers"]
