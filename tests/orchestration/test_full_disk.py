"""The disk is full from the k-th write on, for every k: what was computed is there, or its loss is told."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks.trivial_fmu import build_trivial_fmu
from tests.warm import ran
from warmlink.fmus.errors import InputError
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.model import (
    Connection,
    DefaultExperiment,
    FmuPart,
    System,
)
from warmlink.orchestration.system.write import write_ssp

pytestmark = [
    pytest.mark.platform,
    pytest.mark.skipif(sys.platform != "linux" or shutil.which("gcc") is None, reason="needs Linux and gcc"),
]

ALL = "WARMLINK_EVERY_WRITE" in os.environ
"""Whether a long command is disturbed at every write, which takes minutes, or at every seventeenth."""

# In one process, which the library is loaded into; a first run counts the writes.
EVERY_WRITE = """
import ctypes, contextlib, io, json, os, shutil, sys
from pathlib import Path
library, folder, before, stride, *argv = sys.argv[1:]
from warmlink.orchestration import cli
shim = ctypes.CDLL(library)
shim.full_disk_counters.restype = ctypes.POINTER(ctypes.c_long)
counters = shim.full_disk_counters()
def once(fail_at):
    shutil.rmtree(folder, ignore_errors=True)
    if before:
        shutil.copytree(before, folder)
    else:
        Path(folder).mkdir()
    counters[0], counters[1] = 0, fail_at
    out, err = io.StringIO(), io.StringIO()
    sys.argv = ["warmlink", *argv, "--out", folder]
    code = None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            cli.main()
        except SystemExit as end:
            code = end.code
    made, counters[1] = counters[0], 1 << 60
    within = [path for path in Path(folder).rglob("*") if path.is_file()]
    files = {path.relative_to(folder).as_posix(): path.read_bytes().hex() for path in within}
    found = {"code": code, "out": out.getvalue(), "err": err.getvalue(), "files": files}
    print(json.dumps(found), flush=True)
    return made
count = once(1 << 60)
for k in sorted({*range(0, count, int(stride)), count - 1}):
    once(k)
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("shim") / "full_disk.so"
    source = Path(__file__).with_name("full_disk.c")
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", str(source), "-o", str(path), "-ldl"], check=True)
    return path


def at_every_write(
    library: Path, tmp_path: Path, *argv: str, stride: int = 1, before: Path | None = None
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """What came of an undisturbed run, and of each in which the disk was full from the k-th write on.

    What lies in the folder `before` lies in that of the results when a run begins.
    """
    folder = tmp_path / "full" / "out"
    folder.parent.mkdir()
    environment = {**os.environ, "LD_PRELOAD": str(library), "FULL_DISK": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", EVERY_WRITE, str(library), str(folder), str(before or ""), str(stride), *argv],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=None if ALL else 240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    whole, *disturbed = map(json.loads, done.stdout.splitlines())
    assert whole["code"] == 0, whole["err"]
    return whole, disturbed


def check(whole: dict[str, Any], disturbed: dict[str, Any], names: tuple[str, ...]) -> None:
    said, files = disturbed["err"], disturbed["files"]
    assert "Traceback" not in said
    assert disturbed["code"] in (1, 2), disturbed
    assert "o space left on device" in said
    for name in names:
        # Each file is there to the last byte, or its loss is told.
        if name in files:
            assert files[name] == whole["files"][name], name
        else:
            assert name in said or "there are no results" in said or disturbed["code"] == 2, (name, said)
    assert not [name for name in files if name.endswith(".new")]


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("system")
    try:
        fmu = build_trivial_fmu(folder)
    except InputError as fault:
        pytest.skip(str(fault))
    parts = {"a": FmuPart("a", fmu), "b": FmuPart("b", fmu)}
    wires = (Connection("a", "y", "b", "u"),)
    write_ssp(System("two", parts, wires, DefaultExperiment(0.0, 300.0, 1.0)), folder / "two.ssp")
    return folder / "two.ssp"


@pytest.mark.slow
def test_simulate(library: Path, system: Path, tmp_path: Path) -> None:
    whole, disturbed = at_every_write(library, tmp_path, "simulate", str(system), "--no-error-budget")
    assert len(disturbed) >= 4
    for each in disturbed:
        check(whole, each, ("results.csv", "results.parquet"))
    assert disturbed[0]["code"] == 2  # before anything is computed
    assert all("a.y" in each["out"] for each in disturbed[1:])  # the answer is given nevertheless


@pytest.mark.slow
def test_simulate_with_checkpoints(library: Path, system: Path, tmp_path: Path) -> None:
    options = ("--checkpoint", "100", "--no-error-budget")
    whole, disturbed = at_every_write(library, tmp_path, "simulate", str(system), *options)
    assert len(disturbed) >= 12
    for each in disturbed:
        said = each["err"]
        if "stopped early" in said:
            assert "cannot be written any more (No space left on device)" in said
            assert each["code"] == 1
            assert bytes.fromhex(each["files"]["values.npy"])[:6] == b"\x93NUMPY"
            assert "Traceback" not in said
        else:
            check(whole, each, ("results.csv", "results.parquet"))


@pytest.mark.slow
def test_run(library: Path, tmp_path: Path) -> None:
    try:
        FmuStore("native").files(["ThermalLink"])
    except InputError as fault:
        pytest.skip(str(fault))
    # A law whose page no other test compiles meanwhile: the report would hold it from then on.
    command = ("run", "windshield_wiper", "--controller", "analytic", "--stop", "2 min", "--step", "10 s")
    whole, disturbed = at_every_write(library, tmp_path, *command, stride=1 if ALL else 17)
    names = ("metrics.json", "results.csv", "results.parquet", "report.html")
    for each in (whole, *disturbed):
        if "metrics.json" in each["files"]:
            each["files"]["metrics.json"] = (
                len(each["files"]["metrics.json"]) > 1000
            )  # it holds the wall time
    for each in disturbed:
        check(whole, each, names)
    assert disturbed[0]["code"] == 2  # before anything is computed
    assert all("largest error" in each["out"] for each in disturbed[1:])


def comparable(files: dict[str, str]) -> dict[str, str]:
    """Files by name, without what differs between runs of the same: how long they took."""
    metrics = files.get("metrics.json")
    told = {**json.loads(bytes.fromhex(metrics)), "wall_seconds": 0.0} if metrics else None
    return {**files, **({"metrics.json": json.dumps(told)} if told else {})}


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "simulate"])
def test_results_of_an_earlier_run_stay_where_new_ones_cannot_be_written(
    library: Path, system: Path, tmp_path: Path, command: str
) -> None:
    try:
        FmuStore("native").files(["ThermalLink"])
    except InputError as fault:
        pytest.skip(str(fault))
    own = {
        "run": ["run", "windshield_wiper", "--controller", "analytic", "--no-report", "--step", "10 s"],
        "simulate": ["simulate", str(system), "--no-error-budget"],
    }[command]
    before = tmp_path / "before"
    ran(*own, "--stop", "1 min", "--out", str(before)).check_returncode()
    old = comparable({path.name: path.read_bytes().hex() for path in before.iterdir()})
    stride = 1 if ALL else 5
    whole, disturbed = at_every_write(
        library, tmp_path, *own, "--stop", "2 min", stride=stride, before=before
    )
    found = comparable(whole["files"])
    new = {name: content for name, content in found.items() if "/" not in name}
    kept = {name.partition("/")[2]: each for name, each in whole["files"].items() if "/" in name}
    assert comparable(kept) == old
    assert set(new) == set(old)
    assert {name for name in found if "/" in name} == {f"earlier-1/{name}" for name in old}
    assert all(new[name] != old[name] for name in new)
    assert len(disturbed) > 1
    for each in disturbed:
        assert "Traceback" not in each["err"]
        assert each["code"] in (1, 2)
        assert comparable(each["files"]) == old, each["err"]
        assert "o space left on device" in each["err"]
