"""Shared libraries that are called from Python."""

import contextlib
import ctypes
import os
import platform
import sys
from functools import cache, lru_cache
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import scratch_folder

# Numbers are the same on every machine: no fused multiply-add, no liberties with NaN, no x87.
FLAGS = (
    *("-std=c99", "-O2", "-fPIC", "-g0", "-fno-math-errno", "-ffp-contract=off", "-fvisibility=hidden"),
    "-falign-functions=64",  # where a function happens to begin is worth a tenth of the time
)
"""Flags of every C compiler."""


def made_here() -> tuple[object, ...]:
    """What a library for this machine depends on beside its text: where and how it is compiled."""
    return sys.platform, platform.machine(), os.environ.get("CC"), FLAGS


@lru_cache(maxsize=16)
def loaded(library: bytes) -> ctypes.CDLL:
    """A library, loaded from its contents; InputError where the system does not allow that."""
    with scratch_folder() as folder:  # Windows keeps the file of a loaded library
        file = folder / "library"
        try:
            file.write_bytes(library)
            return ctypes.CDLL(str(file))
        except OSError as fault:
            told = f"{folder}: what was compiled does not load from there ({fault})"
            raise InputError(f"{told}; name another folder in TMPDIR") from None


@cache
def processor() -> tuple[int, str | None]:
    """Lanes worth their while on this machine, and the level of its processor as compilers name it."""
    flags = set[str]()
    with contextlib.suppress(OSError):
        flags = set(Path("/proc/cpuinfo").read_text("utf-8").partition("flags")[2].partition("\n")[0].split())
    if {"avx512f", "avx512dq", "avx512vl", "avx512bw", "avx512cd"} <= flags:
        return 8, "x86-64-v4"
    return 4, "x86-64-v3" if {"avx2", "fma", "bmi2"} <= flags else None
