"""What sources on a network share: a thread that listens, and a queue from which rows are taken."""

from __future__ import annotations

import asyncio
import queue
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence

from warmlink.fmus.errors import InputError
from warmlink.orchestration.watch.sources.protocol import FilePlace
from warmlink.orchestration.watch.sources.rows import Cells

_WAITING, _POLL, _AGAIN = 100_000, 0.2, (1.0, 30.0)
"""Rows that may wait, s between looks, and s until a connection is tried again, at first and at most."""

_MOST_TOLD = 100
"""Sentences that are kept until somebody asks."""

_FIRST = 10.0
"""s within which the first connection has to stand."""


class ServedSource(ABC):
    """Rows that a server gives; a lost connection is made anew, and told of.

    Parameters
    ----------
    name : address, without a password
    """

    headers: Sequence[str]
    comma = False

    def __init__(self, name: str) -> None:
        self.name = name
        self.told: list[str] = []
        self._queue: queue.Queue[Cells] = queue.Queue(_WAITING)
        self._over, self._stands = threading.Event(), threading.Event()
        self._fault = ""
        self._refused: InputError | None = None
        self._thread = threading.Thread(target=self._listen, name="source", daemon=True)

    def begin(self) -> None:
        """Connect; raises InputError where that cannot be done."""
        self._thread.start()
        until = time.monotonic() + _FIRST
        while not self._stands.wait(_POLL):
            if self._refused is not None or (self._fault and time.monotonic() > until):
                self.close()
                told = f"{self.name}: cannot be reached ({self._fault}); start it, or correct the address"
                raise self._refused or InputError(told)

    def rows(self) -> Iterator[Cells | None]:
        """Rows as they come; None if there is nothing new for the moment."""
        while not self._over.is_set():
            try:
                yield self._queue.get(timeout=_POLL)
            except queue.Empty:
                yield None

    def place(self) -> FilePlace | None:
        """None: a server cannot go back."""
        return None

    def close(self) -> None:
        """Let go of the connection."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    @abstractmethod
    async def listen(self) -> None:
        """Connect, call `stands`, and put rows until the connection is lost or `is_over`."""

    @property
    def is_over(self) -> bool:
        """Whether nobody wants rows any more."""
        return self._over.is_set()

    def stands(self) -> None:
        """Say that the connection stands."""
        if self._stands.is_set():
            self.tell(f"{self.name}: is connected again")
        self._fault = ""
        self._stands.set()

    def tell(self, sentence: str) -> None:
        """Keep what is to be said until somebody asks; of more than a hundred sentences the oldest go."""
        self.told = [*self.told[1 - _MOST_TOLD :], sentence]

    def put(self, cells: Cells) -> None:
        """Give a row; where nobody takes them for long the oldest goes."""
        while True:
            try:
                self._queue.put_nowait(cells)
            except queue.Full:
                self._queue.get_nowait()
            else:
                return

    def _listen(self) -> None:
        asyncio.run(self._again())

    async def _again(self) -> None:
        """Listen again and again, after longer and longer pauses while nobody answers."""
        pause, most = _AGAIN
        while not self.is_over:
            try:
                await self.listen()
                pause = _AGAIN[0]
            except InputError as fault:
                self._refused = fault
                return
            except Exception as fault:  # whatever a library of the network raises
                if not self._fault and self._stands.is_set():
                    self.tell(f"{self.name}: the connection is lost ({_in_words(fault)}); it is tried again")
                self._fault = _in_words(fault)
            until = time.monotonic() + pause
            pause = min(2 * pause, most)
            while not self.is_over and time.monotonic() < until:
                await asyncio.sleep(_POLL)


def _in_words(fault: Exception) -> str:
    return (str(fault) or type(fault).__name__).splitlines()[0]
