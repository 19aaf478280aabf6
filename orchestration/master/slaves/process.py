"""A process of its own for FMUs: what it answers, and how it ended."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection as Pipe
from typing import Any

_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG


PATIENCE = 1.0
"""With a call under way when Ctrl-C is pressed, in s."""


START_LIMIT = 60.0
"""For starting the process, before there is an FMU in it, in s: until its first answer, None."""


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
    """A process that answers over a pipe.

    Parameters
    ----------
    name : str
        Of the process.
    target : callable
        Called there with its end of the pipe and the arguments; it and they must be picklable.
    """

    def __init__(self, name: str, target: Callable[..., None], *arguments: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(
            target=_begin, args=(target, other, arguments), daemon=True, name=name
        )
        self._process.start()
        other.close()

    def ask(self, question: object) -> None:
        """Send something; raises `ProcessEndedError` where nobody is there to take it."""
        try:
            self._pipe.send(question)
        except OSError:
            raise self._ended() from None

    def answer(self, limit: float, hurried: Callable[[], bool] = lambda: False) -> Any:
        """Give the next answer; once it is hurried, it is waited for but briefly.

        Raises
        ------
        TimeoutError
            Where there is none within the limit in s; the process was ended.
        ProcessEndedError
            Where the process has ended.
        """
        try:
            end = time.monotonic() + limit
            while not self._pipe.poll(min(0.1, limit)):
                if hurried():
                    end = min(end, time.monotonic() + PATIENCE)
                if time.monotonic() > end:
                    self._process.kill()
                    raise TimeoutError
            return self._pipe.recv()
        except (EOFError, ConnectionError):
            raise self._ended() from None

    def end(self, patience: float = 0.0) -> None:
        """Wait so many s for the process to end by itself, then end it."""
        self._process.join(patience)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    @property
    def is_alive(self) -> bool:
        """Whether the process runs."""
        return self._process.is_alive()

    def _ended(self) -> ProcessEndedError:
        self._process.join(5.0)
        return ProcessEndedError(self._process.exitcode)


def _begin(target: Callable[..., None], pipe: Pipe, arguments: tuple[Any, ...]) -> None:
    # Ctrl-C goes to the whole terminal group; what it means is decided by the master.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    die_with_parent()
    print_to_standard_error()
    pipe.send(None)
    target(pipe, *arguments)


def die_with_parent() -> None:
    """Have the system end this process when the one that started it ends, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGKILL)


def print_to_standard_error() -> None:
    """Send to standard error whatever this process prints to standard output, in Python or in C."""
    with suppress(OSError):
        os.dup2(2, 1)
    # New objects: after a fork, a lock of the old ones may be held by a thread that is no more.
    sys.stdout = sys.stderr = open(2, "w", buffering=1, closefd=False, errors="replace")  # noqa: SIM115
