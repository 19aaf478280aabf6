"""Runs that keep to the clock on the wall, and runs that somebody stops."""

from __future__ import annotations

import signal
import threading
import time
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Any

from warmlink.orchestration.master.slaves import under_way


@dataclass(frozen=True)
class Pacing:
    """Simulated seconds for each second of wall time; 1 is real time."""

    factor: float = 1.0


class Clock:
    """Holds each communication point back until its time has come.

    Attributes
    ----------
    lag : float
        Largest delay of a point behind its time, in s of wall time.
    """

    def __init__(self, pacing: Pacing) -> None:
        self._factor = pacing.factor
        self._began = time.monotonic()
        self.lag = 0.0

    def wait(self, elapsed: float) -> None:
        """Wait until `elapsed` simulated seconds are due."""
        ahead = self._began + elapsed / self._factor - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        else:
            self.lag = max(self.lag, -ahead)


class Interruption:
    """Turns the first Ctrl-C into a flag that is looked at between steps.

    Raised at once, it would hit whatever runs at that moment, the inside of a Python FMU included. A second
    one is raised, for a step that does not end.
    """

    def __init__(self) -> None:
        self._cells = under_way.here.cells
        self._old: Any = None
        self._active = False

    @property
    def asked(self) -> bool:
        """Whether to stop; a process that guards this one may ask for it too."""
        return bool(self._cells[under_way.ASKED])

    def __enter__(self) -> Interruption:
        """Take over SIGINT, where this is the main thread."""
        if threading.current_thread() is threading.main_thread():
            self._old = signal.signal(signal.SIGINT, self._note)
            self._active = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give SIGINT back."""
        if self._active:
            signal.signal(signal.SIGINT, self._old)
        self._cells[under_way.ASKED] = 0

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self._cells[under_way.ASKED] = 1
