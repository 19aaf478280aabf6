"""The closed cell in one process, fast: every component's own equations joined into one compiled step.

For tests and tuning. One CasADi function takes the joined cell one step further, in C where the machine has a
compiler and in CasADi's interpreter where it has none.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Component, limits
from warmlink.fmus.duty_cycle.equations import DEMANDS, EARLY
from warmlink.fmus.packaging.native.casadi_code import Symbols
from warmlink.fmus.packaging.native.micro_step import stepping
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Duty
from warmlink.orchestration.system.shipped import WARMUP_CELL

Array = NDArray[np.float64]

_TRUE = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
)
_SAID = ("correction", "predicted_elongation", "correction_std", "ready", "distrusted", "warning")
RECORDED = {
    "elongation": "link.elongation",
    **{name: f"compensator.{name}" for name in _SAID},
    **dict(zip(SENSED, _TRUE, strict=True)),
    **{f"sensed_{name}": f"sensors.reading[{i}]" for i, name in enumerate(SENSED, 1)},
}
"""What a run records, in this order, by the cell's outputs; `sensed_` temperatures are those read."""


def library() -> list[Duty]:
    """Every duty cycle that warmlink ships."""
    return [duty_files.load(name) for name in duty_files.names()]


def demand_table(duty: Duty, step: float, stop_time: float | None = None) -> Array:
    """Demands at the communication points, as the DutyCycle component gives them.

    Parameters
    ----------
    duty : the duty cycle
    step : communication step size in s
    stop_time : in s, that of the duty cycle by default

    Returns
    -------
    numpy.ndarray
        One row of `DEMANDS` for each communication point, the start included, shape (n + 1, 6).
    """
    count = round((duty.stop_time if stop_time is None else stop_time) / step)
    time = step * np.arange(count + 1) + EARLY
    ends = np.cumsum([segment.duration for segment in duty.segments])
    if duty.repeat:
        time = time % ends[-1]
    which = np.minimum(np.searchsorted(ends, time, side="right"), len(duty.segments) - 1)
    return np.array([segment.demands for segment in duty.segments])[which]


@dataclass(frozen=True)
class Record:
    """What a run recorded, one row a communication point, the start included.

    Attributes
    ----------
    time : in s, shape (n,)
    values : shape (n, len(RECORDED)), in SI units
    """

    time: Array
    values: Array

    def __getitem__(self, name: str) -> Array:
        """One recorded quantity, shape (n,)."""
        return self.values[:, list(RECORDED).index(name)]

    @property
    def error(self) -> Array:
        """True elongation minus correction in m, shape (n,)."""
        return self["elongation"] - self["correction"]


class Cell:
    """Motor, link, sensors, camera and a law joined, and stepped at 1 s.

    Parameters
    ----------
    law : the law's component
    law_states : record the law's states too, for a look inside
    """

    step = 1.0

    def __init__(self, law: Component, law_states: bool = False) -> None:
        self.law = law
        self.joined = WARMUP_CELL.without("duty").joined(law)
        places = [i for name, i in self.joined.x.index.items() if name.startswith("compensator.")]
        # Side by side, as all states of a part are.
        self._beside = slice(places[0], places[-1] + 1) if law_states and places else slice(0, 0)
        self._advance, self._begin = compiled(self._functions())

    def run(self, demands: Array, parameters: Mapping[str, Mapping[str, float]] | None = None) -> Record:
        """Run through a duty cycle.

        Parameters
        ----------
        demands : one row of `DEMANDS` a step and one for the start, shape (n + 1, 6), in SI units
        parameters : values by instance (motor, link, sensors, compensator, camera) and parameter

        Raises
        ------
        InputError
            A parameter is unknown or out of range.
        """
        given = {f"{part}.{name}": v for part, of in (parameters or {}).items() for name, v in of.items()}
        p = np.asarray(self.joined.settled(limits.checked(self.joined, "cell", given)[0]), dtype=float)
        count = demands.shape[0] - 1
        rows = np.ascontiguousarray(demands, dtype=float)
        x, record = (np.array(part, dtype=float).ravel() for part in self._begin(rows[0], p))
        values = np.empty((count + 1, record.size + x[self._beside].size))
        values[0] = np.concatenate([record, x[self._beside]])
        buffer, trigger = self._advance.buffer()
        following, now, time = np.empty_like(x), rows[0].copy(), np.zeros(1)
        for place, array in enumerate((x, now, p, time)):
            buffer.set_arg(place, array.data)
        buffer.set_res(0, following.data)
        buffer.set_res(1, record.data)
        for i in range(1, count + 1):
            now[:] = rows[i]
            time[0] = i * self.step
            trigger()
            x[:] = following
            values[i, : record.size] = record
            values[i, record.size :] = x[self._beside]
        return Record(self.step * np.arange(count + 1), values)

    def _functions(self) -> list[Any]:
        import casadi as ca

        cell = self.joined
        s, demands = Symbols.of(cell), ca.SX.sym("demands", len(DEMANDS))
        given = dict(zip(DEMANDS, ca.vertsplit(demands), strict=True))
        variables = [name.partition(".")[2] for name in cell.u.names]
        u = ca.vertcat(*(given.get(name, 0.0) for name in variables))
        _, arguments, after = next(stepping(cell, s))
        whole = ca.Function("whole", arguments, [after])
        size = cell.continuous.size
        x = ca.vertcat(whole(s.x, u, s.d, s.time - self.step, self.step), s.x[size:])
        # The law before the camera, which the shipped system steps the other way round: its picture is a
        # step older here.
        for instance in ("sensors", "compensator", "camera"):
            for clock in (each for each in cell.clocks if each.sample_time.startswith(f"{instance}.")):
                sampled = cell.updated(x, u, s.d, s.time, self.step, clock)
                place = cell.x.index[clock.layout.names[0]]
                x = ca.vertcat(x[:place], sampled, x[place + clock.layout.size :])
        results = ca.cse([ca.densify(x), ca.densify(self._recorded(x, u, s.d, s.time))])
        begun = ca.SX(cell.states_at_start(u, s.d))
        return [
            ca.Function("advance", [s.x, demands, s.d, s.time], results),
            ca.Function("begin", [demands, s.d], [begun, self._recorded(begun, u, s.d, 0.0)]),
        ]

    def _recorded(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        import casadi as ca

        y, index = ca.SX(self.joined.outputs_of(x, u, p, time)), self.joined.y.index
        return ca.vertcat(*(y[index[name]] for name in RECORDED.values()))


def compiled(functions: list[Any]) -> list[Any]:
    """The same functions in C where there is a compiler, kept for the next time."""
    import casadi as ca

    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return functions
    generator = ca.CodeGenerator("cell.c")
    for function in functions:
        generator.add(function)
    source = generator.dump()
    name = hashlib.sha256(source.encode()).hexdigest()[:16]
    folder = Path(tempfile.gettempdir()) / "warmlink-cells"
    library = folder / f"{name}.so"
    if not library.exists():
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as work:
            (Path(work) / "cell.c").write_text(source, encoding="utf-8")
            command = [compiler, "-O1", "-shared", "-fPIC", "-o", f"{work}/cell.so", f"{work}/cell.c", "-lm"]
            subprocess.run(command, check=True, capture_output=True)
            Path(work, "cell.so").replace(library)
    return [ca.external(function.name(), str(library)) for function in functions]


def by_rows(function: Any, *given: Array) -> list[Array]:
    """A function's results, shapes (n, size), of arguments given row by row, shapes (n, size).

    Several times as fast as a CasADi map, which takes NumPy's arrays element by element.
    """
    buffer, trigger = function.buffer()
    count = given[0].shape[0]
    rows = [np.zeros(each.shape[1]) for each in given]
    found = [np.zeros(function.size1_out(i)) for i in range(function.n_out())]
    for i, row in enumerate(rows):
        buffer.set_arg(i, row.data)
    for i, result in enumerate(found):
        buffer.set_res(i, result.data)
    results = [np.empty((count, each.size)) for each in found]
    for k in range(count):
        for row, each in zip(rows, given, strict=True):
            row[:] = each[k]
        trigger()
        for result, each in zip(results, found, strict=True):
            result[k] = each
    return results
