"""Which slave is being called, how many rows are recorded, and whether to stop: legible from outside.

The figures lie in one piece of memory, so that another process can read them when this one has died
(`warmlink.orchestration.master.guard`) and the compiled loop can write them.
"""

from __future__ import annotations

import mmap
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from warmlink.orchestration.console import Terminated, end_as_interrupted

# Places of figures. The compiled loop has the first three, what failed, which slave and its status, and the
# last three; TURNED is, counted from 1, the slave that has changed how all calculate.
CALL, ROWS, ASKED, BATCH, ENDS, TURNED = 3, 4, 5, 6, 7, 8
CELLS = 9
NAMES_FROM = 8 * CELLS
SIZE = 1 << 16

CALLS = ("", "loading", "initialization", "a step", "exchanging values", "copying its state", "ending")
LOADING, INITIALIZING, STEPPING, EXCHANGING, COPYING, ENDING = range(1, len(CALLS))


class UnderWay:
    """What a process is doing, in `SIZE` bytes that are zero at first and that another process may share.

    At `CALL` stands the slave's number times 16 plus one of `CALLS`, at `ASKED` whether to stop.
    """

    def __init__(self, memory: bytearray | mmap.mmap) -> None:
        self._names = memoryview(memory)[NAMES_FROM:]
        self.cells = memoryview(memory)[:NAMES_FROM].cast("q")
        self._count = self._end = 0

    def register(self, name: str) -> int:
        """Give a slave its number: they are counted from 0."""
        written = f"{name}\n".encode()
        if self._end + len(written) <= len(self._names):
            self._names[self._end : self._end + len(written)] = written
            self._end += len(written)
        self._count += 1
        return self._count - 1

    def described(self) -> tuple[str, str]:
        """Name the slave last called and what was asked of it; both empty where there was none."""
        number, call = divmod(self.cells[CALL], 16)
        names = bytes(self._names).rstrip(b"\0").decode().split("\n")
        return (names[number] if call and number < len(names) else ""), CALLS[call]


here = UnderWay(bytearray(SIZE))
"""What this process is doing."""


def share(memory: mmap.mmap) -> None:
    """From now on, tell it in memory that another process reads."""
    global here
    here = UnderWay(memory)


def asked() -> bool:
    """Tell whether to stop; a process that guards this one may ask for it too."""
    return bool(here.cells[ASKED])


@contextmanager
def on_ctrl_c(pressed: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Have Ctrl-C call a function, and in commands SIGTERM too, where this is the main thread.

    What SIGTERM does to a program of somebody else's is that program's own.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    command = signal.getsignal(signal.SIGTERM) is end_as_interrupted
    before = [
        (number, signal.signal(number, pressed))
        for number in (signal.SIGINT, *([signal.SIGTERM] if command else []))
    ]
    try:
        yield
    finally:
        for number, old in before:
            signal.signal(number, old)


@contextmanager
def interruption(given_up: Callable[[], bool] = lambda: False) -> Iterator[None]:
    """Turn the first Ctrl-C or SIGTERM into a flag that is checked between two steps.

    If it were raised at once, it would interrupt whatever code runs at that moment, even inside a Python FMU.
    A second Ctrl-C is raised at once, for a step that does not end; so is the first while what runs may be
    `given_up` at any moment.
    """
    cells = here.cells

    def note(number: int, frame: FrameType | None) -> None:
        again, cells[ASKED] = cells[ASKED], 1
        if again or given_up():
            raise Terminated if number == signal.SIGTERM else KeyboardInterrupt

    try:
        with on_ctrl_c(note):
            yield
    finally:
        cells[ASKED] = 0
