"""Instantiate an FMU by ctypes alone and end without freeing it, as hosts do."""

from __future__ import annotations

import ctypes
import sys
import tempfile
import zipfile
from pathlib import Path

fmu = Path(sys.argv[1])
folder = Path(tempfile.mkdtemp())
with zipfile.ZipFile(fmu) as archive:
    archive.extractall(folder)
library = ctypes.PyDLL(str(folder / "binaries" / "linux64" / f"{fmu.stem}.so"))
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
resources = (folder / "resources").as_uri().encode()
assert library.fmi2Instantiate(b"one", 1, b"", resources, callbacks, 0, 0) is not None
print("ended")
