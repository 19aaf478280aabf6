"""The closed cell in one process, fast: every component's own equations joined into one compiled step.

For tests and tuning. It is what a Gauss-Seidel master does with the FMUs (motor, link, sensors, law, camera,
in this order), without FMUs: one CasADi function takes the whole cell one step further, in C where the
machine has a compiler and in CasADi's interpreter where it has none.
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

from warmlink.controllers.design.plant import parameter_vector
from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Component
from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.native.codegen import Symbols, micro_step
from warmlink.fmus.temperature_sensors.component import CHANNELS
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

Array = NDArray[np.float64]

DEMANDS = ("speed", "torque", "ambient_temperature", "pad_mode", "pad_temperature", "pad_power")
"""What the duty cycle gives at each step, in this order."""

RECORDED = (
    "elongation",
    "correction",
    "predicted_elongation",
    "correction_std",
    "ready",
    "distrusted",
    "warning",
    *SENSED,
    *(f"sensed_{name}" for name in SENSED),
)
"""What a run records, in this order; temperatures are true ones, `sensed_` those read."""


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
        return self.values[:, RECORDED.index(name)]

    @property
    def error(self) -> Array:
        """True elongation minus correction in m, shape (n,)."""
        return self["elongation"] - self["correction"]


class Cell:
    """Motor, link, sensors, camera and a law, stepped together at 1 s.

    Parameters
    ----------
    law : the law's component
    law_states : record the law's states too, for a look inside
    """

    step = 1.0

    def __init__(self, law: Component, law_states: bool = False) -> None:
        self.law = law
        self._parts = {
            "motor": MOTOR,
            "link": LINK,
            "sensors": SENSORS,
            "compensator": law,
            "camera": CAMERA,
        }
        self._law_states = law_states
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
        given = parameters or {}
        settled = [
            np.asarray(part.settled(parameter_vector(part, given.get(name, {}), name)), dtype=float)
            for name, part in self._parts.items()
        ]
        p = np.concatenate(settled)
        count = demands.shape[0] - 1
        rows = np.ascontiguousarray(demands, dtype=float)
        x, record = (np.array(part, dtype=float).ravel() for part in self._begin(rows[0], p))
        values = np.empty((count + 1, record.size))
        values[0] = record
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
            values[i] = record
        return Record(self.step * np.arange(count + 1), values)

    def _functions(self) -> list[Any]:
        import casadi as ca

        x = {name: ca.SX.sym(f"x_{name}", part.x.size) for name, part in self._parts.items()}
        p = {name: ca.SX.sym(f"p_{name}", part.d.size) for name, part in self._parts.items()}
        u, time = ca.SX.sym("u", len(DEMANDS)), ca.SX.sym("time")
        wired = _Wiring(self._parts, dict(zip(DEMANDS, ca.vertsplit(u), strict=True)), p)

        new = dict(x)
        for name in ("motor", "link"):
            new[name] = _integrated(self._parts[name], x[name], wired.inputs(name, new), p[name], self.step)
        for name in ("sensors", "compensator", "camera"):
            if not self._parts[name].sampled:  # a law without a memory
                continue
            new[name] = self._parts[name].updated(x[name], wired.inputs(name, new), p[name], time, self.step)
        flat, flat_p = ca.vertcat(*x.values()), ca.vertcat(*p.values())
        results = ca.cse([ca.densify(ca.vertcat(*new.values())), ca.densify(self._recorded(wired, new))])
        advance = ca.Function("advance", [flat, u, flat_p, time], results)
        first: dict[str, Any] = {}
        for name in ("motor", "link", "sensors"):
            first[name] = self._parts[name].states_at_start(wired.inputs(name, first), p[name])
        # The camera's first picture needs the law's first correction, and the law the camera's first reading.
        first["camera"] = ca.SX.zeros(CAMERA.x.size)
        first["compensator"] = self.law.states_at_start(wired.inputs("compensator", first), p["compensator"])
        first["camera"] = CAMERA.states_at_start(wired.inputs("camera", first), p["camera"])
        ordered = ca.vertcat(*(first[name] for name in self._parts))
        begin = ca.Function("begin", [u, flat_p], [ordered, self._recorded(wired, first)])
        return [advance, begin]

    def _recorded(self, wired: _Wiring, x: Mapping[str, Any]) -> Any:
        import casadi as ca

        motor, link = wired.outputs("motor", x), wired.outputs("link", x)
        law, readings = wired.outputs("compensator", x), wired.outputs("sensors", x).reading
        values = [link.elongation, *(getattr(law, name) for name in RECORDED[1:7])]
        values += [motor.shaft_temperature, motor.winding_temperature, link.base_temperature]
        values += [link.sensor_temperature[1], link.tip_temperature, *ca.vertsplit(readings)[: len(SENSED)]]
        return ca.vertcat(*values, x["compensator"]) if self._law_states else ca.vertcat(*values)


class _Wiring:
    """Who is connected to whom in the cell."""

    def __init__(
        self, parts: Mapping[str, Component], demands: Mapping[str, Any], p: Mapping[str, Any]
    ) -> None:
        self._parts, self._demands, self._p = parts, demands, p

    def outputs(self, name: str, x: Mapping[str, Any]) -> Any:
        """Outputs of a component as a record."""
        part = self._parts[name]
        return part.y.read(part.outputs_of(x[name], self.inputs(name, x), self._p[name], 0.0))

    def inputs(self, name: str, x: Mapping[str, Any]) -> Any:
        """Flat inputs of a component for the states that the others have."""
        import casadi as ca

        part = self._parts[name]
        values: dict[str, Any] = {v.name: v.start for v in part.inputs}
        values.update({key: value for key, value in self._demands.items() if key in values})
        if name == "motor":
            state = x.get("link")
            if state is not None:
                values["link_base_temperature"] = self.outputs_of_link(state).base_temperature
            else:
                values["link_base_temperature"] = self._p["link"][LINK.d.index["initial_temperature"]]
        elif name == "link" and "link" in x:
            values["heat_flow"] = self.outputs("motor", x).heat_flow
        elif name == "sensors":
            motor, link = self.outputs("motor", x), self.outputs_of_link(x["link"])
            true = [
                motor.shaft_temperature,
                motor.winding_temperature,
                *ca.vertsplit(link.sensor_temperature),
            ]
            values["temperature"] = ca.vertcat(*true[:CHANNELS])
        elif name == "compensator":
            readings = ca.vertsplit(SENSORS.x.read(x["sensors"]).reading)
            values.update(zip(SENSED, readings, strict=False))
            camera = CAMERA.x.read(x["camera"])
            values["measured_drift"], values["drift_valid"] = camera.measured_drift, camera.drift_valid
        elif name == "camera":
            values["elongation"] = self.outputs_of_link(x["link"]).elongation
            values["correction"] = self.outputs("compensator", x).correction
        return part.u.flat(values) if part.inputs else ca.SX(0, 1)

    def outputs_of_link(self, state: Any) -> Any:
        """Outputs of the link that its state alone settles."""
        values = LINK.outputs_of(state, self._idle_link(), self._p["link"], 0.0)
        return LINK.y.read(values)

    @staticmethod
    def _idle_link() -> Any:
        import casadi as ca

        return ca.SX([v.start for v in LINK.inputs])


def _integrated(part: Component, x: Any, u: Any, p: Any, step: float) -> Any:
    """State after one micro step as the native FMU makes it, with inputs held: its Jacobian is its own."""
    import casadi as ca

    s = Symbols.of(part)
    alone = ca.Function("micro_step", [s.x, s.u, s.d, s.time, s.step], [micro_step(part, s, s.u)])
    return alone(x, u, p, 0.0, step)


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
