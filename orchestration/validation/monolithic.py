"""Coupled components as one system of differential equations, without a co-simulation's coupling error.

The reference that masters, FMUs and reduced models are held against: states stacked, connections put into
the equations, integrated by scipy's BDF to a tight tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arithmetic import Number
from warmlink.fmus.packaging.component import Component
from warmlink.fmus.packaging.integrator import ComplexStepJacobian

Wire = tuple[str, str]
"""Source and target of a connection, as `("motor.heat_flow", "link.heat_flow")`."""


@dataclass(frozen=True)
class Phase:
    """A stretch of time over which the inputs are held.

    Attributes
    ----------
    duration : length in s
    inputs : values in SI units by full name, as `motor.speed`; the others keep what they had
    """

    duration: float
    inputs: Mapping[str, float]


@dataclass(frozen=True)
class Trajectory:
    """What was found: times in s, shape (n,), and values by full name, each of shape (n,)."""

    time: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]


class Monolithic:
    """Components that are differential equations, coupled without delay.

    Parameters
    ----------
    components : declarations by instance name
    wires : connections between scalar variables; they must close no loop of direct feedthrough
    parameters : values in SI units by full name, as `link.emissivity`, where not the declared ones
    """

    def __init__(
        self,
        components: Mapping[str, Component],
        wires: Sequence[Wire] = (),
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        self._components = dict(components)
        self._settled: dict[str, NDArray[np.float64]] = {}
        self._inputs: dict[str, NDArray[np.float64]] = {}
        for name, component in self._components.items():
            given = {k.partition(".")[2]: v for k, v in (parameters or {}).items() if _instance(k) == name}
            starts = [
                given.pop(scalar.name, scalar.start)
                for scalar in component.scalars()
                if scalar.start is not None
            ]
            if given:
                raise KeyError(f"{name} has no {', '.join(given)}")
            p = np.array(starts[: component.p.size], dtype=float)
            self._settled[name] = np.asarray(component.settled(p), dtype=float)
            self._inputs[name] = np.array(starts[component.p.size :], dtype=float)
        self._wires = [(*self._place(source, "y"), *self._place(target, "u")) for source, target in wires]

    def run(
        self, phases: Sequence[Phase], record: Sequence[str], *, every: float = 10.0, tolerance: float = 1e-9
    ) -> Trajectory:
        """Integrate through the phases from the declared start.

        Parameters
        ----------
        phases : what the inputs are, one after another; at a change, values belong to the new phase
        record : outputs by full name
        every : time in s between two recorded points; it must divide each phase
        tolerance : relative tolerance, and absolute in K and J

        Raises
        ------
        RuntimeError
            The integration failed.
        """
        from scipy.integrate import solve_ivp

        times: list[NDArray[np.float64]] = []
        rows: dict[str, list[float]] = {name: [] for name in record}
        z, begun = None, 0.0
        inputs = self._inputs
        for number, phase in enumerate(phases, start=1):
            inputs = self._with(inputs, phase.inputs)
            if z is None:
                z = self._start(inputs)
            grid: NDArray[np.float64] = begun + every * np.arange(round(phase.duration / every) + 1.0)
            found = solve_ivp(
                partial(self._rates, inputs=inputs),
                (begun, grid[-1]),
                z,
                "BDF",
                t_eval=grid,
                rtol=tolerance,
                atol=tolerance,
                jac=_SparseJacobian(partial(self._rates, inputs=inputs), begun, z),
            )
            if not found.success:
                raise RuntimeError(f"no integration beyond {found.t[-1]:g} s: {found.message}")
            kept = grid if number == len(phases) else grid[:-1]
            times.append(kept)
            for time, state in zip(kept, found.y.T, strict=False):
                values = self._outputs(state, inputs, time)
                for name, row in rows.items():
                    instance, index = self._place(name, "y")
                    row.append(float(values[instance][index]))
            z, begun = found.y[:, -1], float(grid[-1])
        return Trajectory(np.concatenate(times), {name: np.array(row) for name, row in rows.items()})

    def _place(self, name: str, kind: str) -> tuple[str, int]:
        instance, _, variable = name.partition(".")
        return instance, getattr(self._components[instance], kind).index[variable]

    def _with(
        self, old: Mapping[str, NDArray[np.float64]], values: Mapping[str, float]
    ) -> dict[str, NDArray[np.float64]]:
        new = {name: inputs.copy() for name, inputs in old.items()}
        for name, value in values.items():
            instance, index = self._place(name, "u")
            new[instance][index] = value
        return new

    def _start(self, inputs: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        parts = [c.states_at_start(inputs[n], self._settled[n]) for n, c in self._components.items()]
        return np.concatenate(parts)

    def _parts(self, z: Number) -> dict[str, Number]:
        parts, start = {}, 0
        for name, component in self._components.items():
            parts[name] = z[start : start + component.x.size]
            start += component.x.size
        return parts

    def _connected(
        self, z: Number, inputs: Mapping[str, Number], time: float
    ) -> tuple[dict[str, Number], dict[str, Number]]:
        """Inputs with the connections put in, and outputs; a pass for each component settles them."""
        x = self._parts(z)
        u = {name: values.astype(np.result_type(z, float)) for name, values in inputs.items()}
        y: dict[str, Number] = {}
        for _ in range(len(self._components) if self._wires else 1):
            y = {n: c.outputs_of(x[n], u[n], self._settled[n], time) for n, c in self._components.items()}
            for source, output, target, entry in self._wires:
                u[target][entry] = y[source][output]
        return u, y

    def _outputs(self, z: Number, inputs: Mapping[str, Number], time: float) -> dict[str, Number]:
        u, _ = self._connected(z, inputs, time)
        x = self._parts(z)
        return {n: c.outputs_of(x[n], u[n], self._settled[n], time) for n, c in self._components.items()}

    def _rates(self, time: float, z: Number, inputs: Mapping[str, Number]) -> Number:
        u, _ = self._connected(z, inputs, time)
        x = self._parts(z)
        return np.concatenate(
            [c.rates_of(x[n], u[n], self._settled[n], time) for n, c in self._components.items()]
        )


class _SparseJacobian:
    """Jacobian by complex step, with the structure that it has at a point."""

    def __init__(
        self, rates: Callable[[float, Number], Number], time: float, state: NDArray[np.float64]
    ) -> None:
        size = len(state)
        every = ComplexStepJacobian(np.ones((size, size), dtype=bool))
        structure = every(partial(rates, time), state) != 0
        self._jacobian = ComplexStepJacobian(structure | np.eye(size, dtype=bool))
        self._rates = rates

    def __call__(self, time: float, state: NDArray[np.float64]) -> Any:
        from scipy.sparse import csc_matrix

        return csc_matrix(self._jacobian(partial(self._rates, time), state))


def _instance(name: str) -> str:
    return name.partition(".")[0]


def warm_up_cell(
    motor: Component, link: Component, parameters: Mapping[str, float] | None = None
) -> Monolithic:
    """Motor and link as the warm-up cell couples them."""
    wires = (("motor.heat_flow", "link.heat_flow"), ("link.base_temperature", "motor.link_base_temperature"))
    return Monolithic({"motor": motor, "link": link}, wires, parameters)


def demand(duration: float, speed: float, torque: float, ambient_temperature: float = 295.15) -> Phase:
    """Phase of the warm-up cell: duration in s, speed in rad/s, torque in N.m, temperature in K."""
    return Phase(
        duration,
        {
            "motor.speed": speed,
            "link.speed": speed,
            "motor.torque": torque,
            "motor.ambient_temperature": ambient_temperature,
            "link.ambient_temperature": ambient_temperature,
        },
    )
