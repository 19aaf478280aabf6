"""What warmlink keeps and reads again: checkpoints, states and finished runs; made when asked for."""

from __future__ import annotations

import atexit
import shutil
import struct
import tempfile
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from random import Random

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import stamped, unstamped
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.assembly import assemble
from warmlink.orchestration.master.recording.checkpoint import FILE, LongRun
from warmlink.orchestration.master.recording.recorder import VALUES
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import RunSpan, Slave, SlaveError
from warmlink.orchestration.studies import session as ledger
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.workers import FmuSet
from warmlink.orchestration.system.model import FmuPart, System

SENSORS = "TemperatureSensors"
STEPS, EVERY = 20, 15


@cache
def _workshop() -> Path:
    made = Path(tempfile.mkdtemp(prefix="warmlink-fuzz-"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return made


@cache
def system() -> System:
    """One clocked FMU alone, the smallest that has all kinds of state."""
    fmu = FmuStore("native").files([SENSORS])[SENSORS]
    return System("s", {"s": FmuPart("s", fmu, {}, {"seed": 3})}, ())


@cache
def run_until_killed() -> dict[str, bytes]:
    """Files of a run that ended before its time, five steps behind its checkpoint."""
    folder = _workshop() / "run"
    _resumed(folder)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _resumed(folder: Path) -> bytes:
    long_run = LongRun(folder, EVERY, resume=True)
    result = simulate(system(), float(STEPS), 1.0, long_run=long_run, unpacked=_workshop(), stepping="plain")
    if result.error is not None:
        raise result.error
    return np.array(result.table.values).tobytes()


@cache
def _undisturbed() -> bytes:
    return _resumed(_workshop() / "undisturbed")


def resume(path: Path) -> None:
    """Go on from a folder that holds a damaged file; it must be refused, or the values be the same."""
    assert _resumed(path.parent) == _undisturbed(), "a damaged checkpoint gave other values"


def resume_stamped(path: Path) -> None:
    """Go on from a checkpoint that says itself that it is whole; it may say anything that can be true."""
    _resumed(path.parent)


def stamped_checkpoint(random: Random, content: bytes) -> bytes:
    """Damage what a checkpoint says, with its digest to match."""
    said = unstamped(content)
    assert said is not None
    key = random.choice(sorted(said))
    wrong: tuple[object, ...] = (
        None,
        -1,
        10**30,
        float("nan"),
        "x",
        "",
        [],
        ["x"],
        [[1.0, "x"]],
        {},
        [1],
        [[]],
        7,
        [1, 2, "x"],
    )
    return stamped({**said, key: random.choice(wrong)})


@cache
def _slave() -> Slave:
    slave = assemble(system(), unpacked=_workshop()).slaves[0]
    slave.setup(RunSpan(0.0, float(STEPS)))
    slave.enter_initialization()
    slave.exit_initialization()
    slave.step(0.0, 3.0)
    return slave


@cache
def state() -> dict[str, bytes]:
    """A serialised state of a native FMU."""
    return {"state": _slave().serialize()}


def stamped_state(random: Random, content: bytes) -> bytes:
    """Damage numbers of a state, with the digest to match."""
    changed = bytearray(content)
    wild = (np.nan, np.inf, -np.inf, -1.0, 0.0, 1.0, 2.0, 0.5, 1e300, 1e-300, 9e15, 2.0**63, -(2.0**31))
    for _ in range(random.randint(1, 3)):
        at = len(content) - 8 * random.randint(2, (len(content) - 41) // 8)
        changed[at : at + 8] = struct.pack("<d", random.choice(wild))
    digest = 14695981039346656037
    for byte in changed[:-8]:
        digest = (digest ^ byte) * 1099511628211 % 2**64
    return bytes(changed[:-8]) + struct.pack("<Q", digest)


def take_state(path: Path) -> None:
    """Have the FMU take a state and go on from it."""
    slave, good = _slave(), state()["state"]
    try:
        slave.deserialize(path.read_bytes())
        slave.step(3.0, 1.0)
        slave.serialize()
    except SlaveError as fault:
        raise InputError(str(fault)) from None
    finally:
        _healthy(good)


def _healthy(good: bytes) -> None:
    try:
        _slave().deserialize(good)
    except SlaveError:  # an FMU that reported an error wants to be opened anew
        _slave.cache_clear()


class Nobody:
    """Workers that are never asked."""

    def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
        """Run nothing."""
        return iter(())


@cache
def finished_runs() -> dict[str, bytes]:
    """A ledger of ten runs."""
    rows = [Outcome(8.5 + i, 7.0, 3.0, None if i % 2 else 60.0 * i, 1.0, 2.0, 0.1, 0.01) for i in range(10)]
    return {ledger.FILE: b"".join(ledger._line(f"{i:032x}", row) for i, row in enumerate(rows))}


def read_ledger(path: Path) -> None:
    """Read finished runs; what is damaged is left out, and nothing is ever made up."""
    known = ledger.Ledger(path.parent, FmuSet("native", {}), Nobody(), lambda told: None)._known
    true = [ledger._parsed(line) for line in finished_runs()[ledger.FILE].splitlines(keepends=True)]
    assert set(map(repr, known.items())) <= set(map(repr, true)), "a damaged line was taken for a run"


CHECKPOINT, RESULTS = FILE, VALUES
