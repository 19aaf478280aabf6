"""Streams, checkpoints, kills at any moment, Ctrl-C, and the clock on the wall."""

from __future__ import annotations

import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
import zipfile
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.orchestration.master.streamed import read_folder
from warmlink.fmus.arguments import speaking_of_options
from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import OPTIONS
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton
from warmlink.orchestration.master.assembly import Assembly
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.checkpoint import LongRun, fingerprint
from warmlink.orchestration.master.recording.recorder import values_in
from warmlink.orchestration.master.recording.result import RecordTable
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.system.description import Capabilities
from warmlink.orchestration.system.model import Connector, FmuPart, System

from .mock import MockSlave
from .motor_link import motor_link
from .pairs import assembly, counter, wire

WIRES = (wire("a.y -> b.u"), wire("b.y -> a.u", factor=-1.0))
KILLS = int(os.environ.get("WARMLINK_KILLS", "3"))


def pair(fmu: Path) -> System:
    start = {"y": 1.0}
    return System("s", {"a": FmuPart("a", fmu, {}, start), "b": FmuPart("b", fmu)}, WIRES)


def test_streamed_values_are_those_of_a_run_in_memory(tmp_path: Path) -> None:
    slaves = [counter("x", 1e-3), counter("z", -1e-3)]
    wires = (wire("x.y -> z.u"), wire("z.y -> x.u", offset=1.0))
    kept = simulate(assembly(slaves, *wires), 10_000.0, 1.0, GaussSeidel())
    slaves = [counter("x", 1e-3), counter("z", -1e-3)]
    streamed = simulate(
        assembly(slaves, *wires), 10_000.0, 1.0, GaussSeidel(), long_run=LongRun(tmp_path / "run", every=None)
    )
    np.testing.assert_array_equal(kept.table.values, streamed.table.values)
    np.testing.assert_array_equal(kept.times, streamed.times)
    again = read_folder(tmp_path / "run")
    assert again.names == kept.table.names
    np.testing.assert_array_equal(again.values, kept.table.values)
    assert isinstance(streamed.table.values, np.memmap)


def test_values_in_a_folder_have_the_times_of_steps_that_differ(tmp_path: Path) -> None:
    """Told were the longest step and their number alone, from which other times were made."""
    times = [5.0, 6.0, 6.25, 10.0]
    ran = simulate(
        assembly([counter("x", 1e-3)]),
        10.0,
        times,
        start_time=5.0,
        long_run=LongRun(str(tmp_path), every=None),
    )
    found = values_in(tmp_path)
    assert found is not None
    np.testing.assert_array_equal(found.times, times)
    np.testing.assert_array_equal(found.values, ran.table.values)


def test_another_run_into_the_folder_leaves_the_values_of_the_one_before(tmp_path: Path) -> None:
    folder = LongRun(tmp_path / "run", every=None)
    first = simulate(motor_link(1.0), 300.0, 1.0, GaussSeidel(), long_run=folder)
    before = np.array(first.table.values)
    second = simulate(motor_link(0.5), 300.0, 1.0, GaussSeidel(), long_run=folder)
    np.testing.assert_array_equal(first.table.values, before)
    assert not np.array_equal(second.table.values, before)


class Failing:
    """Raises once at a time of its own choosing: a run that dies there."""

    def __init__(self, at: float) -> None:
        self.at = at

    def advance(self, x: float, u: Any, t: float, h: float) -> float:
        if t >= self.at:
            raise SlaveError("watch", "error", t, "killed")
        return x


@pytest.mark.parametrize(
    "algorithm",
    [
        Jacobi(),
        FixedPoint(interpolation=2),
        InterfaceNewton(),
        StepDoubling(InterfaceNewton(), {"link.elongation": 1e-8}, minimum_step=1e-3),
    ],
    ids=str,
)
def test_a_resumed_run_is_bit_identical(tmp_path: Path, algorithm: Algorithm) -> None:
    def system(death: float) -> Any:
        found = motor_link(1.0)
        found.slaves = [*found.slaves, MockSlave("watch", state=0.0, advance=Failing(death).advance)]
        return found

    record = ["link.elongation", "motor.heat_flow"]
    whole = simulate(system(np.inf), 100.0, 1.0, algorithm, record=record)
    folder = tmp_path / "run"
    for death in (33.0, 71.0):
        part = simulate(
            system(death), 100.0, 1.0, algorithm, record=record, long_run=LongRun(folder, 10, resume=True)
        )
        assert part.status == "stopped"
        assert len(read_folder(folder)) == death + 1
    last = simulate(
        system(np.inf), 100.0, 1.0, algorithm, record=record, long_run=LongRun(folder, 10, resume=True)
    )
    assert last.status == "completed"
    np.testing.assert_array_equal(
        whole.table.values.view(np.uint64), np.array(last.table.values).view(np.uint64)
    )
    assert last.statistics.slave_steps >= whole.statistics.slave_steps - 1


@pytest.mark.parametrize("more", [10, 0])
def test_stability_of_a_resumed_run_is_tried_from_where_it_went_on(tmp_path: Path, more: int) -> None:
    stepped: list[float] = []

    def advance(x: float, u: Any, t: float, h: float) -> float:
        stepped.append(t)
        if t == 20.0 and dies:
            raise SlaveError("a", "error", t, "killed")
        return float(x + h * (float(u["u"]) - x) / 10)

    def system() -> Assembly:
        slave = MockSlave(
            "a", inputs={"u": 1.0}, outputs={"y": lambda x, u, t: x}, state=0.0, advance=advance
        )
        return assembly([slave, counter("b", 1e-3)], *WIRES)

    dies, long_run = more > 0, LongRun(tmp_path / "run", 10, resume=True)
    assert simulate(system(), 30.0, 1.0, long_run=long_run).status == ("stopped" if dies else "completed")
    dies = False
    stepped.clear()
    assert simulate(system(), 30.0, 1.0, long_run=long_run).status == "completed"
    assert stepped == [*np.arange(30.0 - more, 30.0)] * 3, "once, and twice more to compare"


KILLED = """
import sys
from pathlib import Path
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.algorithms.iterated import FixedPoint
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.model import Connection, FmuPart, System
fmu, folder = map(Path, sys.argv[1:3])
start = {"y": 1.0}
wires = (Connection("a", "y", "b", "u"), Connection("b", "y", "a", "u", -1.0))
system = System("s", {"a": FmuPart("a", fmu, {}, start), "b": FmuPart("b", fmu)}, wires)
print("go", flush=True)
result = simulate(system, 12.0, 0.002, FixedPoint(), long_run=LongRun(folder, every=300, resume=True))
print(result.status, result.reason, len(result.times), flush=True)
"""


@pytest.mark.slow
def test_kills_at_random_moments_change_nothing(trivial2: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    command = [sys.executable, "-c", KILLED, str(trivial2), str(folder)]
    seeded, kills = random.Random(7), 0
    while kills < KILLS:
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "go\n"
            time.sleep(seeded.uniform(0.0, 0.4))
            process.send_signal(signal.SIGKILL)
        kills += 1
        if (folder / "values.npy").exists() and (folder / "values.npy").stat().st_size > 128:
            read_folder(folder)
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "completed None 6001" in done.stdout
    whole = simulate(pair(trivial2), 12.0, 0.002, FixedPoint())
    np.testing.assert_array_equal(whole.table.values, read_folder(folder).values)


def test_a_damaged_checkpoint_is_refused_or_changes_nothing(tmp_path: Path) -> None:
    long_run = LongRun(tmp_path / "run", every=2, resume=True)

    def run() -> RecordTable:
        return simulate(assembly([counter("x")]), 5.0, 1.0, long_run=long_run).table

    whole = np.array(run().values)
    size, header = 8 * (tmp_path / "run" / "checkpoint").stat().st_size, 8 * 128
    bits = {
        "checkpoint": range(0, size, 53),
        "values.npy": [*range(0, header, 31), *range(header, header + 8 * whole.nbytes)],
    }
    refused = dict.fromkeys(bits, 0)
    for name in refused:
        path = tmp_path / "run" / name
        sound = {each: each.read_bytes() for each in (tmp_path / "run").iterdir()}
        for bit in bits[name]:
            data = bytearray(sound[path])
            data[bit // 8] ^= 1 << bit % 8
            path.write_bytes(data)
            try:
                np.testing.assert_array_equal(run().values, whole)
            except InputError as refusal:
                refused[name] += f"{path}: is" in str(refusal)
            for each, content in sound.items():
                each.write_bytes(content)
    assert refused["checkpoint"] == len(bits["checkpoint"])
    # Five rows are what the checkpoint counts on; the header and the last row are written anew.
    assert refused["values.npy"] == 8 * 8 * 5


def test_an_fmu_built_anew_with_the_same_guid_is_another_run(trivial2: Path, tmp_path: Path) -> None:
    fmu = tmp_path / "other.fmu"
    shutil.copyfile(trivial2, fmu)
    long_run = LongRun(tmp_path / "run", every=5, resume=True)
    simulate(pair(fmu), 1.0, 0.1, long_run=long_run)
    simulate(pair(fmu), 1.0, 0.1, long_run=long_run)
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("resources/changed", "1")
    with pytest.raises(InputError, match=r"belongs to another run .*FMU files"):
        simulate(pair(fmu), 1.0, 0.1, long_run=long_run)


@pytest.mark.parametrize("field", [each.name for each in fields(FmuPart)])
def test_whatever_a_part_says_of_itself_marks_its_run(field: str, tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / name).write_text(name)
    changed: dict[str, Any] = {
        **{"name": "b", "fmu": tmp_path / "other", "connectors": {"h": Connector("output")}},
        **{"values": {"u": 1.0}, "implementation": "ModelExchange"},
    }
    part = FmuPart("a", tmp_path / "one")
    one, other = (
        fingerprint(Assembly([], parts={"a": each}), [], CommunicationPoints(0.0, 0.1, 10), Jacobi(), None)
        for each in (part, replace(part, **{field: changed[field]}))
    )
    assert one != other


def test_ctrl_c_leaves_valid_results(trivial2: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    result = simulate(pair(trivial2), 1e6, 1e-3, FixedPoint(), long_run=LongRun(folder))
    timer.join()
    assert result.status == "stopped"
    assert str(result.reason).startswith("interrupted at ")
    assert len(result.times) > 1
    np.testing.assert_array_equal(read_folder(folder).values, result.table.values)


def test_a_checkpoint_of_another_run_is_refused(tmp_path: Path) -> None:
    long_run = LongRun(tmp_path / "run", every=5, resume=True)
    simulate(assembly([counter("x")]), 10.0, 1.0, long_run=long_run)
    with pytest.raises(InputError, match="belongs to another run"):
        simulate(assembly([counter("x")], x={"u": 2.0}), 10.0, 1.0, long_run=long_run)
    # Slaves are told the stop time and may keep it in their state.
    with pytest.raises(InputError, match="belongs to another run"):
        simulate(assembly([counter("x")]), 20.0, 1.0, long_run=long_run)
    (tmp_path / "run" / "checkpoint").write_bytes(pickle.dumps({"fingerprint": os.system}))
    with pytest.raises(InputError, match="not a checkpoint that can be read"):
        simulate(assembly([counter("x")]), 10.0, 1.0, long_run=long_run)
    plain = counter("x", capabilities=Capabilities(variable_step=True))
    with pytest.raises(InputError, match="x: cannot serialise its state, which checkpoints need") as told:
        simulate(assembly([plain]), 10.0, 1.0, long_run=long_run)
    assert str(told.value).endswith("leave out `long_run`, and `long_run.resume` with it")
    with speaking_of_options(OPTIONS), pytest.raises(InputError, match="out --checkpoint, and --resume with"):
        simulate(assembly([plain]), 10.0, 1.0, long_run=long_run)


class HandDrivenTime:
    """A clock on the wall that moves when somebody sleeps, and with every look at it by `hold_up` s."""

    def __init__(self, hold_up: float = 0.0) -> None:
        self.now, self.hold_up = 100.0, hold_up

    def monotonic(self) -> float:
        self.now += self.hold_up
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.mark.parametrize("pace", [0, -1.0, float("inf"), float("nan")])
def test_what_is_no_pace_is_refused(pace: float) -> None:
    with pytest.raises(InputError, match="not a pace; give a number above 0"):
        simulate(assembly([counter("x")]), 10.0, 1.0, pacing=pace)


@pytest.mark.parametrize(("hold_up", "lag"), [(0.0, 0.0), (0.03, 10 * 0.01)])
def test_pacing_keeps_to_the_wall_clock(monkeypatch: pytest.MonkeyPatch, hold_up: float, lag: float) -> None:
    # A step is due every 0.02 s; where each takes 0.03 s, the run falls behind by 0.01 s a step.
    wall = HandDrivenTime(hold_up)
    monkeypatch.setattr("warmlink.orchestration.master.communication.time", wall)
    began = wall.now
    result = simulate(assembly([counter("x")]), 10.0, 1.0, pacing=50.0)
    assert wall.now - began >= 0.2 - 1e-9
    assert result.statistics.largest_lag == pytest.approx(lag, abs=1e-9)
