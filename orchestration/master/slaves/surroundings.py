"""What the libraries of a process share: how it calculates, its locale, its working folder."""

from __future__ import annotations

import ctypes
import locale
import os
import platform
import struct
import sys
from contextlib import suppress
from operator import and_
from pathlib import Path
from typing import Any


def c_library() -> Any:
    """The C library of this process."""
    return ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)


_ENVIRONMENT_BYTES = 256  # the largest of any platform is far below
_TINY = sys.float_info.min

# Where fegetenv writes what steers arithmetic (rounding, precision, which faults end the process, what
# becomes of very small numbers), and which bits of it are no mere flags of what has happened.
_CONTROLS = {
    ("linux", "x86_64"): ("<H26xI", (0xFFFF, 0xFFC0)),
    ("linux", "aarch64"): ("<I", (0xFFFFFFFF,)),
    ("darwin", "x86_64"): ("<H2xI", (0xFFFF, 0xFFC0)),
    ("darwin", "arm64"): ("<8xQ", (0xFFFFFFFF,)),
}


class Surroundings:
    """What the process's arithmetic, locale and folder were when this object was made."""

    def __init__(self) -> None:
        self._c = c_library() if hasattr(c_library(), "fegetenv") else None
        self._arithmetic, self._now = (ctypes.create_string_buffer(_ENVIRONMENT_BYTES) for _ in range(2))
        known = _CONTROLS.get((sys.platform, platform.machine())) if self._c is not None else None
        self._unpack = struct.Struct(known[0]).unpack_from if known else None
        self._bits: tuple[int, ...] = known[1] if known else ()
        self._seen: tuple[int, ...] = ()
        if self._c is not None:
            self._fegetenv = self._c.fegetenv
            self._fegetenv(self._arithmetic)
        self._rounding, self._controls = self._rounds(), self._controlled()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._folder = working_folder()

    def put_back(self) -> tuple[str, ...]:
        """Undo what has changed since; give its names."""
        changed = []
        rounds = self._rounds()
        if rounds != self._rounding or self._controlled() != self._controls:
            other = "which faults of arithmetic end the process, or its precision"
            changed.append("how numbers are rounded" if rounds != self._rounding else other)
            if self._c is not None:
                self._c.fesetenv(self._arithmetic)
        if locale.setlocale(locale.LC_ALL) != self._locale:
            changed.append("the locale")
            locale.setlocale(locale.LC_ALL, self._locale)
        if self._folder is not None and working_folder() != self._folder:
            changed.append("the working folder")
            with suppress(OSError):  # it is gone
                os.chdir(self._folder)
        return tuple(changed)

    def calculates_otherwise(self) -> bool:
        """Tell whether arithmetic has changed since, in less than a microsecond."""
        if self._unpack is None:
            return self._rounds() != self._rounding
        self._fegetenv(self._now)
        seen = self._unpack(self._now)
        if seen == self._seen:  # what has happened is noted once, and rarely forgotten
            return False
        self._seen = seen
        return self._controlled() != self._controls

    def _controlled(self) -> tuple[int, ...]:
        """Give what steers arithmetic, where this platform tells more than the rounding."""
        if self._unpack is None:
            return ()
        self._fegetenv(self._now)
        return tuple(map(and_, self._unpack(self._now), self._bits))

    def _rounds(self) -> tuple[int, bool]:
        """Tell the direction of rounding, and whether very small numbers are kept (FTZ and DAZ are off)."""
        direction = 0 if self._c is None else self._c.fegetround()
        return direction, _TINY * 0.5 > 0.0


def working_folder() -> Path | None:
    """Give the working folder; None where it is gone."""
    try:
        return Path.cwd()
    except OSError:
        return None
