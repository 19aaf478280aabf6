"""A run in a process of its own, from which every recorded value comes back, whatever its FMUs do.

An FMU may end its process, crash it (even after the run, while the FMU is freed), never return, change the
working folder, or print. It therefore runs in a copy of this process. What it prints goes to standard error,
the recorded values are in memory that both processes share, and this process continues in any case.
"""

from __future__ import annotations

import ctypes
import gc
import mmap
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import Pipe
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import Balance, RecordTable, Result, Statistics
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.frames import DamagedError, Frames, out_of_reach
from warmlink.orchestration.master.slaves.other_process import (
    die_with_parent,
    how_it_ended,
    print_to_standard_error,
)
from warmlink.orchestration.master.slaves.slave import Calls, SlaveError, SlaveStatistics
from warmlink.orchestration.master.slaves.under_way import on_ctrl_c

Progress = Callable[[int, int], None]
Remark = Callable[[str], None]

ENDING_SECONDS = 10.0

_CLASSES = (Balance, Calls, CommunicationPoints, Result, SlaveStatistics, Statistics, RecordTable)


def guarded(
    work: Callable[[Line | None], Result],
    progress: Progress | None = None,
    remark: Remark | None = None,
) -> Result:
    """Do a run in a process of its own.

    Ctrl-C, or SIGTERM in a command, ends the run after the present step; a second one ends it at once, even
    if an FMU does not return. Recorded values are kept in both cases, and also if the process dies.
    InputError, SlaveError: as the run does; SlaveError too where the process dies before there is a first
    value.

    The work does the run, `lambda line: simulate(..., line=line)`; on platforms other than Linux in this
    process, with None. Progress is told here in communication steps done and to do; a remark is what the user
    should know at once.
    """
    if sys.platform != "linux":
        return work(None)
    ours, theirs = (Frames(each, _CLASSES) for each in Pipe())
    status = mmap.mmap(-1, under_way.SIZE)
    memory = out_of_reach(os.memfd_create("warmlink-values"))
    parent = os.getpid()
    gc.freeze()  # else the other process' first collection copies every page that holds an object
    child = os.fork()
    if child == 0:
        ours.close()
        serve(work, theirs, memory, status, parent)
    gc.unfreeze()
    theirs.close()
    with suppress(OSError):  # both processes do this; the second one fails
        os.setpgid(child, child)
    try:
        return _Guard(child, ours, under_way.UnderWay(status), memory, progress, remark).result()
    finally:
        ours.close()
        os.close(memory)


@dataclass
class _Guard:
    """Follows the other process until it ends."""

    child: int
    pipe: Frames
    status: under_way.UnderWay
    memory: int
    progress: Progress | None
    remark: Remark | None
    _begun: Result | None = None
    _file: Path | None = None
    _result: Result | None = None
    _over: bool = False
    _ended: bool = False
    _pressed: int = 0
    _death: str = "ended"

    def result(self) -> Result:
        """Wait for the other process and give what came of it."""
        with on_ctrl_c(self._press):
            try:
                hangs = not self._follow()
            finally:
                self._kill()  # with everything that the run started
                self._reap(wait=True)
        if self._result is None:
            return self._rescued()
        if self._ended:
            return self._result
        name, call = self.status.described()
        how = f"did not end within {ENDING_SECONDS:g} s" if hangs else self._death
        doing = f"in {call}" if call != "ending" else "while the FMUs were freed"
        told = f"{name or 'the run'}: its process {how} {doing}, after the run; the values are complete"
        return replace(self._result, remarks=(*self._result.remarks, told))

    def _follow(self) -> bool:
        """Take what the other process tells until it has ended; False where it does not end."""
        give_up = np.inf
        while not self._ended:
            if time.monotonic() > give_up:
                return False
            try:
                if self.pipe.poll(0.1):
                    self._take(*self.pipe.receive())
                elif self._reap() and not self.pipe.poll(0):
                    return True
            except (EOFError, ConnectionError):
                return True
            except DamagedError:
                self._kill()
                self._reap(wait=True)
                self._death = "sent what is no answer (the FMU writes to descriptors that are not its own)"
                return True
            if self._over:
                give_up = min(give_up, time.monotonic() + ENDING_SECONDS)
        return True

    def _take(self, kind: str, content: Any) -> None:
        if kind == "fault":
            raise content
        if kind == "began":
            self._begun, self._file = content
        elif kind == "progress" and self.progress is not None:
            self.progress(*content)
        elif kind == "result":
            bare, rows, self._over = content
            self._result = self._filled(bare, rows)
        elif kind == "ended":
            self._ended = True

    def _filled(self, bare: Result, rows: int) -> Result:
        """Give a result its values; those of the memory are this process's own from now on."""
        columns = len(bare.table.names)
        if self._file is not None:
            values = np.load(self._file, mmap_mode="r")
        else:
            block = mmap.mmap(self.memory, 0, access=mmap.ACCESS_COPY)
            values = np.frombuffer(block, count=rows * columns).reshape(rows, columns)
        return replace(bare, table=bare.table.holding(values))

    def _rescued(self) -> Result:
        """Make a result of what was recorded before the other process ended."""
        begun, rows = self._begun, self.status.cells[under_way.ROWS]
        at = 0.0 if begun is None else begun.table.points.time(max(rows - 1, 0))
        name, call = self.status.described()
        doing = f" in {call}" if name else ""
        if self._pressed > 1:
            fault = None
            reason = f"interrupted at {at:g} s" + (f", {name} had not returned from {call}" if name else "")
        else:
            fault = SlaveError(name or "the run", "crash", at, f"its process {self._death}{doing}")
            reason = str(fault)
        if begun is None or rows == 0:
            raise fault or SlaveError(name or "the run", "crash", at, reason)
        kept = self._filled(begun, rows)
        if len(kept.table) < rows:  # those that were about to be written went with the process
            until = f" after {kept.times[-1]:g} s" if len(kept.table) else ""
            reason += f"; the values{until} were not on disk yet and are lost"
        return replace(kept, reason=reason, error=fault)

    def _reap(self, *, wait: bool = False) -> bool:
        """Tell whether the process has ended, and note how."""
        try:
            pid, status = os.waitpid(self.child, 0 if wait else os.WNOHANG)
        except ChildProcessError:
            return True
        if pid:
            self._death = f"ended ({how_it_ended(os.waitstatus_to_exitcode(status))})"
        return bool(pid)

    def _press(self, number: int, frame: FrameType | None) -> None:
        self._pressed += 1
        if self._pressed > 1:
            self._kill()
        else:
            self.status.cells[under_way.ASKED] = 1
            if self.remark is not None:
                told, again = ("SIGTERM", "send it") if number == signal.SIGTERM else ("Ctrl-C", "press")
                self.remark(f"{told}: the run ends after the present step; {again} again to end it at once")

    def _kill(self) -> None:
        with suppress(OSError):
            os.killpg(self.child, signal.SIGKILL)


@dataclass(frozen=True)
class Line:
    """Connection over which a guarded run reports to its guard; the memory for values has a descriptor."""

    _pipe: Frames
    _memory: int

    def block(self, rows: int, columns: int) -> Array:
        """Give memory for values, all NaN, that outlives this process."""
        size = rows * columns
        os.ftruncate(self._memory, 8 * max(size, 1))  # nothing cannot be mapped
        block = np.frombuffer(mmap.mmap(self._memory, 0), count=size).reshape(rows, columns)
        block[:] = np.nan
        return block

    def began(self, bare: Result, file: Path | None) -> None:
        """Tell what the run records, and the file that its values are streamed to where it is not memory."""
        self._pipe.send(("began", (bare, file)))

    def progress(self, done: int, count: int) -> None:
        """Tell how far the run is."""
        self._pipe.send(("progress", (done, count)))

    def keep(self, result: Result, over: bool = True) -> None:
        """Hand over the result, in place of one before; whatever happens to this process now, it is safe.

        Where all is `over` but the freeing of FMUs, the guard does not wait for long.
        """
        none = np.empty((0, len(result.table.names)))
        bare = replace(result, table=result.table.holding(none))
        self._pipe.send(("result", (bare, len(result.table), over)))


def serve(
    work: Callable[[Line | None], object], pipe: Frames, memory: int, status: mmap.mmap, parent: int
) -> NoReturn:
    """Do a guarded run, in the process that was made for it, and end that process."""
    write_out = ctypes.CDLL(None).fflush  # what code in C has printed so far
    try:
        _become_inner(parent)
        under_way.share(status)
        work(Line(pipe, memory))
        write_out(None)
        pipe.send(("ended", None))
    except BaseException as fault:
        # The guarding process raises it again.
        with suppress(OSError):
            pipe.send(("fault", fault))
    finally:
        # Nothing of Python's is flushed: what it has not written yet is a copy of what the other process has.
        write_out(None)
        os._exit(0)


def _become_inner(parent: int) -> None:
    """Die with the parent, leave the terminal to it, and keep off its standard output."""
    os.setpgid(0, 0)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGTTOU):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    die_with_parent()
    if os.getppid() != parent:
        os._exit(0)
    # Where memory runs out, this process has to go, not the one that holds the values.
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")
    print_to_standard_error()
