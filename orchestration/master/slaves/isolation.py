"""A slave in a process of its own: its crash or its endless step is an error like any other."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection as Pipe
from pathlib import Path
from typing import Any, NoReturn

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.process import START_LIMIT, OtherProcess, ProcessEndedError
from warmlink.orchestration.master.slaves.slave import Slave, SlaveError
from warmlink.orchestration.system.description import Capabilities, Variable

Opener = Callable[[], Slave]


@dataclass(frozen=True)
class Isolation:
    """What an isolated slave may take.

    Attributes
    ----------
    time_limit : float
        For one call (instantiating it, or a step, say), in s of wall time.
    memory_limit : float
        For its process, beyond what that has before the FMU is loaded, in bytes; kept on Linux.
    """

    time_limit: float = 60.0
    memory_limit: float = 4e9


def start(name: str, opener: Opener, isolation: Isolation) -> OtherProcess:
    """Start a process in which a slave is opened, without waiting for it, so that many start at once.

    The opener is called there and must be picklable.
    """
    return OtherProcess(name, _serve, name, opener, isolation.memory_limit)


class IsolatedSlave:
    """Passes every call on to a slave in another process.

    Parameters
    ----------
    name : str
        The slave's name, for messages.
    process : OtherProcess
        As `start` gives it; waited for.
    isolation : Isolation
        Time limits.

    Raises
    ------
    SlaveError
        From every method: status `crash` where the process died, `time limit` where it did not answer.
    """

    variables: Mapping[str, Variable]
    capabilities: Capabilities
    dependencies: Mapping[str, frozenset[str]]
    accepts_nan: frozenset[str]

    def __init__(self, name: str, process: OtherProcess, isolation: Isolation) -> None:
        self.name = name
        self.isolation = isolation
        self._time = 0.0
        self._failure: SlaveError | None = None
        self._process = process
        self.remarks: tuple[str, ...] = ()  # what it does to its process concerns nobody else
        self.exit_initialization = partial(self._ask, "exit_initialization")
        self.get = partial(self._ask, "get")
        self.set = partial(self._ask, "set")
        self.set_input_derivatives = partial(self._ask, "set_input_derivatives")
        # Copied states stay in the other process; here they are numbers.
        self.restore, self.free = partial(self._ask, "restore"), partial(self._ask, "free")
        self.serialize, self.deserialize = partial(self._ask, "serialize"), partial(self._ask, "deserialize")
        self._answer("starting", START_LIMIT)
        for attribute, value in self._answer("instantiating", isolation.time_limit).items():
            setattr(self, attribute, value)

    def enter_initialization(self, start_time: float, stop_time: float | None) -> None:
        """Set up the experiment and enter initialization mode."""
        self._time = start_time
        self._ask("enter_initialization", start_time, stop_time)

    def state(self, reuse: object = None) -> object:
        """Copy the complete state; the copy stays in the other process."""
        return self._ask("state", reuse)

    def step(self, time: float, step_size: float) -> None:
        """Advance by one communication step."""
        self._time = time
        self._ask("step", time, step_size)

    def terminate(self) -> None:
        """End the slave and its process."""
        patience = 0.0
        if self._process.is_alive and self._failure is None:
            with suppress(SlaveError):
                self._ask("terminate")
                patience = 5.0
        self._process.end(patience)
        self._failure = self._failure or SlaveError(self.name, "error", self._time, "it has been terminated")

    def _ask(self, method: str, *arguments: Any) -> Any:
        if self._failure is not None:
            raise self._failure
        try:
            self._process.ask((method, arguments))
        except ProcessEndedError as ended:
            self._died(method, ended)
        return self._answer(method, self.isolation.time_limit)

    def _answer(self, method: str, limit: float) -> Any:
        if self._failure is not None:
            raise self._failure
        try:
            answer = self._process.answer(limit, under_way.asked)
        except TimeoutError:
            if under_way.asked():
                self._fail("interrupted", f"{method} had not returned; its process was ended")
            told = f"{method} has not returned within {limit:g} s; its process was ended"
            self._fail("time limit", told)
        except ProcessEndedError as ended:
            self._died(method, ended)
        if isinstance(answer, SlaveError | InputError):
            raise answer
        return answer

    def _died(self, method: str, ended: ProcessEndedError) -> NoReturn:
        how = str(ended)
        if how.endswith(("SIGABRT", "SIGKILL")):  # as where there is no more memory
            how += f"; its memory limit was {self.isolation.memory_limit / 1e6:g} MB"
        self._fail("crash", f"its process died in {method} ({how})")

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
        pipe.send(answer(partial(_perform, slave, states, method, arguments)))


def _limit_memory(more: float) -> None:
    """Let this process take so many bytes more than it has; beyond, it is told that there is no memory."""
    if sys.platform != "linux":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + int(more)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _perform(slave: Slave, states: dict[int, object], method: str, arguments: tuple[Any, ...]) -> Any:
    """Do one call; copied states are known to the other process by number."""
    if method == "state":
        (reuse,) = arguments
        number = len(states) and max(states) + 1 if reuse is None else reuse
        states[number] = slave.state(states.get(number))
        return number
    if method == "restore":
        return slave.restore(states[arguments[0]])
    if method == "free":
        return slave.free(states.pop(arguments[0]))
    return getattr(slave, method)(*arguments)
