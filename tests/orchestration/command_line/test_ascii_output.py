"""Where standard output takes no µ, answers are printed in the characters that it takes."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command import exit_code

RUN = ["run", "--no-report", "--stop", "1 min", "--out", "o"]


@pytest.mark.parametrize("encoding", ["ascii", "cp437", "latin-1"])
@pytest.mark.parametrize("arguments", [["list"], RUN, ["run", "--help"]])
def test_an_answer_is_printed(
    encoding: str, arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    printed = io.BytesIO()
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, io.TextIOWrapper(printed, encoding, write_through=True))
    code = exit_code(arguments, monkeypatch)
    said = printed.getvalue().decode(encoding)
    assert code == 0, said
    if encoding == "ascii" and arguments == RUN:
        assert_plain(said)


def test_a_process_prints_as_its_environment_says(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "warmlink.orchestration.cli", *RUN]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=True)
    assert_plain((done.stdout + done.stderr).decode("ascii"))


def assert_plain(said: str) -> None:
    assert "+-" in said
    assert " um " in said
