"""A law by itself, fed with what it is told of a run: signals may lie, and the controller may restart.

No law acts on what it corrects, so the truth of a run is computed once and any number of laws and faults are
tried on it. Only the camera sees the correction; it is simulated here, a picture at a time.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.rollout import Array, Cell, shared_library
from warmlink.controllers.interface import SENSED
from warmlink.controllers.none.component import COMPONENT as NONE
from warmlink.fmus.component import Component, limits

DUTY = ("speed", "torque", "ambient_temperature")
CAMERA = ("camera_scale", "camera_offset", "picture", "drift_valid")
TOLD = (*SENSED, *DUTY, *CAMERA, "elongation")
"""What a row holds: what the law is told, how the camera sees at that time, and the truth that it sees."""

STEP = 1.0
"""s between two samples of a law."""


_LOOP = """
#include <string.h>
void all_rows(long count, const double *rows, double *states, const double *design, double *found)
{
    const double *argument[ARGUMENTS];
    double *result[RESULTS], real[REAL], following[STATES];
    casadi_int whole[WHOLE];
    for (long k = 0; k < count; k++) {
        argument[0] = states, argument[1] = rows + k * ROW, argument[2] = design;
        result[0] = following, result[1] = found + k * OUTPUTS;
        sample(argument, result, whole, real, 0);
        memcpy(states, following, sizeof following);
    }
}
"""
"""What goes through all samples, in C beside what a sample does."""


@dataclass(frozen=True)
class Restart:
    """The controller goes off at a time in s, for so long in s.

    Attributes
    ----------
    retained : whether the host gives it back what it retained; "damaged" with one number changed
    """

    time: float
    off: float = 1.0
    retained: bool | str = True


@dataclass(frozen=True)
class Told:
    """What a law is told of a run, and the restarts in it.

    Attributes
    ----------
    rows : one row of `TOLD` a sample, shape (n, 13)
    """

    rows: Array
    restarts: Sequence[Restart] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        """One signal over time, shape (n,)."""
        return self.rows[:, TOLD.index(name)]

    def changed(self, name: str, values: Array | float, where: slice | Array = slice(None)) -> Told:
        """The same with one signal changed at some samples."""
        rows = self.rows.copy()
        rows[where, TOLD.index(name)] = values
        return replace(self, rows=rows)


@dataclass(frozen=True)
class Outcome:
    """What a law made of what it was told; each of shape (n,), NaN while the controller was off.

    Attributes
    ----------
    error : elongation minus correction in m
    """

    elongation: Array
    correction: Array
    ready: Array
    distrusted: Array
    predicted: Array
    std: Array

    @property
    def error(self) -> Array:
        """Elongation minus correction in m."""
        return self.elongation - self.correction

    @property
    def worse_by(self) -> float:
        """Largest excess in m of the error over the elongation at the same time; infinite for NaN."""
        excess = (np.abs(self.error) - np.abs(self.elongation))[np.isfinite(self.ready)]
        return float(excess.max()) if np.isfinite(excess).all() else float("inf")

    def ready_wrong(self, tolerance: float = 5e-6) -> float:
        """Share of the time in which the law says ready and the error is beyond the tolerance."""
        return float(np.mean((self.ready > 0) & ~(np.abs(self.error) <= tolerance)))


def truth(
    cell: Cell, demands: Array, plant: Mapping[str, Mapping[str, float]], noise: float, seed: int
) -> Told:
    """What a law is told of a run by sound instruments, with their noise in K.

    Parameters
    ----------
    cell : a cell without a controller (`bare_cell`)
    demands, plant : as for `Cell.run`
    """
    record = cell.run(demands, plant)
    draw = np.random.default_rng(seed)
    count = len(demands)
    pictures = np.zeros(count)
    since = np.inf
    for k, speed in enumerate(demands[:, 0]):
        since += STEP
        if since >= (30.0 if abs(speed) > 0.01 else 120.0):
            pictures[k], since = 1.0, 0.0
    columns = [record[name] + noise * draw.normal(size=count) for name in SENSED]
    columns += list(demands[:, :3].T)
    columns += [np.ones(count), 1.1e-7 * draw.normal(size=count), pictures, np.ones(count)]
    return Told(np.column_stack([*columns, record["elongation"]]))


@cache
def bare_cell() -> Cell:
    """The cell without a controller, compiled once."""
    return Cell(NONE)


class Rig:
    """A law compiled by itself, with a camera that sees what it leaves; it needs a C compiler."""

    def __init__(self, law: Component) -> None:
        import casadi as ca

        self.law = law
        sample, begin = _functions(law)
        sizes = {
            "ARGUMENTS": sample.sz_arg(),
            "RESULTS": sample.sz_res(),
            "WHOLE": sample.sz_iw() + 1,
            "REAL": sample.sz_w() + 1,
            "STATES": law.x.size + 1,
            "ROW": len(TOLD),
            "OUTPUTS": law.y.size,
        }
        defined = "".join(f"#define {name} {size}\n" for name, size in sizes.items())
        library = str(shared_library([sample, begin], defined + _LOOP))
        self._all_rows, self._begin = ctypes.CDLL(library).all_rows, ca.external("begin", library)

    def run(self, told: Told) -> Outcome:
        """Run the law over all samples."""
        rows = np.ascontiguousarray(told.rows)
        count = len(rows)
        found = np.full((count, self.law.y.size), np.nan)
        events = [*sorted(told.restarts, key=lambda event: event.time), Restart(count * STEP)]
        first, given = 0, dict(told.parameters)
        for event in events:
            last = min(count, round(event.time / STEP))
            self._stretch(rows, found, first, last, given)
            found[last : last + round(event.off / STEP)] = np.nan
            first = last + round(event.off / STEP)
            given = {**told.parameters, **self._kept(found[last - 1], event)}
        out = {name: found[:, self.law.y.index[name]] for name in OUTPUTS.values()}
        return Outcome(told["elongation"], **{key: out[name] for key, name in OUTPUTS.items()})

    def _kept(self, row: Array, event: Restart) -> dict[str, float]:
        """What the host gives back to the law at its restart."""
        if not event.retained or "recalled[1]" not in self.law.p.index:
            return {}
        names = [name for name in self.law.y.names if name.startswith("retained[")]
        kept = {f"recalled{name[8:]}": float(row[self.law.y.index[name]]) for name in names}
        if event.retained == "damaged":
            kept["recalled[2]"] += 1e-3 + abs(kept["recalled[2]"])
        return {**kept, "recalled_for": event.off}

    def _stretch(self, rows: Array, found: Array, first: int, last: int, given: Mapping[str, float]) -> None:
        if first >= last:
            return
        p = np.asarray(self.law.settled(limits.checked(self.law, "compensator", given)[0]), dtype=float)
        x, y = (np.array(part, dtype=float).ravel() for part in self._begin(rows[first], p))
        found[first] = y
        arrays = rows[first + 1 :], x, p, found[first + 1 :]
        self._all_rows(ctypes.c_long(last - first - 1), *(each.ctypes for each in arrays))


OUTPUTS = {
    "correction": "correction",
    "ready": "ready",
    "distrusted": "distrusted",
    "predicted": "predicted_elongation",
    "std": "correction_std",
}


def _functions(law: Component) -> list[Any]:
    import casadi as ca

    x, p = ca.SX.sym("x", law.x.size + 1), ca.SX.sym("p", law.d.size)
    row = ca.SX.sym("row", len(TOLD))
    told = dict(zip(TOLD, ca.vertsplit(row), strict=True))
    state, film = x[: law.x.size], x[law.x.size]

    def inputs(seen: Any) -> Any:
        return law.u.flat({**{v.name: told.get(v.name, v.start) for v in law.inputs}, "measured_drift": seen})

    def shown(state: Any, film: Any) -> tuple[Any, Any]:
        y = law.outputs_of(state, inputs(film), p, 0.0)
        look = told["camera_scale"] * (told["elongation"] - y[law.y.index["correction"]])
        return y, ca.if_else(told["picture"] > 0, look + told["camera_offset"], film)

    new = law.updated(state, inputs(film), p, 0.0, STEP)
    y, film = shown(new, film)
    sample = ca.Function("sample", [x, row, p], ca.cse([ca.vertcat(new, film), ca.densify(y)]))
    start = law.states_at_start(inputs(0.0), p)
    y, film = shown(start, 0.0)
    begin = ca.Function("begin", [row, p], [ca.vertcat(start, film), ca.densify(y)])
    return [sample, begin]
