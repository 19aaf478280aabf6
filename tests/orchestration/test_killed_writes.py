"""A command that is killed at every change of its folder leaves the old results whole, or the new ones."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.orchestration.test_full_disk import ALL, comparable, library, system
from tests.warm import ran
from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import settle
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.report.recorded import columns_of

__all__ = ["library", "system"]  # fixtures

pytestmark = [
    pytest.mark.platform,
    pytest.mark.slow,
    pytest.mark.timeout(0 if ALL else 300),
    pytest.mark.skipif(sys.platform != "linux" or shutil.which("gcc") is None, reason="needs Linux and gcc"),
]

# Each run in a copy of one process, which the library is loaded into; a first run counts the changes.
EVERY_CHANGE = """
import contextlib, ctypes, importlib, os, shutil, sys
from pathlib import Path
library, before, folder, stride, *argv = sys.argv[1:]
from warmlink.orchestration import cli
counters = ctypes.CDLL(library).full_disk_counters
counters.restype = ctypes.POINTER(ctypes.c_long)
counters = counters()
def once(k, kill_at):
    place = f"{folder}/{k}"
    shutil.copytree(before, place)
    counters[2], counters[3] = 0, kill_at
    child = os.fork()
    if not child:
        counters[4] = os.getpid()
        log = os.open(f"{folder}/{k}.log", os.O_WRONLY | os.O_CREAT)
        os.dup2(log, 1)
        os.dup2(log, 2)
        sys.argv = ["warmlink", *argv, "--out", place]
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
        finally:
            sys.stderr.flush()
            if k == "whole":
                Path(f"{before}.needed").write_text(" ".join(sys.modules))
            os._exit(code)
    made = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    count, counters[3] = counters[2], 1 << 60
    print(k, made, flush=True)
    return count
count = once("whole", 1 << 60)
for name in Path(f"{before}.needed").read_text().split():  # which each copy would else import anew
    with contextlib.suppress(ImportError):
        importlib.import_module(name)
for k in sorted({*range(0, count, int(stride)), count - 1}):
    once(k, k)
"""

COMMANDS = {
    "run": lambda system: ["run", "windshield_wiper", "--controller", "lag", "--no-report", "--step", "10 s"],
    "simulate": lambda system: ["simulate", str(system), "--no-error-budget"],
    "streamed": lambda system: ["simulate", str(system), "--checkpoint", "40"],
}

EVERY = {"run": "23", "simulate": "13", "streamed": "13"}
"""The run changes its folder more often than the others do; each is killed at some six changes."""


def held(folder: Path) -> dict[str, str]:
    return comparable({path.name: path.read_bytes().hex() for path in folder.iterdir() if path.is_file()})


def results(files: dict[str, str]) -> dict[str, str]:
    return {name: files[name] for name in files if name.startswith(("results.", "metrics."))}


@pytest.mark.parametrize("command", COMMANDS)
def test_old_results_are_whole_or_new_ones(library: Path, system: Path, tmp_path: Path, command: str) -> None:
    try:
        FmuStore("native").files(["ThermalLink"])
    except InputError as fault:
        pytest.skip(str(fault))
    make: Callable[[Path], list[str]] = COMMANDS[command]
    own, before, folder = make(system), tmp_path / "before", tmp_path / "killed"
    folder.mkdir()
    begin = [sys.executable, "-c", EVERY_CHANGE]
    ran(*own, "--stop", "1 min", "--out", str(before)).check_returncode()
    done = subprocess.run(
        [
            *begin,
            str(library),
            str(before),
            str(folder),
            "1" if ALL else EVERY[command],
            *own,
            "--stop",
            "2 min",
        ],
        cwd=tmp_path,
        env={**os.environ, "LD_PRELOAD": str(library), "FULL_DISK": str(folder)},
        capture_output=True,
        text=True,
        check=True,
    )
    ended = dict(line.split() for line in done.stdout.splitlines())
    assert ended.pop("whole") == "0"
    assert len(ended) > 5
    old, new = results(held(before)), results(held(folder / "whole"))
    assert set(old) == set(new)
    assert all(old[name] != new[name] for name in old)
    found: list[dict[str, Any]] = []
    for k, code in ended.items():
        place = folder / k
        assert code == "-9"
        at_once = results(held(place))
        assert at_once.items() <= old.items() or at_once.items() <= new.items()  # never both
        # What is drawn is of one run, and the last one whose values stand.
        drawn = columns_of(place)
        streams = command == "streamed" and results(held(place)) == old and drawn.where.endswith(".npy")
        settle(place)
        found.append(results(held(place)))
        assert found[-1] in (old, new)
        assert streams or drawn.time[-1] == (60.0 if found[-1] == old else 120.0)
    assert new in found
    assert old in found
    # The next run works, whatever it finds.
    for k in [*ended][:: 1 if ALL else 6]:
        ran(*own, "--stop", "2 min", "--out", str(folder / k)).check_returncode()
        left = held(folder / k)
        assert results(left) == new
        assert not [name for name in left if name.startswith(".")]
        (earlier,) = (path for path in (folder / k).iterdir() if path.name not in left)
        # Those of the other command line are kept beside it, whole and once.
        assert earlier.name == "earlier-1"
        assert results(held(earlier)) == old
