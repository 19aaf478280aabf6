"""Shared libraries that are called from Python."""

import contextlib
import ctypes
import tempfile
from functools import lru_cache
from pathlib import Path

from warmlink.fmus.errors import InputError


@lru_cache(maxsize=16)
def loaded(library: bytes) -> ctypes.CDLL:
    """A library, loaded from its contents; InputError where the system does not allow that."""
    folder = Path(tempfile.mkdtemp(prefix="warmlink-"))
    file = folder / "library"
    file.write_bytes(library)
    try:
        return ctypes.CDLL(str(file))
    except OSError as fault:
        raise InputError(
            f"{folder}: what was compiled does not load from there ({fault}); name another folder in TMPDIR"
        ) from None
    finally:
        with contextlib.suppress(OSError):  # Windows keeps the file of a loaded library
            file.unlink()
            folder.rmdir()
