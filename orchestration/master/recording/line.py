"""The inner side of a guarded run: a process that tells the one that guards it everything at once."""

from __future__ import annotations

import ctypes
import mmap
import os
import pickle
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.audit import Balance, audit
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.recording.table import Table
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.process import die_with_parent, print_to_standard_error


@dataclass(frozen=True)
class Sketch:
    """What must be known of a run to make a result of its values, though nobody else is left to tell.

    Attributes
    ----------
    names, units, points
        Of the table.
    balances : tuple of Balance
        To be audited.
    file : Path or None
        Where values are streamed to; None where they lie in shared memory.
    """

    names: tuple[str, ...]
    units: dict[str, str | None]
    points: CommunicationPoints
    balances: tuple[Balance, ...]
    file: Path | None

    def filled(self, result: Result, values: NDArray[np.float64]) -> Result:
        """Give a result with the table that belongs to it."""
        table = Table(self.names, self.units, self.points, values)
        return replace(result, table=table, audits=tuple(audit(table, balance) for balance in self.balances))


class Line:
    """What a guarded run tells.

    Parameters
    ----------
    pipe : Connection
        To the guarding process.
    memory : int
        File descriptor of the memory for values.
    """

    def __init__(self, pipe: Connection, memory: int) -> None:
        self._pipe, self._memory = pipe, memory

    def block(self, rows: int, columns: int) -> NDArray[np.float64]:
        """Give memory for values, all NaN, that outlives this process."""
        if rows * columns == 0:
            return np.empty((rows, columns))
        os.ftruncate(self._memory, 8 * rows * columns)
        block = np.frombuffer(mmap.mmap(self._memory, 0)).reshape(rows, columns)
        block[:] = np.nan
        return block

    def began(self, sketch: Sketch) -> None:
        """Tell what the values are."""
        self._pipe.send(("began", sketch))

    def progress(self, done: int, count: int) -> None:
        """Tell how far the run is."""
        self._pipe.send(("progress", (done, count)))

    def keep(self, result: Result) -> None:
        """Hand over the result; whatever happens to this process now, it is safe."""
        rows, names = len(result.table), result.table.names
        bare = Table(names, result.table.units, result.table.points, np.empty((0, len(names))))
        self._pipe.send(("result", (replace(result, table=bare, audits=()), rows)))


def serve(
    work: Callable[[Line | None], object], pipe: Connection, memory: int, status: mmap.mmap, parent: int
) -> NoReturn:
    """Do a guarded run, in the process that was made for it, and end that process."""
    try:
        _become_inner(parent)
        under_way.share(status)
        work(Line(pipe, memory))
        _flush()
        pipe.send(("ended", None))
    except BaseException as fault:
        # The guarding process raises it again.
        with suppress(OSError):
            pipe.send(("fault", _portable(fault)))
    finally:
        # Nothing of Python's is flushed: what it has not written yet is a copy of what the other process has.
        _flush()
        os._exit(0)


def _become_inner(parent: int) -> None:
    """Die with the parent, leave the terminal to it, and keep off its standard output."""
    os.setpgid(0, 0)
    for number in (signal.SIGINT, signal.SIGTTOU):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    die_with_parent()
    if os.getppid() != parent:
        os._exit(0)
    # Where memory runs out, this process has to go, not the one that holds the values.
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")
    print_to_standard_error()


def _flush() -> None:
    """Write what code in C has printed so far."""
    ctypes.CDLL(None).fflush(None)


def _portable(fault: BaseException) -> BaseException:
    # Some packages have exceptions pickled with what caused them, and not every cause can be.
    fault.__cause__ = fault.__context__ = None
    try:
        pickle.loads(pickle.dumps(fault))
    except Exception:
        return RuntimeError(f"{type(fault).__name__}: {fault}")
    return fault
