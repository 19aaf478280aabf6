"""The closed cell in one process, fast: the joined runs of a study, driven by demands over time."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Component, limits
from warmlink.fmus.component.table import EARLY
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.fmus.packaging.native.rollout import Rollout
from warmlink.fmus.packaging.native.rollout_code import compiled as rollout
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Duty

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
    loaded = map(duty_files.load, duty_files.names())
    return [duty for duty in loaded if isinstance(duty, Duty)]


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
    return np.array([[getattr(segment, name) for name in DEMANDS] for segment in duty.segments])[which]


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


@cache
def _runs(law: Component, law_states: bool) -> tuple[Component, Rollout]:
    """The cell joined, and its runs compiled: made once in a process, for this takes seconds."""
    joined = WARMUP_CELL.joined(law)
    states = [name for name in joined.x.names if name.startswith("compensator.")]
    return joined, rollout(joined, [*RECORDED.values(), *(states if law_states else ())], False)


class Cell:
    """Motor, link, sensors, camera and a law joined, and stepped at 1 s; it needs a C compiler.

    Parameters
    ----------
    law : the law's component
    law_states : record the law's states too, for a look inside
    """

    step = 1.0

    def __init__(self, law: Component, law_states: bool = False) -> None:
        self.law = law
        self.joined, self._rollout = _runs(law, law_states)

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
        given = parameters or {}
        flat = {f"{part}.{name}": value for part, of in given.items() for name, value in of.items()}
        limits.checked(self.joined, "cell", flat)
        drive = demands[:, [DEMANDS.index(name.removeprefix("duty.")) for name in self._rollout.given]]
        found, _ = self._rollout.run([given], len(demands) - 1, self.step, drive)
        return Record(
            self.step * np.arange(len(demands), dtype=float), np.array(found[0].T, float, order="C")
        )


def compiled(functions: list[Any]) -> list[Any]:
    """The same functions in C where there is a compiler, kept for the next time."""
    import casadi as ca

    if _compiler() is None:
        return functions
    library = shared_library(functions)
    return [ca.external(function.name(), str(library)) for function in functions]


def _compiler() -> str | None:
    return shutil.which("cc") or shutil.which("gcc")


def shared_library(functions: list[Any], beside: str = "") -> Path:
    """Library of functions, and of what is written in C beside them; it needs a C compiler."""
    import casadi as ca

    generator = ca.CodeGenerator("cell.c")
    for function in functions:
        generator.add(function)
    source = generator.dump() + beside
    name = hashlib.sha256(source.encode()).hexdigest()[:16]
    folder = Path(tempfile.gettempdir()) / "warmlink-cells"
    library = folder / f"{name}.so"
    if not library.exists():
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as work:
            (Path(work) / "cell.c").write_text(source, encoding="utf-8")
            flags = "-O1", "-shared", "-fPIC", "-o", f"{work}/cell.so", f"{work}/cell.c", "-lm"
            command = [_compiler() or "cc", *flags]
            subprocess.run(command, check=True, capture_output=True)
            Path(work, "cell.so").replace(library)
    return library


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
