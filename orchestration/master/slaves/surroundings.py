"""What FMUs in one process share, and may change for each other: rounding, locale, working folder."""

from __future__ import annotations

import contextlib
import ctypes
import locale
import os
import sys
from pathlib import Path
from typing import Any

_ENVIRONMENT_BYTES = 256  # the largest of any platform is far below
_TINY = sys.float_info.min


class Surroundings:
    """What the process's arithmetic, locale and folder were when this object was made."""

    def __init__(self) -> None:
        self._c = _c_library()
        self._arithmetic = ctypes.create_string_buffer(_ENVIRONMENT_BYTES)
        if self._c is not None:
            self._c.fegetenv(self._arithmetic)
        self._rounding = self._rounds()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._folder = working_folder()

    def put_back(self) -> tuple[str, ...]:
        """Undo what has changed since; give its names."""
        changed = []
        if self._rounds() != self._rounding:
            changed.append("how numbers are rounded")
            if self._c is not None:
                self._c.fesetenv(self._arithmetic)
        if locale.setlocale(locale.LC_ALL) != self._locale:
            changed.append("the locale")
            locale.setlocale(locale.LC_ALL, self._locale)
        if self._folder is not None and working_folder() != self._folder:
            changed.append("the working folder")
            with contextlib.suppress(OSError):  # it is gone
                os.chdir(self._folder)
        return tuple(changed)

    def _rounds(self) -> tuple[int, bool]:
        """Tell the direction of rounding, and whether very small numbers are kept (FTZ and DAZ are off)."""
        direction = 0 if self._c is None else self._c.fegetround()
        return direction, _TINY * 0.5 > 0.0


def _c_library() -> Any:
    """The C library that this process has already, where it offers its floating-point environment."""
    if sys.platform == "win32":
        return None
    library = ctypes.CDLL(None)
    return library if hasattr(library, "fegetenv") and hasattr(library, "fesetenv") else None


def working_folder() -> Path | None:
    """Give the working folder; None where it is gone."""
    try:
        return Path.cwd()
    except OSError:
        return None
