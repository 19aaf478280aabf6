"""The command as such: its version, its names for the shell, the ways to start it."""

from __future__ import annotations

import errno
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command import exit_code
from warmlink.fmus.packaging.release import version


def started(*arguments: str, folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "warmlink", *arguments],
        cwd=folder,
        env={**os.environ, **more},
        capture_output=True,
        text=True,
        check=False,
    )


def test_it_starts_as_a_module_and_says_its_version(tmp_path: Path) -> None:
    done = started("--version", folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"warmlink {version()}\n", "")


def test_a_misspelt_command_is_told_the_right_one(tmp_path: Path) -> None:
    done = started("rnu", folder=tmp_path)
    assert done.returncode == 2
    assert "Usage: warmlink" in done.stderr
    assert "Did you mean 'run'?" in done.stderr


@pytest.mark.parametrize(
    ("words", "proposed"),
    [
        ("run wind", "windshield_wiper"),
        ("run six", "six_axis_shift"),
        ("run --controller la", "lag"),
        ("run --mismatch noi", "noisy_sensors"),
        ("run --master gauss", "gauss_seidel"),
    ],
)
def test_the_shell_completes_commands_and_names(
    words: str,
    proposed: str,
    in_a_fresh_folder: None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for name, value in asked(words).items():
        monkeypatch.setenv(name, value)
    assert exit_code([], monkeypatch) == 0
    assert proposed in capsys.readouterr().out.split()


def test_the_shell_asks_a_process(tmp_path: Path) -> None:
    assert "simulate" in started(folder=tmp_path, **asked("sim")).stdout.split()


def asked(words: str) -> dict[str, str]:
    """What the shell says in the environment when a word is to be completed."""
    return {
        "_WARMLINK_COMPLETE": "complete_bash",
        "COMP_WORDS": f"warmlink {words}",
        "COMP_CWORD": str(len(words.split())),
    }


@pytest.mark.platform
@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
@pytest.mark.parametrize("arguments", ["--version", "list", "list --json"])
def test_an_answer_that_cannot_be_printed_is_no_traceback(arguments: str) -> None:
    """Standard output is a full disk, or was closed by whoever started the command."""
    command = f"{shlex.quote(sys.executable)} -m warmlink {arguments}"
    full, closed = (
        subprocess.run(["sh", "-c", f"{command} {output}"], capture_output=True, text=True, check=False)
        for output in ("> /dev/full", ">&-")
    )
    reason = os.strerror(errno.ENOSPC).lower()
    told = f"warmlink: the answer cannot be written ({reason}); free space there, and run it again\n"
    assert (full.returncode, full.stderr) == (1, told)
    assert (closed.returncode, closed.stderr) == (0, "")


@pytest.mark.platform
@pytest.mark.skipif(sys.platform == "win32", reason="needs a shell that closes a stream")
def test_remarks_that_nobody_wants_are_no_answer() -> None:
    """Standard error was closed by whoever started the command."""
    command = f"{shlex.quote(sys.executable)} -m warmlink run --controller nobody 2>&-"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")
