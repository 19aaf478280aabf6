"""The command as such: its version, its names for the shell, the ways to start it."""

from __future__ import annotations

import errno
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

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
        ("sim", "simulate"),
    ],
)
def test_the_shell_completes_commands_and_names(tmp_path: Path, words: str, proposed: str) -> None:
    done = started(
        folder=tmp_path,
        _WARMLINK_COMPLETE="complete_bash",
        COMP_WORDS=f"warmlink {words}",
        COMP_CWORD=str(len(words.split())),
    )
    assert proposed in done.stdout.split()


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
