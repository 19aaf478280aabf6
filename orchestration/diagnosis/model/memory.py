"""Memory of arrays that are made and left again and again, which took a tenth of the time of a diagnosis."""

from __future__ import annotations

import ctypes
from contextlib import suppress
from functools import cache

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""What glibc's `mallopt` calls them, `man 3 mallopt`."""

_LARGEST = 32 << 20
"""Bytes of an array that is a mapping of its own, the most that glibc allows."""

_LEFT = 128 << 20
"""Bytes that are free before any are given back."""


@cache
def keep_memory() -> None:
    """Let this process keep what arrays of simulations leave, for those of the next ones.

    glibc gave it back to the system after each of them, and every page of the next one had to be cleared.
    Another C library handles memory as it pleases.
    """
    with suppress(AttributeError, OSError, TypeError):  # TypeError: on Windows no library is without a name
        library = ctypes.CDLL(None)
        library.mallopt(_MMAP_THRESHOLD, _LARGEST)
        library.mallopt(_TRIM_THRESHOLD, _LEFT)
