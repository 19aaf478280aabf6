"""Runs that keep pace with real time, and runs that are stopped by Ctrl-C."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from warmlink.orchestration.master.slaves import under_way


class Clock:
    """Holds each communication point back until its time has come.

    The pace is in simulated seconds for each second of wall time. The `lag` is the largest delay of a point
    behind its time, in s of wall time.
    """

    def __init__(self, pace: float) -> None:
        self._pace = pace
        self._began = time.monotonic()
        self.lag = 0.0

    def wait(self, elapsed: float) -> None:
        """Wait until `elapsed` simulated seconds are due."""
        ahead = self._began + elapsed / self._pace - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        else:
            self.lag = max(self.lag, -ahead)


@contextmanager
def on_ctrl_c(pressed: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Have Ctrl-C call a function, where this is the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    old = signal.signal(signal.SIGINT, pressed)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, old)


@contextmanager
def interruption() -> Iterator[None]:
    """Turn the first Ctrl-C into a flag that is checked between two steps.

    If it were raised at once, it would interrupt whatever code runs at that moment, even inside a Python FMU.
    A second Ctrl-C is raised at once, for a step that does not end.
    """
    cells = under_way.here.cells

    def note(number: int, frame: FrameType | None) -> None:
        if cells[under_way.ASKED]:
            raise KeyboardInterrupt
        cells[under_way.ASKED] = 1

    try:
        with on_ctrl_c(note):
            yield
    finally:
        cells[under_way.ASKED] = 0
