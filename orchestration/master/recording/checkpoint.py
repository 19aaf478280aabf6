"""Checkpoints of long runs, from whose files a later process continues a run bit for bit."""

from __future__ import annotations

import hashlib
import os
from base64 import b64decode, b64encode
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.arguments import argument, count_given, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import file_digest
from warmlink.orchestration.files import stamped, unstamped, whole_file
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.assembly import Assembly
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.recorder import Recorder, Values, writing
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.system.model import FmuPart, Value

FILE = "checkpoint"
_VERSION = "warmlink checkpoint 5"
MOST_EVERY = 10**9


@dataclass(frozen=True)
class LongRun:
    """How a long run is written to disk.

    The `folder` gets `columns.json`, `values.npy`, which grows with the run, and `checkpoint`, which is
    written anew after `every` so many communication steps; None writes none. With `resume` the run continues
    from the checkpoint in the folder, or begins at its start if there is none.
    """

    folder: str | Path
    every: int | None = 3600
    resume: bool = False


@dataclass(frozen=True)
class Checkpoint:
    """Everything that a later process needs beside the system itself; `digest` is that of the values."""

    fingerprint: str
    rows: int
    digest: str
    states: list[str]  # in base 64
    outputs: list[list[Value]]
    inputs: list[list[Value]]
    memory: object
    counts: tuple[int, dict[str, int], int]


class Checkpoints:
    """Writes and reads the checkpoint of one run; the run goes on from the one `found`.

    InputError if an FMU cannot serialise its state, or the checkpoint is damaged or belongs to another run.
    """

    def __init__(self, chosen: LongRun, network: Network, fingerprint: str) -> None:
        folder = path_given("long_run.folder", chosen.folder)
        self.every = chosen.every
        self.path = folder / FILE
        self._network = network
        self._fingerprint = fingerprint
        unable = ", ".join(s.name for s in network.slaves if not s.capabilities.serialize_state)
        if unable and chosen.every is not None:
            remedy = f"leave out {argument('long_run')}, and {argument('long_run.resume')} with it"
            raise InputError(f"{unable}: cannot serialise its state, which checkpoints need; {remedy}")
        if chosen.every is not None:
            count_given("long_run.every", chosen.every, 1, MOST_EVERY, "communication steps")
        self.found = self._load() if chosen.resume else None
        # New values are appended to those that the checkpoint counts on.
        rows, digest = (0, "") if self.found is None else (self.found.rows, self.found.digest)
        self.values = Values(folder, keep=rows, digest=digest)

    def next_after(self, point: int, last: int) -> int:
        """Give the next point after this one at which a checkpoint is due, at most the run's last point."""
        return last if self.every is None else min(last, (point // self.every + 1) * self.every)

    def due(self, point: int) -> bool:
        """Tell whether a checkpoint is due at a point."""
        return self.every is not None and point % self.every == 0

    def save(self, recorder: Recorder, stepper: Stepper) -> None:
        """Write a checkpoint of the present point, the values first; StoreError where the disk is full."""
        recorder.flush()
        network = self._network
        kept = Checkpoint(
            self._fingerprint,
            recorder.rows,
            self.values.secure(),
            [b64encode(slave.serialize()).decode() for slave in network.slaves],
            network.outputs,
            network.inputs,
            stepper.memory(),
            (network.steps, network.rejected, network.sweeps),
        )
        with writing(self.path), whole_file(self.path) as scratch, scratch.open("wb") as file:
            file.write(stamped({"version": _VERSION, **vars(kept)}))
            file.flush()
            os.fsync(file.fileno())

    def forget(self) -> None:
        """Remove the checkpoint of an earlier run, so that it is not mistaken for one of this run."""
        self.path.unlink(missing_ok=True)

    def _load(self) -> Checkpoint | None:
        if not self.path.exists():
            return None
        with self._readable():
            content = unstamped(self.path.read_bytes()) or {}
            if content.pop("version", None) != _VERSION:
                raise ValueError("it is damaged, or of another version")
            found = Checkpoint(**content)
            if not isinstance(found.rows, int) or found.rows < 1:
                raise ValueError(f"it counts {found.rows!r:.20} rows")
        if found.fingerprint != self._fingerprint:
            raise InputError(
                f"{self.path}: belongs to another run (system, FMU files, start values, times, algorithm or "
                f"recorded variables differ); give what that run was started with, or {_anew()}"
            )
        return found

    def restore(self, recorder: Recorder, stepper: Stepper) -> None:
        """Bring initialized slaves, network and algorithm to the state in the checkpoint."""
        network, found = self._network, self.found
        assert found is not None
        with self._readable():
            for theirs, ours in ((found.outputs, network.outputs), (found.inputs, network.inputs)):
                if [(type(each), len(each)) for each in theirs] != [(list, len(each)) for each in ours]:
                    raise ValueError("its values are not those of these FMUs")
            for slave, data in zip(network.slaves, found.states, strict=True):
                slave.deserialize(b64decode(data))
            network.outputs, network.inputs = found.outputs, found.inputs
            network.steps, rejected, network.sweeps = found.counts
            network.rejected = Counter(rejected)
            network.time = recorder.points.time(found.rows - 1)
            stepper.recall(found.memory)
            recorder.resume(found.rows)

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Raise InputError where the checkpoint's content is malformed."""
        try:
            yield
        except InputError:
            raise
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as fault:
            told = f"{self.path}: is not a checkpoint that can be read ({fault}); {_anew()}"
            raise InputError(told) from None


def _anew() -> str:
    """What starts a run anew in a folder with a checkpoint of no use."""
    return f"leave out {argument('long_run.resume')} to start anew"


def fingerprint(
    assembly: Assembly,
    names: Sequence[str],
    points: CommunicationPoints,
    algorithm: Algorithm,
    tolerance: float | None,
) -> str:
    """Give a digest of everything that determines a run's values, and of the names of recorded variables.

    It covers the stop time, since slaves are told it and may keep it in their state, and the bytes of the
    FMUs, since an FMU that was built anew may keep its GUID.
    """
    slaves = [[s.name for s in assembly.slaves], [*map(_entries, assembly.parts.values())]]
    values = sorted((name, sorted(given.items())) for name, given in assembly.values.items())
    parts = (slaves, list(assembly.connections), values, points, algorithm, tuple(names), tolerance)
    return hashlib.sha256("\n".join(map(repr, parts)).encode()).hexdigest()


def _entries(part: FmuPart) -> list[tuple[str, object]]:
    """Everything that a part says of itself, whatever fields it has; for its file the bytes stand."""
    said = {**vars(part), "fmu": file_digest(part.fmu)}
    return [(key, sorted(each.items()) if isinstance(each, Mapping) else each) for key, each in said.items()]
