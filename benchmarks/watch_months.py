"""What a watch of months needs: resident memory and the size of its files, month after month.

A week of the made-up machine's sound rows is replayed again and again, as one log: with reader, filter, test,
state, alarms and page as `warmlink watch` has them.
"""

from __future__ import annotations

import argparse
import gc
import resource
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.strange_machine import Machine, Room
from benchmarks.watch import DAY, HEADERS, demands, rows_of
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.page import PAGE, write_watch
from warmlink.orchestration.watch.sources.rows import Cells
from warmlink.orchestration.watch.watching import ALARMS, JOURNAL, STATE, Watching, WatchOptions

WEEK, MONTH = 7, 30
"""Days that are simulated, and days from one figure to the next."""


class Month(NamedTuple):
    """At the end of a month: days and alarms so far, resident memory in MB, and sizes of files in kB."""

    days: int
    alarms: int
    resident: float
    files: dict[str, float]


class Replayed:
    """A week of rows again and again, as a server would give them, which cannot go back.

    Parameters
    ----------
    week : its rows
    days : that are replayed
    at_month : called at the end of each month, with the days so far
    """

    headers: Sequence[str] = HEADERS
    name, comma = "replay", False

    def __init__(self, week: NDArray[np.float64], days: int, at_month: Callable[[int], None]) -> None:
        self._week, self._days, self._at_month = week, days, at_month
        self.told: list[str] = []

    def rows(self) -> Iterator[Cells | None]:
        """Rows without a pause; None, so that what is due is written, once a day."""
        day = 0
        for begin in range(0, self._days, WEEK):
            for time, *rest in self._week.tolist():
                if begin + time / DAY >= day + 1:
                    day += 1
                    yield None
                    if day % MONTH == 0:
                        self._at_month(day)
                if day == self._days:
                    return
                yield [begin * DAY + time, *rest]

    def place(self) -> None:
        """None: it cannot go back."""

    def close(self) -> None:
        """Nothing is open."""


def months(days: int, spacing: float, tick: float, seed: int = 1) -> Iterator[Month]:
    """Figures at the end of each month of a replay with a row every so many s."""
    machine, draw = Machine(seed), np.random.default_rng([seed, 90])
    run = machine.run([each for day in range(WEEK) for each in demands(seed, day)], seed, Room(swing=1.0))
    week = rows_of(run, draw, 0.0, spacing)
    week = week[week[:, 0] < WEEK * DAY]
    del run
    found = list[Month]()

    def measure(day: int) -> None:
        watching.write()
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        resident = pages * resource.getpagesize() / 1e6
        sizes = {n: (folder / n).stat().st_size / 1e3 for n in (STATE, JOURNAL, ALARMS, PAGE)}
        found.append(Month(day, len(watching.alarms), resident, sizes))

    with TemporaryDirectory(prefix="warmlink-") as home:
        folder = Path(home)
        asked = WatchOptions(
            rig_of("WarmupCell"), {}, ReadOptions(), WEEK * DAY, 1 / 30, tick, until_end=True
        )
        watching = Watching(Replayed(week, days + 1, measure), asked, folder, write_watch)
        for _ in watching.run():
            while found:
                yield found.pop(0)
        yield from found


def main() -> None:
    """Print a line for each month."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--days", type=int, default=180, help="days of the log")
    options.add_argument("--spacing", type=float, default=300.0, help="s between rows, on average")
    options.add_argument("--tick", type=float, default=900.0, help="s of the log that are judged at once")
    given = options.parse_args()
    print("days  alarms  resident MB  " + "  ".join(f"{each} kB" for each in (STATE, JOURNAL, ALARMS, PAGE)))
    for month in months(given.days, given.spacing, given.tick):
        sizes = "  ".join(f"{each:.0f}".rjust(len(n) + 3) for n, each in month.files.items())
        print(f"{month.days:4d}  {month.alarms:6d}  {month.resident:11.1f}  {sizes}", flush=True)


if __name__ == "__main__":
    main()
