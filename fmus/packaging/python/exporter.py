"""What pythonfmu's library leaves undone, made good from inside the slave."""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import os
import sys
import threading
from pathlib import Path

_known: set[str] = set()


def finish_at_exit(resources: str) -> None:
    """Have the library of an FMU give up its hold on the interpreter before the process ends.

    On Linux version 0.7.0 does that twice as the process ends, once in a destructor of its own after the
    held object was destroyed, and corrupts the heap; with nothing held any more, both do nothing.

    Parameters
    ----------
    resources : folder `resources` of the extracted FMU, whose library is loaded
    """
    if not sys.platform.startswith("linux"):
        return
    for library in Path(resources).parent.glob("binaries/*/*.so"):
        if str(library) not in _known:
            _known.add(str(library))
            # A library that is not loaded, or has no such function, needs none of this.
            with contextlib.suppress(OSError, AttributeError):
                loaded = ctypes.CDLL(str(library), mode=os.RTLD_NOLOAD | os.RTLD_NOW)
                atexit.register(_finish, loaded.finalizePythonInterpreter)


def _finish(release: ctypes._NamedFuncPointer) -> None:
    # In a host that is not Python the library runs the interpreter in a thread of its own, which ends it
    # here and cannot wait for itself.
    if threading.get_native_id() == os.getpid():
        release()
