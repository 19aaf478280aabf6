"""The macro-step loop in C, compiled by this machine's compiler once and kept."""

from __future__ import annotations

import ctypes
import platform
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.library import loaded
from warmlink.orchestration.master.compiled.layout import Layout, Numbers

NOTHING, STEP, GET, SET, NOT_FINITE, TERMINATE = range(6)
"""What failed, as `cells[0]` says."""

_SOURCE = Path(__file__).parent / "sources" / "loop.c"


@cache
def library() -> ctypes.CDLL:
    """The loop; InputError if it is not kept and there is no C compiler."""
    text = _SOURCE.read_text("utf-8")

    def compiled() -> bytes:
        from warmlink.fmus.packaging.native.compile import compilers, platforms_named

        (compiler,) = compilers(platforms_named(None))
        return compiler.library({"loop.c": text}, "loop")

    return loaded(kept("loops", (sys.platform, platform.machine(), text), compiled))


def advance(
    at_once: bool,
    sequence: Numbers,
    first: int,
    last: int,
    times: Any,
    layout: Layout,
    rows: Any,
    row: int,
    cells: Numbers,
) -> int:
    """Step from communication point `first` to `last`; give the point reached.

    Parameters
    ----------
    at_once : bool
        Jacobi; else Gauss-Seidel.
    sequence : ndarray of int64
        Slaves in the order of stepping.
    times : ndarray of float64
        Start time and communication step size in s, and the times of all points where steps differ.
    layout : Layout
        What the loop runs over.
    rows : ndarray, shape (more than last - first, columns)
        Filled from index `row` on, a row for each point.
    cells : ndarray of int64
        Those of `under_way`: what, which slave, which status, filled where something fails; then the call
        under way and the rows recorded.
    """
    slaves, reads, writes, wires, checks, columns = layout.tables
    assert rows.dtype == np.float64
    assert rows.flags.c_contiguous

    def whole(number: int) -> ctypes.c_int64:
        return ctypes.c_int64(number)

    def at(array: Any) -> ctypes.c_void_p:
        return ctypes.c_void_p(array.ctypes.data)

    step = library().advance
    step.restype = ctypes.c_int64
    reached = step(
        ctypes.c_int(at_once),
        *(at(sequence), whole(len(sequence)), whole(first), whole(last), at(times), whole(len(times) > 2)),
        *(at(slaves), at(reads), whole(len(reads)), at(writes), at(wires), at(checks)),
        *(at(columns), whole(len(columns)), at(layout.factors)),
        *(at(buffer) for buffer in layout.buffers),
        *(at(layout.ranges), at(rows[row:]), at(cells)),
    )
    return int(reached)
