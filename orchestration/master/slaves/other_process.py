"""A process of its own for what may crash or never return, and the pipe to it."""

from __future__ import annotations

import atexit
import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from types import ModuleType
from typing import Any
from weakref import WeakSet

from warmlink.orchestration.master.slaves.frames import HIGH, Frames

PATIENCE = 1.0
"""With a call under way when Ctrl-C is pressed, in s."""

START_LIMIT = 60.0
"""For starting the process, before there is an FMU in it, in s: until its first answer, None."""


_started: WeakSet[SpawnProcess] = WeakSet()


@atexit.register
def _end_all() -> None:
    """End what an interruption kept from being ended: at its exit, Python would wait for it for ever."""
    for process in multiprocessing.active_children():
        if process in _started:
            process.kill()


class ProcessEndedError(Exception):
    """The other process is gone; `code` is its exit code, below 0 for the signal that ended it."""

    def __init__(self, code: int | None) -> None:
        super().__init__(how_it_ended(code))
        self.killed = (code or 0) < 0


def how_it_ended(code: int | None) -> str:
    """Name the signal or the exit code that a process ended with."""
    if code is not None and code < 0:
        return f"signal {signal.Signals(-code).name}"
    return f"exit code {code}"


class OtherProcess:
    """A process that answers over a pipe, in frames that may hold `classes`.

    The target is called there with its end of the pipe and the arguments; it and they must be picklable. The
    first answer is None.
    """

    def __init__(
        self, name: str, target: Callable[..., None], *arguments: Any, classes: tuple[type, ...] = ()
    ) -> None:
        # Spawned, since a fork would inherit FMUs and threads of whoever calls.
        context = multiprocessing.get_context("spawn")
        ours, other = context.Pipe()
        self.pipe = Frames(ours, classes)
        self._process = context.Process(
            target=_begin, args=(target, other, arguments, classes), daemon=True, name=name
        )
        _started.add(self._process)
        with _no_interrupts(), without_main():
            self._process.start()
        other.close()

    def ask(self, question: object) -> None:
        """Send something; raises `ProcessEndedError` where nobody is there to take it."""
        try:
            self.pipe.send(question)
        except OSError:
            raise self._ended() from None

    def call(self, what: int, of: int, numbers: Sequence[float]) -> None:
        """Send what `Frames.send_call` does; raises as `ask`."""
        try:
            self.pipe.send_call(what, of, numbers)
        except OSError:
            raise self._ended() from None

    def answer(self, limit: float, hurried: Callable[[], bool] = lambda: False) -> Any:
        """Give the next answer; once it is hurried, it is waited for but briefly.

        TimeoutError, and the process is ended, if there is none within the limit in s;
        `ProcessEndedError` where it has ended, and DamagedError where what came is no answer.
        """
        end = time.monotonic() + limit
        try:
            while not self.pipe.poll(min(0.1, limit)):
                if hurried():
                    end = min(end, time.monotonic() + PATIENCE)
                if time.monotonic() > end:
                    self._process.kill()
                    raise TimeoutError
            return self.pipe.receive()
        except TimeoutError:
            raise
        except (EOFError, OSError):  # a plain OSError where it died while it wrote
            raise self._ended() from None

    def end(self, patience: float = 0.0) -> int | None:
        """Wait so many s for the process to end by itself, then end it; give its exit code if it did so."""
        self._process.join(patience)
        code = self._process.exitcode
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self.pipe.close()
        return code

    def _ended(self) -> ProcessEndedError:
        self._process.join(5.0)
        return ProcessEndedError(self._process.exitcode)


def _begin(
    target: Callable[..., None], other: Connection, arguments: tuple[Any, ...], classes: tuple[type, ...]
) -> None:
    # Ctrl-C goes to the whole terminal group, SIGTERM to a whole job; what it means is decided by the master.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    die_with_parent()
    print_to_standard_error()
    pipe = Frames(other, classes)
    if sys.platform != "win32":
        os.closerange(3, HIGH)  # what an FMU might write to by mistake, and others read
    pipe.send(None)
    target(pipe, *arguments)


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C and SIGTERM do not reach: it is for the parent to end them."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # which would set the mask back
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def without_main() -> Iterator[None]:
    """Keep a new process from running the script of whoever calls once more: it needs nothing of it."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def die_with_parent() -> None:
    """Have the system end this process when the one that started it ends, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def print_to_standard_error() -> None:
    """Send to standard error whatever this process prints to standard output, in Python or in C."""
    with suppress(OSError):
        os.dup2(2, 1)
    # New objects: after a fork, a lock of the old ones may be held by a thread that is no more.
    sys.stdout = sys.stderr = open(2, "w", buffering=1, closefd=False, errors="replace")  # noqa: SIM115
