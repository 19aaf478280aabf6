"""Log lines of FMUs: collected for error messages, never printed.

FMPy's native proxy, which formats the variadic arguments of a log call, knows one Python callback in the
whole process and does not keep it alive. So there is one callback here, alive as long as the process, and
the environment pointer that each instance was given says whose line it is.
"""

from __future__ import annotations

import itertools
import sys
from collections import deque
from ctypes import CDLL, CFUNCTYPE, Structure, byref, c_char_p, c_int, c_void_p, cast
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar
from weakref import WeakValueDictionary

from warmlink.orchestration.master.slaves.library import SUFFIX, c_library, platform_name

KEPT_LINES = 200
_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_LOG = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class FmuLog:
    """The last log lines of one instance.

    Attributes
    ----------
    key : int
        Given to the FMU as its environment.
    open : mapping
        All logs by their keys.
    """

    _keys = itertools.count(1)
    open: ClassVar[WeakValueDictionary[int, FmuLog]] = WeakValueDictionary()

    def __init__(self) -> None:
        self.key = next(self._keys)
        self._lines: deque[tuple[str, str]] = deque(maxlen=KEPT_LINES)
        self.open[self.key] = self

    def add(self, status: int, message: bytes | str | None) -> None:
        """Keep a line."""
        text = message.decode("utf-8", "replace") if isinstance(message, bytes) else message or ""
        name = _STATUS[status] if 0 <= status < len(_STATUS) else str(status)
        self._lines.append((name, " ".join(text.split())))

    def clear(self) -> None:
        """Forget what was logged so far."""
        self._lines.clear()

    def tell(self) -> str:
        """Give the lines that explain a failure: those that are not mere information, else the last few."""
        telling = [text for status, text in self._lines if status != "ok" and text]
        chosen = telling[-5:] or [text for _, text in self._lines if text][-3:]
        return f"; it logged: {' | '.join(dict.fromkeys(chosen))}" if chosen else "; it logged nothing"


def fmi2_callbacks(log: FmuLog) -> Any:
    """Make the callback functions of an FMI 2.0 instance whose lines a log keeps.

    They must be kept alive until the instance is freed.
    """
    shared = _fmi2_shared()
    own = type(shared).from_buffer_copy(shared)
    own.environment = log.key
    return own


class _Callbacks(Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = (
        ("logger", _LOG),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("step_finished", c_void_p),
        ("environment", c_void_p),
    )


@cache
def _fmi2_shared() -> _Callbacks:
    """Callback functions that FMPy's proxy knows, kept alive as long as the process."""

    def log(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
        kept = FmuLog.open.get(environment or 0)
        if kept is None:
            print(message.decode("utf-8", "replace"), file=sys.stderr)
        else:
            kept.add(status, message)

    c = c_library()
    shared = _Callbacks(_LOG(log), cast(c.calloc, c_void_p), cast(c.free, c_void_p))
    # The package itself would take longer to import than an hour of the cell takes to run.
    package = find_spec("fmpy")
    if package is not None and package.origin is not None:
        folder = Path(package.origin).parent / "logging" / platform_name("fmi2")
        CDLL(str(folder / f"logging{SUFFIX}")).addLoggerProxy(byref(shared))
    return shared
