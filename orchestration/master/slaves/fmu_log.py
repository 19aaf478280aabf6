"""What an instance of an FMU logs."""

from __future__ import annotations

import itertools
from collections import deque
from typing import ClassVar
from weakref import WeakValueDictionary

_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")


class FmuLog:
    """The last log lines of one instance, never printed; the FMU was given its key as its environment."""

    _keys = itertools.count(1)
    open: ClassVar[WeakValueDictionary[int, FmuLog]] = WeakValueDictionary()

    def __init__(self) -> None:
        self.key = next(self._keys)
        self.lines: deque[tuple[str, str]] = deque(maxlen=200)
        self.open[self.key] = self

    def add(self, status: int, message: bytes | str | None) -> None:
        """Keep a line."""
        text = message.decode("utf-8", "replace") if isinstance(message, bytes) else message or ""
        name = _STATUS[status] if 0 <= status < len(_STATUS) else str(status)
        self.lines.append((name, " ".join(text.split())))

    @property
    def complains(self) -> bool:
        """Whether a line is more than information."""
        return any(status != "ok" and text for status, text in self.lines)

    def tell(self) -> str:
        """Give the lines that explain a failure: those that are not mere information, else the last few."""
        telling = [text for status, text in self.lines if status != "ok" and text]
        chosen = telling[-5:] or [text for _, text in self.lines if text][-3:]
        return f"; it logged: {' | '.join(dict.fromkeys(chosen))}" if chosen else "; it logged nothing"
