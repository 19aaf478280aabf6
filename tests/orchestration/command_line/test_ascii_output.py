"""Where standard output takes no µ, answers are printed in the characters that it takes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = [sys.executable, "-m", "warmlink.orchestration.cli"]


@pytest.mark.parametrize("encoding", ["ascii", "cp437", "latin-1"])
@pytest.mark.parametrize(
    "arguments", [["list"], ["run", "--no-report", "--stop", "1 min", "--out", "o"], ["run", "--help"]]
)
def test_an_answer_is_printed(encoding: str, arguments: list[str], tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    done = subprocess.run(
        [*COMMAND, *arguments], cwd=tmp_path, env=environment, capture_output=True, check=False
    )
    said = (done.stdout + done.stderr).decode(encoding)
    assert done.returncode == 0, said
    if encoding == "ascii" and arguments[0] == "run" and "--out" in arguments:
        assert "+-" in said
        assert " um " in said
