"""What a recorded duty costs, from a thousand rows to a million: read, written into an FMU, and in each step.

python -m benchmarks.recorded
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import TypeVar

import numpy as np
import pandas as pd

from benchmarks.command import start
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.packaging.tabled import with_table
from warmlink.fmus.recorded_duty.component import COMPONENT, playing
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.duties.duty import Recorded
from warmlink.orchestration.scenarios.duties.recorded import read_recorded
from warmlink.orchestration.system.assemble import component
from warmlink.orchestration.system.model import DefaultExperiment, System

STEPS = 500_000
PYTHON_STEPS = 5_000

LONGEST = 9000.0
"""s; a longer step is refused by an FMU."""

Found = TypeVar("Found")


@dataclass(frozen=True)
class Cost:
    """Processor time for so many rows: to read them and make an FMU of them in s, in each step in µs.

    Its table is in MB; `begin_s` is what a native FMU takes from unpacking to the first communication point.
    """

    rows: int
    even: bool
    read_csv_s: float
    read_parquet_s: float
    fmu_s: float
    table_mb: float
    begin_s: float
    native_us: float
    python_us: float
    lanes_us: float

    def __str__(self) -> str:
        kind = "evenly" if self.even else "at will"
        return (
            f"{self.rows:>9} {kind:<7}{self.read_csv_s:>9.2f}{self.read_parquet_s:>10.2f}{self.fmu_s:>8.2f}"
            f"{self.table_mb:>8.1f}{self.begin_s:>9.3f}{self.native_us:>11.3f}{self.python_us:>11.2f}"
            f"{self.lanes_us:>10.3f}"
        )


HEAD = (
    f"{'rows':>9} {'come':<7}{'CSV s':>9}{'parquet s':>10}{'FMU s':>8}{'MB':>8}{'begin s':>9}"
    f"{'native µs':>11}{'Python µs':>11}{'lanes µs':>10}"
)


def measured(rows: int, even: bool, folder: Path) -> Cost:
    """Measure a duty of so many rows, one a second on average, whose speed, torque and surroundings vary."""
    generator = np.random.default_rng(rows)
    steps = np.ones(rows) if even else generator.uniform(0.01, 1.99, rows)
    speed = generator.uniform(0, 4, rows).round(4)
    frame = pd.DataFrame(
        {
            "time [s]": np.round(np.cumsum(steps), 3),
            "speed [rad/s]": speed,
            "torque [N.m]": (0.8 * speed + generator.uniform(0, 1, rows)).round(4),
            "ambient_temperature [degC]": 22 + np.sin(np.arange(rows) / 3000).round(3),
        }
    )
    frame.to_csv(folder / "shift.csv", index=False)
    frame.to_parquet(folder / "shift.parquet")
    read_csv_s, _ = timed(lambda: read_recorded(folder / "shift.csv"))
    read_parquet_s, duty = timed(lambda: read_recorded(folder / "shift.parquet", ["ambient_temperature"]))
    assert isinstance(duty, Recorded)
    plain = FmuStore("native").files([COMPONENT.name])[COMPONENT.name]
    fmu_s, fmu = timed(lambda: with_table(plain, duty.table))
    few = 1 + int(duty.table.end / LONGEST)
    long, short = (stepped(fmu, duty.table.end, count) for count in (STEPS, few))
    instants = np.linspace(0.0, duty.table.end, STEPS)
    lanes_s, _ = timed(lambda: duty.table.over(instants))
    whole = playing(COMPONENT, duty.table)
    shutil.rmtree(fmu.parent)
    return Cost(
        rows=rows,
        even=even,
        read_csv_s=read_csv_s,
        read_parquet_s=read_parquet_s,
        fmu_s=fmu_s,
        table_mb=len(whole.tables[0].content) / 1e6,
        begin_s=short,
        native_us=1e6 * (long - short) / (STEPS - few),
        python_us=in_python(Instance(whole), duty.table.end),
        lanes_us=1e6 * lanes_s / STEPS,
    )


def stepped(fmu: Path, end: float, count: int) -> float:
    """Time in s of a run of the FMU alone, in so many steps; the best of three."""
    system = System("Alone", {"duty": component("duty", fmu)}, (), DefaultExperiment(0.0, end, end / count))

    def run() -> None:
        simulate(system, end, end / count, algorithm("gauss_seidel"), record=["duty.speed"])

    return min(timed(run)[0] for _ in range(3))


def in_python(instance: Instance, end: float) -> float:
    """Time in µs of a step with its outputs."""
    step = min(1.0, end / PYTHON_STEPS)
    instance.initialize()
    began = process_time()
    for k in range(PYTHON_STEPS):
        instance.step(k * step, step)
        instance.outputs()
    return 1e6 * (process_time() - began) / PYTHON_STEPS


def timed(action: Callable[[], Found]) -> tuple[float, Found]:
    """Processor time in s that an action takes, and what it gives."""
    began = process_time()
    found = action()
    return process_time() - began, found


def main(most: int = 1_000_000) -> None:
    """Print the table, up to so many rows."""
    print(HEAD)
    sizes = [10**power for power in range(3, 10) if 10**power <= most]
    for rows in sizes:
        for even in (True, False):
            with tempfile.TemporaryDirectory(prefix="warmlink-") as folder:
                print(measured(rows, even, Path(folder)), flush=True)


if __name__ == "__main__":
    start(main)
