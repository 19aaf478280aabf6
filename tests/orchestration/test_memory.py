"""A run of thirty days needs no more memory than one of three."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.system.write import write_ssp

# Private memory: pages of the files that values were streamed to are not counted, for they can be dropped
# at any moment. Sampled beside the run; the imports come first, so that both runs begin alike.
MEASURED = """
import sys, threading
from pathlib import Path
from pyarrow import csv, parquet
from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.simulate import simulate
from warmlink.orchestration.master.compiled import loop as compiled

try:
    compiled.library()
except InputError:
    pass  # without a compiler it takes longer, and no more memory

def private(process="self"):
    # The run is done in a child. What forked processes share is counted once, not in each of them.
    total = 0
    try:
        for line in Path(f"/proc/{process}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss_Anon:"):
                total = int(line.split()[1])
        for task in Path(f"/proc/{process}/task").glob("*/children"):
            total += sum(map(private, task.read_text().split()))
    except OSError:
        pass  # it has just ended
    return total

path, stop, step, folder, checkpoint = sys.argv[1:]
peak, done, before = 0, threading.Event(), private()
def watch():
    global peak
    # In a reading while a child begins or ends, what it shares may count twice: two have to agree.
    last = 0
    while not done.wait(0.03):
        now = private()
        peak, last = max(peak, min(last, now)), now
sampler = threading.Thread(target=watch)
sampler.start()
try:
    simulate(
        Path(path),
        stop=stop,
        step=step,
        master="gauss_seidel",
        out=Path(folder),
        checkpoint=int(checkpoint) or None,
        error_budget=False,
    )
finally:
    done.set()
sampler.join()
print("KIB", peak - before)
"""


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    law = catalogue.controller("lag")
    try:
        files = FmuStore("native").files(WARMUP_CELL.parts_with(law.name).values())
    except InputError as fault:
        pytest.skip(str(fault))
    path = tmp_path_factory.mktemp("cell") / "cell.ssp"
    values = load_scenario("windshield_wiper").values()
    write_ssp(WARMUP_CELL.system(files, law.name, values), path)
    return path


def growth(cell: Path, stop: str, step: str, folder: Path, checkpoint: int) -> float:
    """Private memory in MiB that the run takes beyond what the process had before."""
    arguments = [str(cell), stop, step, str(folder), str(checkpoint)]
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *arguments], capture_output=True, text=True, check=True
    )
    return int(done.stdout.split("KIB", 1)[1]) / 1024


@pytest.mark.slow
@pytest.mark.platform
def test_thirty_days_need_no_more_memory_than_three(cell: Path, tmp_path: Path) -> None:
    """Three fill each block of rows that is written; the values of thirty are ten times as many."""
    if not Path("/proc/self/smaps_rollup").exists():
        pytest.skip("reads the memory of a process as Linux tells it")
    # In hours: days would load the unit library.
    three, thirty = (growth(cell, f"{hours} h", "30 s", tmp_path / str(hours), 3000) for hours in (72, 720))
    rows = 30 * 24 * 120 + 1
    values = (tmp_path / "720" / "values.npy").stat().st_size / 2**20
    assert values > 8 * 35 * rows / 2**20
    assert thirty < three + 0.2 * values, (three, thirty, values)
