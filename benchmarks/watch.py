"""False alarms of `warmlink watch` over sound days, and how soon and under which name it finds faults.

The machines are those of `strange_machine.py`, whose structure is another than that of the model that
watches them: every figure is for a filter whose equations are wrong. Their rooms wander, their thermometers
round, and their loggers write rows now and then.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.strange_machine import STEP, Demand, Machine, Room, Run
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.hypotheses import watched
from warmlink.orchestration.watch.sources.rows import RowReader
from warmlink.orchestration.watch.state import saved
from warmlink.orchestration.watch.ticks import Gatherer
from warmlink.orchestration.watch.watcher import Watcher, twin_of
from warmlink.orchestration.watch.watching import STATE

Array = NDArray[np.float64]

DAY = 86400.0
ONSET = 30000.0
"""s of a day at which a fault begins."""

_NAMED = 54000.0
"""s after an alarm at which its name is taken."""

_SPACING = 20.0
"""s between rows, on average: from half of it to half as much again."""

HEADERS = (
    "time [s]",
    "speed [rad/s]",
    "torque [N.m]",
    "ambient_temperature [degC]",
    "shaft_temperature [degC]",
    "winding_temperature [degC]",
    "base_temperature [degC]",
    "middle_temperature [degC]",
    "tip_temperature [degC]",
    "elongation [um]",
)
_READ = 4
"""Columns before those that are measured."""


@dataclass(frozen=True)
class MachineFault:
    """A fault: what is multiplied of the machine, or what happens to its rows; and the right names."""

    names: frozenset[str]
    factors: tuple[tuple[str, float], ...] = ()
    on_rows: Callable[[Array, float], Array] | None = None
    late: float = 0.0


def _drifting(rows: Array, began: float) -> Array:
    rows = rows.copy()
    rows[:, 6] += 0.5 / 3600 * np.maximum(rows[:, 0] - began, 0.0)
    return rows


SOUND = MachineFault(frozenset())

FAULTS = {
    # A fifth less conducts from the rotor to the plate: of three in series this one falls by a third.
    "joint loosens by 20 %": MachineFault(frozenset({"joint_resistance"}), (("flange_plate", 2 / 3),)),
    "friction +30 %": MachineFault(
        frozenset({"friction_level", "input_scale:speed"}), (("coulomb", 1.3), ("viscous", 1.3))
    ),
    "thermometer drifts by 0.5 K/h": MachineFault(
        frozenset({"sensor_drift:base_temperature", "sensor_offset:base_temperature"}), on_rows=_drifting
    ),
    "logger's clock jumps by 60 s": MachineFault(
        frozenset({"clock_offset", "clock_offset:link", "clock_offset:motor"}), late=60.0
    ),
    "motor's fan stops": MachineFault(frozenset({"housing_heat_loss"}), (("rotor_room", 0.6),)),
}


def worn(machine: Machine, **factors: float) -> Machine:
    """The same machine with some of its parameters multiplied; all else is as it was drawn."""
    other = Machine(machine.seed)
    other.p = {**machine.p, **{name: machine.p[name] * factor for name, factor in factors.items()}}
    other.join()
    return other


def demands(seed: int, day: int) -> list[Demand]:
    """Two shifts of batches of random work, then a night."""
    draw = np.random.default_rng([seed, day, 99])
    found, lasted = list[Demand](), 0.0
    while lasted < 57600:
        work, rest = float(draw.uniform(300, 5400)), float(draw.uniform(60, 1500))
        speed, torque = (float(each) for each in draw.uniform((1.0, 0.8), (4.4, 3.4)))
        found += [Demand(work, speed, torque), Demand(rest)]
        lasted += work + rest
    return [*found, Demand(max(DAY - lasted, 60.0))]


def rows_of(run: Run, draw: np.random.Generator, late: float, spacing: float = _SPACING) -> Array:
    """Rows as a logger writes them, in the units of `HEADERS`; readings come late by some s."""
    machine, lasting = run.machine, len(run.rows) * STEP
    began = (run.steps - len(run.rows)) * STEP
    times = np.cumsum(draw.uniform(0.5, 1.5, int(lasting / spacing * 1.1)) * spacing)
    times = times[times < lasting]
    steps, at = STEP * np.arange(len(run.rows) + 1), (times / STEP).astype(int)
    seen = np.clip(times - late, 0.0, None)
    table = np.empty((times.size, len(HEADERS)))
    table[:, 0] = np.round(began + times, 2)
    for column, name in ((1, "speed"), (2, "torque")):
        values = np.array([getattr(each, name) for each in run.rows])
        table[:, column] = values[at] * machine.duty_scale[column - 1]
    air = run.air[at]
    table[:, 3] = np.round(air + machine.air_bias + draw.normal(0, 0.02, times.size), 3)
    for i, true in enumerate(run.places().values()):
        read = np.interp(seen - machine.lags[i], steps, true)
        read = read - machine.stems[i] * (read - air) + machine.offsets[i] + draw.normal(0, 0.1, times.size)
        table[:, _READ + i] = np.round(16 * read) / 16
    torque = np.array([each.torque for each in run.rows])
    grown = 1e6 * np.interp(seen, steps, machine.growth(run.history, np.append(torque[:1], torque)))
    table[:, -1] = np.round(grown + draw.normal(0, 0.5, times.size), 3)
    return table


@dataclass
class WatchedCell:
    """A machine at work under a logger, and what watches it.

    Attributes
    ----------
    run : the last stretch, None at the start
    """

    seed: int
    machine: Machine
    draw: np.random.Generator
    watcher: Watcher
    gatherer: Gatherer
    reader: RowReader
    run: Run | None = None

    @classmethod
    def made(cls, seed: int, sound_days: float, rate: float, tick: float = 60.0) -> WatchedCell:
        """A sound machine with a watcher that has seen nothing yet."""
        rig = rig_of("WarmupCell")
        reader = RowReader("log", HEADERS, rig, ReadOptions())
        machine = watched(rig, {}, reader.inputs, reader.readings, reader.names, tick)
        watcher = Watcher(machine, sound_days * DAY, rate)
        draw = np.random.default_rng([seed, 48])
        return cls(seed, Machine(seed), draw, watcher, Gatherer(rig, {}, reader.readings, tick), reader)

    def fork(self) -> WatchedCell:
        """The same, to go on by itself."""
        watcher = replace(
            self.watcher,
            shadow=twin_of(self.watcher.shadow) if self.watcher.shadow else None,
            test=deepcopy(self.watcher.test),
            standing=None,
            recent=deque(self.watcher.recent),
            snapshots=deque(self.watcher.snapshots),
        )
        return replace(self, draw=deepcopy(self.draw), watcher=watcher, gatherer=deepcopy(self.gatherer))

    def works(
        self, work: Sequence[Demand], fault: MachineFault = SOUND, since: float = 0.0
    ) -> Iterator[dict[str, Any]]:
        """Events while the machine works through demands; of a fault that is there since so many s."""
        machine = worn(self.machine, **dict(fault.factors)) if fault.factors else self.machine
        self.run = machine.run(list(work), self.seed, Room(swing=1.0), self.run)
        rows = rows_of(self.run, self.draw, fault.late)
        for row in (fault.on_rows(rows, since) if fault.on_rows else rows).tolist():
            read = self.reader.read(row)
            for tick in self.gatherer.add(read) if read else ():
                yield from self.watcher.add(tick)


def _cut(work: Sequence[Demand], at: float) -> tuple[list[Demand], list[Demand]]:
    """Demands before and after a time in s."""
    before, after = list[Demand](), list[Demand]()
    for each in work:
        first = min(max(at, 0.0), each.duration)
        before += [replace(each, duration=first)] if first >= STEP else []
        after += [replace(each, duration=each.duration - first)] if each.duration - first >= STEP else []
        at -= each.duration
    return before, after


def sound_days(
    seed: int, days: int, known: int, rate: float, tick: float
) -> tuple[WatchedCell, list[dict[str, Any]]]:
    """A cell after so many sound days, of which some are declared sound, and its false alarms."""
    cell = WatchedCell.made(seed, known, rate, tick)
    found = [each for day in range(days) for each in cell.works(demands(seed, day))]
    return cell, [each for each in found if each["alarm"] and "again" not in each]


def faulty(
    cell: WatchedCell, fault: MachineFault, day: int, hours: float
) -> tuple[float | None, list[tuple[str, ...]]]:
    """Time in s until an alarm, None without one, and its names, of a fault amid a shift."""
    fork, began, names, found = cell.fork(), DAY * day + ONSET, list[tuple[str, ...]](), None
    before, after = _cut(demands(fork.seed, day), ONSET)
    for _ in fork.works(before):
        pass
    until, more = began + 3600 * hours, range(day + 1, day + 1 + math.ceil(hours / 24))
    for work in (after, *(demands(fork.seed, later) for later in more)):
        for each in fork.works(work, fault, began):
            if each["alarm"] and each["time_s"] <= until:
                if found is None:
                    found, until = each["time_s"] - began, min(until, each["time_s"] + _NAMED)
                names.append(tuple(cause["name"] for cause in each["causes"]))
        if fork.run is not None and fork.run.steps * STEP > until:
            break
    return found, names


def machines_per_core(hours: float = 2.0) -> float:
    """How many machines that log each second one core can watch, the state of each written every minute."""
    cell = WatchedCell.made(1, 4 / 24, 1 / 30)
    for _ in cell.works([Demand(1800, 3.0, 2.0), Demand(900)] * 6):
        pass
    cell.run = cell.machine.run([Demand(1800, 3.0, 2.0), Demand(1800)] * int(hours), 1, Room(), cell.run)
    rows = rows_of(cell.run, cell.draw, 0.0, spacing=1.0).tolist()
    assert cell.watcher.test is not None
    with TemporaryDirectory() as folder:
        begun = process_time()
        for k, row in enumerate(rows):
            read = cell.reader.read(row)
            for tick in cell.gatherer.add(read) if read else ():
                for _ in cell.watcher.add(tick):
                    pass
            if k % 60 == 0:
                saved(Path(folder) / STATE, {}, cell.watcher, cell.gatherer, {})
        return len(rows) / (process_time() - begun)


def main() -> None:
    """Print false alarms by seed, then the table of faults; or the rate."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=3, help="machines")
    options.add_argument("--first", type=int, default=1, help="seed of the first machine")
    options.add_argument("--days", type=int, default=30, help="sound days after those declared sound")
    options.add_argument("--known", type=int, default=7, help="days that are declared sound")
    options.add_argument("--tick", type=float, default=120.0, help="s of the log that are judged at once")
    options.add_argument(
        "--hours", type=float, default=120.0, help="hours in which a fault may be found; 0: none"
    )
    options.add_argument("--rate", action="store_true", help="how many machines a core watches, alone")
    given = options.parse_args()
    if given.rate:
        print(f"{machines_per_core():.0f} machines that log each second, on one core")
        return
    rows: dict[str, list[tuple[float | None, list[tuple[str, ...]]]]] = {name: [] for name in FAULTS}
    false = Counter[int]()
    for seed in range(given.first, given.first + given.seeds):
        begun = process_time()
        cell, early = sound_days(seed, given.known + 1, given.known, 1 / 30, given.tick)
        for name, fault in FAULTS.items() if given.hours else ():
            rows[name].append(faulty(cell, fault, given.known + 1, given.hours))
            print(seed, name, *_answer(fault, *rows[name][-1]), flush=True)
        later = (
            each
            for day in range(given.known + 1, given.known + given.days)
            for each in cell.works(demands(seed, day))
        )
        for each in (*early, *later):
            if each["alarm"] and "again" not in each:
                false[seed] += 1
                print(seed, "false alarm", f"{each['time_s'] / DAY:.2f} d", each["told"], flush=True)
        took = f"{process_time() - begun:.0f} s"
        print(seed, f"{false[seed]} false alarms in {given.days} days; {took}", flush=True)
    print(f"\nfalse alarms: {false.total()} in {given.seeds} x {given.days} days")
    for name, fault in FAULTS.items() if given.hours else ():
        print(_line(name, fault, rows[name]))


def _answer(fault: MachineFault, found: float | None, names: list[tuple[str, ...]]) -> tuple[str, str, str]:
    """When, how well and as what a fault was found."""
    if found is None:
        return "-", "missed", ""
    last = names[-1]
    right = fault.names & set(last)
    how = (
        "unknown"
        if not last
        else "wrong"
        if not right
        else "named"
        if set(last) <= fault.names
        else "in the set"
    )
    return f"{found / 60:.0f} min", how, " or ".join(last)


def _line(name: str, fault: MachineFault, found: list[tuple[float | None, list[tuple[str, ...]]]]) -> str:
    answers = [_answer(fault, *each)[1] for each in found]
    minutes = sorted(each[0] / 60 for each in found if each[0] is not None)
    median = f"{minutes[len(minutes) // 2]:.0f} min, {minutes[-1]:.0f} at most" if minutes else "-"
    counts = [str(answers.count(each)) for each in ("named", "in the set", "unknown", "wrong", "missed")]
    return f"| {name} | {median} | {' | '.join(counts)} |"


if __name__ == "__main__":
    main()
