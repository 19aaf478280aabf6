"""The macro-step loop, compiled by Numba over FMI function pointers.

Importing this module compiles the loop or loads it from Numba's cache. That must happen before any FMU
library is loaded: compiled after a Python FMU was loaded, processes crashed at their exit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

# Typed as anything: a checker would count the typing context among the arguments.
_intrinsic: Any = intrinsic

# Kinds of values, as buffers hold them.
FLOAT64, INT32, UINT8 = 0, 1, 2
# Only `advance` is cached; the functions it is made of are compiled with it, when it is.

# What failed, as `cells[0]` says.
NOTHING, STEP, GET, SET, NOT_FINITE, TERMINATE = 0, 1, 2, 3, 4, 5

_POINTER = ir.IntType(8).as_pointer()
_INT32, _INT64, _DOUBLE, _BYTE = ir.IntType(32), ir.IntType(64), ir.DoubleType(), ir.IntType(8)


def _call(builder: Any, address: Any, arguments: list[tuple[Any, Any]]) -> Any:
    """Call the function at an address; each argument comes with its type, integers becoming pointers."""
    kind = ir.FunctionType(_INT32, [t for t, _ in arguments])
    values = [builder.inttoptr(v, t) if t == _POINTER else v for t, v in arguments]
    return builder.call(builder.inttoptr(address, kind.as_pointer()), values)


@_intrinsic
def _exchange2(typing: Any, f: Any, c: Any, references: Any, n: Any, values: Any) -> Any:
    """fmi2GetXXX and fmi2SetXXX."""

    def generate(context: Any, builder: Any, signature: Any, a: Any) -> Any:
        return _call(builder, a[0], [(_POINTER, a[1]), (_POINTER, a[2]), (_INT64, a[3]), (_POINTER, a[4])])

    return types.int32(*[types.int64] * 5), generate


@_intrinsic
def _exchange3(typing: Any, f: Any, c: Any, references: Any, n: Any, values: Any) -> Any:
    """fmi3GetXXX and fmi3SetXXX: as many values as references."""

    def generate(context: Any, builder: Any, signature: Any, a: Any) -> Any:
        arguments = [(_POINTER, a[1]), (_POINTER, a[2]), (_INT64, a[3]), (_POINTER, a[4]), (_INT64, a[3])]
        return _call(builder, a[0], arguments)

    return types.int32(*[types.int64] * 5), generate


@_intrinsic
def _step2(typing: Any, f: Any, c: Any, time: Any, step: Any) -> Any:
    """fmi2DoStep."""

    def generate(context: Any, builder: Any, signature: Any, a: Any) -> Any:
        zero = ir.Constant(_INT32, 0)
        return _call(builder, a[0], [(_POINTER, a[1]), (_DOUBLE, a[2]), (_DOUBLE, a[3]), (_INT32, zero)])

    return types.int32(types.int64, types.int64, types.float64, types.float64), generate


@_intrinsic
def _step3(typing: Any, f: Any, c: Any, time: Any, step: Any, flags: Any, last: Any) -> Any:
    """fmi3DoStep; `flags` is the address of three Booleans: event, terminate, early return."""

    def generate(context: Any, builder: Any, signature: Any, a: Any) -> Any:
        flag = [(_POINTER, builder.add(a[4], ir.Constant(_INT64, i))) for i in range(3)]
        head = [(_POINTER, a[1]), (_DOUBLE, a[2]), (_DOUBLE, a[3]), (_BYTE, ir.Constant(_BYTE, 0))]
        return _call(builder, a[0], [*head, *flag, (_POINTER, a[5])])

    signature = types.int32(types.int64, types.int64, types.float64, types.float64, types.int64, types.int64)
    return signature, generate


_I2 = types.int64[:, ::1]
_I1 = types.int64[::1]
_F1 = types.float64[::1]
_BUFFERS = types.Tuple((_F1, types.int32[::1], types.uint8[::1]))
_TABLES = types.Tuple((_I2, _I2, _I2, _I2, _I1, _I2))

# The pieces are inlined with their arrays one by one: called with tuples of arrays, counting references
# took six times as long as the FMI calls.


@njit(inline="always")
def _value(doubles: Any, ints: Any, octets: Any, kind: int, index: int) -> float:
    value = 0.0
    if kind == FLOAT64:
        value = doubles[index]
    elif kind == INT32:
        value = float(ints[index])
    elif octets[index] != 0:
        value = 1.0
    return value


@njit(inline="always")
def _exchange(batches: Any, first: int, last: int) -> int:
    """Get or set some batches; give the worst status."""
    worst = 0
    for b in range(first, last):
        function, component, references, count = batches[b, 0], batches[b, 1], batches[b, 2], batches[b, 3]
        if batches[b, 5] == 2:
            status = _exchange2(function, component, references, count, batches[b, 4])
        else:
            status = _exchange3(function, component, references, count, batches[b, 4])
        if status > 1:
            worst = status
            break
    return worst


@njit(inline="always")
def _gather(wires: Any, factors: Any, doubles: Any, ints: Any, octets: Any, first: int, last: int) -> None:
    """Pass outputs on to inputs."""
    for w in range(first, last):
        value = _value(doubles, ints, octets, wires[w, 0], wires[w, 1])
        if wires[w, 2] == FLOAT64:
            if factors[2 * w] != 1.0 or factors[2 * w + 1] != 0.0:
                value = factors[2 * w] * value + factors[2 * w + 1]
            doubles[wires[w, 3]] = value
        elif wires[w, 2] == INT32:
            ints[wires[w, 3]] = np.int32(value)
        else:
            octets[wires[w, 3]] = np.uint8(value != 0.0)


@njit(inline="always")
def _first_not_finite(checks: Any, doubles: Any, first: int, last: int) -> int:
    """Give the index of the first check that fails, or -1."""
    found = -1
    for c in range(first, last):
        if not np.isfinite(doubles[checks[c]]):
            found = c
            break
    return found


@njit(inline="always")
def _do_step(slaves: Any, k: int, time: float, step_size: float) -> int:
    """Advance a slave; give its status."""
    if slaves[k, 2] == 2:
        status = _step2(slaves[k, 1], slaves[k, 0], time, step_size)
    else:
        status = _step3(slaves[k, 1], slaves[k, 0], time, step_size, slaves[k, 3], slaves[k, 4])
    return status


@njit(
    types.int64(
        types.boolean,
        _I1,
        types.int64,
        types.int64,
        _F1,
        _TABLES,
        _F1,
        _BUFFERS,
        _I2,
        types.float64[:, ::1],
        types.int64,
        _I1,
    ),
    nogil=True,
    cache=True,
)
def advance(
    at_once: bool,
    sequence: Any,
    first: int,
    last: int,
    times: Any,
    tables: Any,
    factors: Any,
    buffers: Any,
    ranges: Any,
    rows: Any,
    row: int,
    cells: Any,
) -> int:
    """Step from communication point `first` to `last`; give the point reached.

    A step is a list of jobs, one a slave: Jacobi steps all, reads all, writes all; Gauss-Seidel writes,
    steps and reads one after the other.

    Parameters
    ----------
    at_once : bool
        Jacobi; else Gauss-Seidel.
    sequence : ndarray of int64
        Slaves in the order of stepping.
    times : ndarray of float64
        Start time and communication step size in s.
    tables, factors, buffers, ranges
        As `layout.Layout` lays them out.
    rows : ndarray, shape (more than last - first, columns)
        Filled from index `row` on, a row for each point.
    cells : ndarray of int64
        Those of `under_way`: what, which slave, which status, filled where something fails; then the call
        under way and the rows recorded.
    """
    slaves, reads, writes, wires, checks, columns = tables
    doubles, ints, octets = buffers
    n = len(sequence)
    late = ranges[0, n]
    for point in range(first + 1, last + 1):
        time = times[0] + (point - 1) * times[1]
        for job in range(3 * n):
            # Jacobi: job // n is the deed, job % n the slave; Gauss-Seidel: the other way round.
            if at_once:
                k, deed = job % n, job // n
            else:
                k, deed = sequence[job // 3], (job % 3 + 2) % 3
            cells[3] = slaves[k, 5] + (deed != 0)
            if deed == 0:
                status = _do_step(slaves, k, time, times[1])
                if status > 1:
                    cells[0], cells[1], cells[2] = STEP, k, status
                    return point - 1
                if slaves[k, 2] == 3 and octets[1] != 0:
                    cells[0], cells[1], cells[2] = TERMINATE, k, status
                    return point - 1
            elif deed == 1:
                status = _exchange(reads, ranges[0, k], ranges[0, k + 1])
                if status > 1:
                    cells[0], cells[1], cells[2] = GET, k, status
                    return point - 1
                bad = _first_not_finite(checks, doubles, ranges[3, k], ranges[3, k + 1])
                if bad >= 0:
                    cells[0], cells[1], cells[2] = NOT_FINITE, k, bad
                    return point - 1
            else:
                _gather(wires, factors, doubles, ints, octets, ranges[2, k], ranges[2, k + 1])
                status = _exchange(writes, ranges[1, k], ranges[1, k + 1])
                if status > 1:
                    cells[0], cells[1], cells[2] = SET, k, status
                    return point - 1
        if _exchange(reads, late, len(reads)) > 1:
            cells[0], cells[1], cells[2] = GET, -1, 3
            return point - 1
        for c in range(len(columns)):
            rows[row, c] = _value(doubles, ints, octets, columns[c, 0], columns[c, 1])
        row += 1
        cells[4] = point + 1
    return last
