"""Instantiate an FMU, unpacked, by ctypes alone and end without freeing it, as hosts do."""

from __future__ import annotations

import ctypes
import sys

folder, name = sys.argv[1:]
library = ctypes.PyDLL(f"{folder}/binaries/linux64/{name}.so")
library.fmi2Instantiate.restype = ctypes.c_void_p
library.fmi2Instantiate.argtypes = [
    ctypes.c_char_p,
    ctypes.c_int,
    ctypes.c_char_p,
    ctypes.c_char_p,
    ctypes.c_void_p,
    ctypes.c_int,
    ctypes.c_int,
]
callbacks = (ctypes.c_void_p * 5)()
resources = f"file://{folder}/resources".encode()
assert library.fmi2Instantiate(b"one", 1, b"", resources, callbacks, 0, 0) is not None
print("ended")
