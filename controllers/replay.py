"""A law run through a log: at each sample it sees what was logged, and a camera what it has left.

In C where there is a compiler, in Python elsewhere; both give the numbers of the law's FMU.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import Symbols, beginning, function, sampling
from warmlink.fmus.packaging.native.compile import library_here
from warmlink.fmus.packaging.native.library import loaded

Array = NDArray[np.float64]

_LOOP = Path(__file__).parent / "export" / "templates" / "replay.c"

_DRIFT, _VALID, _CORRECTION = "measured_drift", "drift_valid", "correction"


@dataclass(frozen=True)
class ReplayedOutputs:
    """What a law said at each sample, shapes (n,): correction and its standard deviation in m, and flags."""

    correction: Array
    correction_std: Array
    ready: Array
    distrusted: Array


def replay(law: Component, inputs: Array, measured: Array | None = None) -> ReplayedOutputs:
    """Run a law over the rows of a log, one for each of its samples.

    Parameters
    ----------
    law : with the start values of its parameters
    inputs : in the order of the law's inputs, in SI units, shape (n, u.size); NaN where there is no reading
    measured : growth in m where a camera sees it, else NaN, shape (n,); without it there is no camera

    Raises
    ------
    InputError
        A parameter is refused.
    """
    rows = np.ascontiguousarray(inputs, dtype=float)
    seen = np.full(len(rows), np.nan) if measured is None else np.ascontiguousarray(measured, dtype=float)
    instance = Instance(law)
    instance.set(dict(zip(law.u.names, map(float, rows[0]), strict=True)))
    instance.initialize()  # which refuses what an FMU refuses
    try:
        library = _library(law)
    except InputError:  # no compiler
        found = _in_python(law, instance, rows, seen)
    else:
        design = np.ascontiguousarray(law.settled(law.start_values()[0]), dtype=float)
        found = np.empty((len(rows), law.y.size))
        pointers = (each.ctypes.data_as(ctypes.c_void_p) for each in (rows, seen, design))
        period = ctypes.c_double(_period(law))
        out = found.ctypes.data_as(ctypes.c_void_p)
        loaded(library).replay(ctypes.c_long(len(rows)), *pointers, period, out)
    names = (_CORRECTION, "correction_std", "ready", "distrusted")
    return ReplayedOutputs(*(np.array(found[:, law.y.index[name]]) for name in names))


def period(law: Component) -> float:
    """Time in s between two samples of a law; 1 s for one that remembers nothing."""
    return _period(law)


def _period(law: Component) -> float:
    values = dict(zip(law.p.names, law.start_values()[0].tolist(), strict=True))
    return float(values.get("sample_time", 1.0))


def _in_python(law: Component, instance: Instance, rows: Array, measured: Array) -> Array:
    """Outputs at each row, shape (n, y.size)."""
    found, step, drift = np.empty((len(rows), law.y.size)), _period(law), None
    for k, row in enumerate(rows):
        if k and np.isfinite(measured[k]):
            drift = measured[k] - found[k - 1, law.y.index[_CORRECTION]]
        given = dict(zip(law.u.names, map(float, row), strict=True))
        given |= {_DRIFT: 0.0 if drift is None else drift, _VALID: float(drift is not None)}
        instance.set(given)
        if k:
            instance.step((k - 1) * step, step)
        found[k] = instance.outputs()
    return found


@lru_cache(maxsize=8)
def _library(law: Component) -> bytes:
    """The law and the loop over rows as a shared library; its design is an argument."""
    functions = []
    if law.states:
        functions += [function(*next(beginning(law))), function(*sampling(law, 0))]
    s = Symbols.of(law, calls=law.sampled)
    functions.append(function("outputs", s.now, law.outputs_of(*s.now)))
    places = {
        "INPUTS": law.u.size,
        "STATES": law.x.size,
        "OUTPUTS": law.y.size,
        "DRIFT": law.u.index[_DRIFT],
        "VALID": law.u.index[_VALID],
        "CORRECTION": law.y.index[_CORRECTION],
    }
    text = functions_text(functions, declared=())
    text += "".join(f"#define {name} {value}\n" for name, value in places.items())
    return _compiled(text + _LOOP.read_text("utf-8"))


@cache
def _compiled(source: str) -> bytes:
    return library_here({"replay.c": source}, "replay", "-w")
