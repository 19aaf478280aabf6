"""The inner side of a guarded run: a process that tells the one that guards it everything at once."""

from __future__ import annotations

import ctypes
import mmap
import os
import pickle
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.process import die_with_parent, print_to_standard_error


class Line:
    """Connection over which a guarded run reports to its guard.

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

    def began(self, bare: Result, file: Path | None) -> None:
        """Tell what the run records, and the file that its values are streamed to where it is not memory."""
        self._pipe.send(("began", (bare, file)))

    def progress(self, done: int, count: int) -> None:
        """Tell how far the run is."""
        self._pipe.send(("progress", (done, count)))

    def keep(self, result: Result) -> None:
        """Hand over the result; whatever happens to this process now, it is safe."""
        none = np.empty((0, len(result.table.names)))
        self._pipe.send(("result", (replace(result, table=result.table.holding(none)), len(result.table))))


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
