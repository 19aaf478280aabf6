"""Ctrl-C while a machine is watched: it ends the watch between two rows.

Raised at once it would end whatever runs, half done, and libraries make other faults of it or drop it.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from warmlink.orchestration.console import Terminated
from warmlink.orchestration.master.slaves.under_way import on_ctrl_c


class Ending:
    """Whether Ctrl-C, or SIGTERM in a command, has asked for the end.

    Parameters
    ----------
    given_up : whether what runs now may be given up at any moment: then, and at a second Ctrl-C, it is raised
        at once
    """

    def __init__(self, given_up: Callable[[], bool]) -> None:
        self.asked, self._given_up = False, given_up

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Note what comes meanwhile, where this is the main thread."""
        with on_ctrl_c(self._note):
            yield

    def _note(self, number: int, frame: FrameType | None) -> None:
        again, self.asked = self.asked, True
        if again or self._given_up():
            raise Terminated if number == signal.SIGTERM else KeyboardInterrupt
