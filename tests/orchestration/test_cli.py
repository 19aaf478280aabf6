"""The command as such: its version, its names for the shell, the ways to start it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO

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


def test_the_process_ends_at_once_but_not_before_what_is_due(tmp_path: Path) -> None:
    """What was printed is out, what waits for the end of the process is done, and the exit code is told."""
    code = (
        "import atexit, sys\n"
        "from warmlink.orchestration import cli\n"
        "atexit.register(print, 'tidied up')\n"
        "def command():\n    print('answer')\n    raise SystemExit(1)\n"
        "cli.app = command\n"
        "cli.script()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (1, "answer\ntidied up\n", "")


def ended(
    statement: str, stdout: IO[str] | None = None, before: Callable[[], None] | None = None
) -> subprocess.CompletedProcess[str]:
    """Process whose command is one statement."""
    code = (
        f"from warmlink.orchestration import cli\ndef command():\n    {statement}\n"
        "cli.app = command\ncli.script()\n"
    )
    call = [sys.executable, "-c", code]
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    return subprocess.run(
        call, env=buffered, stderr=subprocess.PIPE, text=True, check=False, stdout=stdout, preexec_fn=before
    )


def test_an_end_with_a_text_says_it_and_fails() -> None:
    done = ended("raise SystemExit('why it ended')")
    assert (done.returncode, done.stderr) == (1, "warmlink: why it ended\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_an_answer_that_cannot_be_written_is_no_success() -> None:
    with Path("/dev/full").open("w") as full:
        done = ended("print('answer')", stdout=full)
    assert (done.returncode, done.stderr) == (
        1,
        "warmlink: the answer could not be written (No space left on device)\n",
    )


@pytest.mark.skipif(os.name == "nt", reason="closes a descriptor by its number")
def test_a_closed_standard_output_is_no_fault() -> None:
    done = ended("print('answer')", before=lambda: os.close(1))
    assert (done.returncode, done.stderr) == (0, "")


def test_a_pool_of_processes_ends_before_the_process_does() -> None:
    done = ended(
        "from concurrent.futures import ProcessPoolExecutor as Pool; import multiprocessing; global pool; "
        "pool = Pool(2, multiprocessing.get_context('spawn')); pool.submit(abs, 1); "
        "pool.submit(abs, 2).result()"
    )
    assert (done.returncode, done.stderr) == (0, "")
