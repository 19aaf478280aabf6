"""A process of its own for FMUs: a crash there, or an endless step, is an error like any other."""

from __future__ import annotations

import ctypes
import math
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection as Pipe
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError

Opener = Callable[[], Slave]

PATIENCE = 1.0
"""With a call under way when Ctrl-C is pressed, in s."""

START_LIMIT = 60.0
"""For starting the process, before there is an FMU in it, in s: until its first answer, None."""


@dataclass(frozen=True)
class Isolation:
    """What an isolated slave may take: s of wall time for a call, bytes beyond those before it was loaded."""

    time_limit: float = 60.0
    memory_limit: float = 4e9


UNLIMITED = Isolation(math.inf, math.inf)
"""For an FMU of which a process may hold one instance."""


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

    The target is called there with its end of the pipe and the arguments; it and they must be picklable. The
    first answer is None.
    """

    def __init__(self, name: str, target: Callable[..., None], *arguments: Any) -> None:
        # Spawned, since a fork would inherit FMUs and threads of whoever calls.
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self._process = context.Process(
            target=_begin, args=(target, other, arguments), daemon=True, name=name
        )
        with _no_interrupts(), without_main():
            self._process.start()
        other.close()

    def ask(self, question: object) -> None:
        """Send something; raises `ProcessEndedError` where nobody is there to take it."""
        try:
            self.pipe.send(question)
        except OSError:
            raise self._ended() from None

    def answer(self, limit: float, hurried: Callable[[], bool] = lambda: False) -> Any:
        """Give the next answer; once it is hurried, it is waited for but briefly.

        TimeoutError, and the process is ended, where there is none within the limit in s;
        `ProcessEndedError` where it has ended.
        """
        end = time.monotonic() + limit
        try:
            while not self.pipe.poll(min(0.1, limit)):
                if hurried():
                    end = min(end, time.monotonic() + PATIENCE)
                if time.monotonic() > end:
                    self._process.kill()
                    raise TimeoutError
            return self.pipe.recv()
        except TimeoutError:
            raise
        except (EOFError, OSError):  # a plain OSError where it died while it wrote
            raise self._ended() from None

    def end(self, patience: float = 0.0) -> None:
        """Wait so many s for the process to end by itself, then end it."""
        self._process.join(patience)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self.pipe.close()

    def _ended(self) -> ProcessEndedError:
        self._process.join(5.0)
        return ProcessEndedError(self._process.exitcode)


def _begin(target: Callable[..., None], pipe: Pipe, arguments: tuple[Any, ...]) -> None:
    # Ctrl-C goes to the whole terminal group, SIGTERM to a whole job; what it means is decided by the master.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    die_with_parent()
    print_to_standard_error()
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


class IsolatedSlave:
    """Passes every call on to a slave in another process; copied states stay there, here they are numbers.

    The process, in which the slave is opened (picklable), is started at once, but waited for in `begin`, so
    that many start at the same time. Every method may raise SlaveError: a `crash`, or the `time limit` where
    the process does not answer.
    """

    def __init__(self, name: str, opener: Opener, isolation: Isolation) -> None:
        self.name = name
        self.isolation = isolation
        self._time = 0.0
        self._failure: SlaveError | None = SlaveError(name, "error", 0.0, "it has not begun")
        self._process = OtherProcess(name, _serve, name, opener, isolation.memory_limit)
        # What it does to its process concerns nobody else.
        self.remarks: tuple[str, ...] = ()
        if isolation is UNLIMITED:
            told = f"{name}: a process may hold one instance of its FMU, so that it has a process of its own"
            self.remarks = (told,)

    def begin(self) -> None:
        """Wait until the slave is open."""
        self._answer("starting", START_LIMIT)
        vars(self).update(self._answer("instantiating", self.isolation.time_limit))
        self._failure = None

    def __getattr__(self, method: str) -> Callable[..., Any]:
        if method not in vars(Slave):
            raise AttributeError(method)
        return partial(self._ask, method)

    def terminate(self) -> None:
        """End the slave and its process."""
        patience = 0.0
        if self._failure is None:
            with suppress(SlaveError):
                self._ask("terminate")
                patience = 5.0
        self._process.end(patience)
        self._failure = self._failure or SlaveError(self.name, "error", self._time, "it has been terminated")

    def _ask(self, method: str, *arguments: Any) -> Any:
        if self._failure is not None:
            raise self._failure
        if method == "setup":
            self._time = arguments[0].start_time
        elif method == "step":
            self._time = arguments[0]
        return self._answer(method, self.isolation.time_limit, (method, arguments))

    def _answer(self, method: str, limit: float, question: object = None) -> Any:
        try:
            if question is not None:
                self._process.ask(question)
            answer = self._process.answer(limit, under_way.asked)
        except TimeoutError:
            if under_way.asked():
                self._fail("interrupted", f"{method} had not returned; its process was ended")
            self._fail("time limit", f"{method} has not returned within {limit:g} s; its process was ended")
        except ProcessEndedError as ended:
            how = str(ended)
            if how.endswith(("SIGABRT", "SIGKILL")):  # as where there is no more memory
                how += f"; its memory limit was {self.isolation.memory_limit / 1e6:g} MB"
            self._fail("crash", f"its process died in {method} ({how})")
        if isinstance(answer, SlaveError | InputError):
            raise answer
        return answer

    def _fail(self, status: Any, message: str) -> NoReturn:
        self._failure = SlaveError(self.name, status, self._time, message)
        raise self._failure


def _serve(pipe: Pipe, name: str, opener: Opener, memory_limit: float) -> None:
    """Answer calls until the other end is gone or asks to terminate."""
    _limit_memory(memory_limit)
    own, states = os.getpid(), dict[int, object]()

    def answer(action: Callable[[], Any]) -> Any:
        try:
            found = action()
        except (SlaveError, InputError) as error:
            found = error
        except MemoryError:
            told = f"it needs more memory than its limit of {memory_limit / 1e6:g} MB"
            found = SlaveError(name, "error", 0.0, told)
        if os.getpid() != own:
            os._exit(0)  # a copy of this process, which the FMU made
        return found

    slave = answer(opener)
    if isinstance(slave, Exception):
        pipe.send(slave)
        return
    known = ("variables", "capabilities", "dependencies", "accepts_nan")
    pipe.send({attribute: getattr(slave, attribute) for attribute in known})
    method = ""
    while method != "terminate":
        try:
            method, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(answer(partial(_perform, slave, states, method, *arguments)))


def _limit_memory(more: float) -> None:
    """Let this process take so many bytes more than it has; beyond, it is told that there is no memory."""
    if sys.platform == "linux" and more < math.inf:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + int(more)
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _perform(slave: Slave, states: dict[int, object], method: str, *given: Any) -> Any:
    """Do one call; copied states are known to the other process by number."""
    if method == "state":
        number = max(states, default=-1) + 1 if given[0] is None else given[0]
        states[number] = slave.state(states.get(number))
        return number
    if method == "restore":
        return slave.restore(states[given[0]])
    if method == "free":
        return slave.free(states.pop(given[0]))
    return getattr(slave, method)(*given)
