"""A process of its own for FMUs: a crash there, or an endless step, is an error like any other."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.frames import DamagedError, Frames
from warmlink.orchestration.master.slaves.other_process import (
    START_LIMIT,
    OtherProcess,
    ProcessEndedError,
    how_it_ended,
)
from warmlink.orchestration.master.slaves.slave import Names, RunSpan, Slave, SlaveError
from warmlink.orchestration.system.model import ModelInfo, Value

Opener = Callable[[], Slave]
_CALLS = ("step", "get", "set")


@dataclass(frozen=True)
class Isolation:
    """What an isolated slave may take: s of wall time for a call, bytes beyond those before it was loaded."""

    time_limit: float = 60.0
    memory_limit: float = 4e9


UNLIMITED = Isolation(math.inf, math.inf)
"""For an FMU that allows one instance in a process."""


class IsolatedSlave:
    """Passes every call on to a slave in another process; copied states stay there, here they are numbers.

    The process, in which the slave is opened (picklable), is started at once, but waited for in `begin`, so
    that many start at the same time. Every method may raise SlaveError: a `crash`, or the `time limit` where
    the process does not answer. After the end, `remarks` tell what went wrong there.
    """

    def __init__(self, name: str, info: ModelInfo, opener: Opener, isolation: Isolation) -> None:
        self.name = name
        self.variables, self.capabilities = info.variables, info.capabilities
        self.dependencies = {output: info.feedthrough(output) for output in info.outputs}
        self.accepts_nan = info.accepts_nan
        self.isolation = isolation
        self._time = 0.0
        self._failure: SlaveError | None = SlaveError(name, "error", 0.0, "it has not begun")
        self._process = OtherProcess(name, _serve, opener, isolation.memory_limit, classes=(RunSpan,))
        self._numbers: dict[Names, int] = {}
        self.remarks: list[str] = []  # what it does to its process while it runs concerns nobody else
        if isolation is UNLIMITED:
            told = f"{name}: a process may hold one instance of its FMU, so that it has a process of its own"
            self.remarks.append(told)

    def begin(self) -> None:
        """Wait until the slave is open."""
        self._answer("starting", START_LIMIT)
        self._answer("instantiating", self.isolation.time_limit)
        self._failure = None

    def __getattr__(self, method: str) -> Callable[..., Any]:
        if method not in vars(Slave):
            raise AttributeError(method)
        return partial(self._ask, method)

    def terminate(self) -> None:
        """End the slave and its process."""
        patience = 0.0
        if self._failure is None:
            try:
                self._ask("terminate")
                patience = 5.0
            except SlaveError as fault:
                self.remarks.append(f"{self.name}: {fault.message}, after the run; the values are complete")
        code = self._process.end(patience)
        if patience and code:
            how = how_it_ended(code)
            self.remarks.append(f"{self.name}: its process ended with {how} after the run")
        self._failure = self._failure or SlaveError(self.name, "error", self._time, "it has been terminated")

    def step(self, time: float, step_size: float) -> str | None:
        """Advance by one communication step."""
        self._check(time)
        found: str | None = self._call("step", 0, (time, step_size))
        return found

    def get(self, names: Names) -> list[Value]:
        """Give the values of variables."""
        self._check()
        found: list[Value] = self._call("get", self._number_of(names), ())
        return found

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set variables."""
        if set(map(type, values)) == {float}:
            self._check()
            self._call("set", self._number_of(names), values)
        else:
            self._ask("set", names, values)

    def _number_of(self, names: Names) -> int:
        """Give the number by which the other process knows a set of variables."""
        number = self._numbers.get(names)
        if number is None:
            self._numbers[names] = number = len(self._numbers)
            self._answer("names", self.isolation.time_limit, lambda: self._process.ask(("names", (names,))))
        return number

    def _check(self, time: float | None = None) -> None:
        if self._failure is not None:
            raise self._failure
        if time is not None:
            self._time = time

    def _ask(self, method: str, *arguments: Any) -> Any:
        self._check(arguments[0].start_time if method == "setup" else None)
        return self._answer(method, self.isolation.time_limit, lambda: self._process.ask((method, arguments)))

    def _call(self, method: str, of: int, numbers: Sequence[Any]) -> Any:
        what, limit = _CALLS.index(method), self.isolation.time_limit
        return self._answer(method, limit, lambda: self._process.call(what, of, numbers))

    def _answer(self, method: str, limit: float, ask: Callable[[], None] = lambda: None) -> Any:
        try:
            ask()
            answer = self._process.answer(limit, under_way.asked)
        except TimeoutError:
            if under_way.asked():
                self._fail("interrupted", f"{method} had not returned; its process was ended")
            self._fail("time limit", f"{method} has not returned within {limit:g} s; its process was ended")
        except ProcessEndedError as ended:
            how, limit_mb = str(ended), f"{self.isolation.memory_limit / 1e6:g} MB"
            if how.endswith("SIGABRT"):
                how += (
                    f"; it wrote beyond its memory, needs more, or gave up: its memory limit was {limit_mb}"
                )
            if how.endswith("SIGKILL"):  # as the system does where there is no more memory
                how += f"; its memory limit was {limit_mb}"
            self._fail("crash", f"its process died in {method} ({how})")
        except DamagedError:
            self._process.end()
            told = (
                f"its process answered {method} with what is no answer: the FMU writes to descriptors that "
            )
            self._fail("crash", f"{told}are not its own; the process was ended")
        if isinstance(answer, MemoryError):
            self._fail("error", f"{method} found {answer}")
        if isinstance(answer, SlaveError | InputError):
            raise answer
        return answer

    def _fail(self, status: Any, message: str) -> NoReturn:
        self._failure = SlaveError(self.name, status, self._time, message)
        raise self._failure


def _serve(pipe: Frames, opener: Opener, memory_limit: float) -> None:
    """Answer calls until the other end is gone or asks to terminate."""
    most = _limit_memory(memory_limit)
    own, states = os.getpid(), dict[int, object]()

    def answer(action: Callable[[], Any]) -> Any:
        try:
            found = action()
        except (SlaveError, InputError) as error:
            found = error
        except MemoryError:
            found = MemoryError(_out_of_memory(most, memory_limit))
        if os.getpid() != own:
            os._exit(0)  # a copy of this process, which the FMU made
        return found

    slave = answer(opener)
    if isinstance(slave, Exception):
        pipe.send(slave)
        return
    pipe.send(None)
    method, sets = "", list[Names]()
    while method != "terminate":
        try:
            question = pipe.receive()
        except (EOFError, OSError):
            return
        method, arguments = _understood(question, sets)
        pipe.send(answer(partial(_perform, slave, states, method, *arguments)) if method else None)


def _understood(question: Any, sets: list[Names]) -> tuple[str, tuple[Any, ...]]:
    """Give method and arguments of a question; no method if it tells a set of names, which others number."""
    if len(question) == 2:
        method, arguments = question
        if method == "names":
            sets += arguments
        return ("" if method == "names" else method), arguments
    what, of, numbers = question
    method = _CALLS[what]
    if method == "step":
        return method, tuple(numbers)
    return method, (sets[of], numbers) if method == "set" else (sets[of],)


def _limit_memory(more: float) -> float:
    """Let this process take so many bytes more than it has, and give how many that are in all.

    Beyond, it is told that there is no memory.
    """
    limit = _memory_in_use() + more
    if sys.platform == "linux" and more < math.inf:
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (int(limit), hard))
    return limit


def _memory_in_use() -> float:
    """Address space of this process in bytes; 0 where the platform does not tell."""
    if sys.platform != "linux":
        return 0.0
    import resource

    return float(int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize())


def _out_of_memory(most: float, limit: float) -> str:
    """Say what it means that there is no memory: more than the limit, or far from it."""
    told = f"no memory; its limit is {limit / 1e6:g} MB"
    with suppress(OSError, MemoryError, ValueError):
        left = most - _memory_in_use()
        if left > 0.1 * limit:
            why = "the FMU asked for more at once, or wrote beyond its memory"
            return f"{told}, of which {left / 1e6:.0f} MB are left: {why}"
    return told


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
