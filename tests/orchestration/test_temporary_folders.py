"""What a command leaves among temporary files: nothing, and what a killed one left goes with the next."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from warmlink.fmus.packaging.native.compile import PLATFORMS, Compiler

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="locks are those of POSIX")
LAW = """
from warmlink.controllers.own import Law


class Mine(Law):
    def correction(self, x, u, p, time):
        return 1e-6
"""
WAITS = """
import sys, time
from warmlink.orchestration.catalogue import controller_named
from warmlink.fmus.files import scratch_folder
controller_named("law.py:Mine")
with scratch_folder():
    print("begun", flush=True)
    {then}
"""


def begun(folder: Path, then: str) -> subprocess.Popen[str]:
    (folder / "temporary").mkdir(exist_ok=True)
    (folder / "law.py").write_text(LAW)
    process = subprocess.Popen(
        [sys.executable, "-c", WAITS.format(then=then)],
        cwd=folder,
        env={**os.environ, "TMPDIR": str(folder / "temporary")},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    return process


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "temporary").iterdir())


@pytest.mark.parametrize("then", ["pass", "raise SystemExit(2)", "raise ValueError"])
def test_a_law_of_ones_own_leaves_nothing(then: str, tmp_path: Path) -> None:
    begun(tmp_path, then).communicate()
    assert left(tmp_path) == []


def test_what_a_killed_process_left_goes_with_the_next_and_not_what_is_in_use(tmp_path: Path) -> None:
    killed, alive = (begun(tmp_path, "time.sleep(60)") for _ in range(2))
    assert len(left(tmp_path)) == 4
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    begun(tmp_path, "pass").communicate()
    assert len(left(tmp_path)) == 2
    assert alive.poll() is None
    alive.send_signal(signal.SIGKILL)
    alive.communicate()


def test_a_compiler_keeps_its_own_files_in_the_folder_that_goes(tmp_path: Path) -> None:
    command = (sys.executable, "-c", "import os; open('made', 'w').write(os.environ['TMPDIR'])")
    platform = next(iter(PLATFORMS.values()))
    made = Path(Compiler(command, platform, ()).made("made", {}, ()).decode())
    assert made.is_absolute()
    assert not made.exists()


NAMES = ("Heater", "MotorHeatSource", "TemperatureSensors", "ThermalLink")
"""Enough for a build to be killed between the first and the last."""


def test_a_killed_build_leaves_nothing_that_the_next_does_not_remove(tmp_path: Path) -> None:
    (tmp_path / "temporary").mkdir()
    command = [sys.executable, "-m", "warmlink.orchestration.cli", "build", *NAMES, "--fmus", "python"]
    where = {**os.environ, "TMPDIR": str(tmp_path / "temporary")}
    process = subprocess.Popen(command, cwd=tmp_path, env=where, stdout=subprocess.PIPE)
    give_up = time.monotonic() + 60
    while not [*(tmp_path / "dist").rglob("*.fmu")]:
        assert time.monotonic() < give_up
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not [*(tmp_path / "dist").glob("python")]  # all of it or none
    done = subprocess.run(command, cwd=tmp_path, env=where, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert left(tmp_path) == []
    assert not [path for path in (tmp_path / "dist").rglob("*") if path.name.startswith(".")]
    assert [*(tmp_path / "dist").glob("python/*.fmu")]
