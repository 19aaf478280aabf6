"""A rig's equations in one piece: rates, outputs, derivatives, from the components' own declarations.

Components are joined symbolically, so that the diagnosis integrates the very equations that lie in the
FMUs, without the communication steps between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.rigs import Rig, rig

Vector = NDArray[np.float64]


class Equations:
    """Compiled functions of a rig for a choice of freed variables and outputs.

    Parameters
    ----------
    rig : the system
    slots : freed parameters or inputs, by full name; derivatives are with respect to these
    outputs : outputs wanted, by full name

    Attributes
    ----------
    states : names of the states that the outputs depend on; the others are left out
    """

    def __init__(self, rig: Rig, slots: Sequence[str], outputs: Sequence[str]) -> None:
        import casadi as ca

        self.rig, self.slots, self.outputs = rig, tuple(slots), tuple(outputs)
        self._ca = ca
        joined = _Joined(rig, self.slots)
        rates, observed = joined.rates, ca.vertcat(*(joined.values[name] for name in outputs))
        needed = _needed_states(ca, joined.x, rates, observed)
        self.states = tuple(joined.states[i] for i in needed)
        x = joined.x[needed]
        rates, begun = rates[needed], joined.begun[needed]
        arguments = [x, joined.z, joined.p, joined.w, joined.time]
        self._linear = ca.Function(
            "linear",
            arguments,
            [ca.densify(v) for v in (rates, ca.jacobian(rates, x).T, ca.jacobian(rates, joined.z).T)],
            {"cse": True},
        )
        self._observe = ca.Function(
            "observe",
            arguments,
            [ca.densify(v) for v in (observed, ca.jacobian(observed, x), ca.jacobian(observed, joined.z))],
            {"cse": True},
        )
        self._begin = ca.Function(
            "begin",
            [joined.z, joined.p, joined.w],
            [ca.densify(v) for v in (begun, ca.jacobian(begun, joined.z))],
            {"cse": True},
        )

    @cached_property
    def parameter_values(self) -> Vector:
        """Start values of all parameters, shape (parameters,)."""
        return np.array([self.rig.variables[name].start for name in self.rig.parameters], dtype=float)

    @cached_property
    def external_values(self) -> Vector:
        """Start values of the inputs that nothing feeds, shape (externals,)."""
        return np.array([self.rig.variables[name].start for name in self.rig.externals], dtype=float)

    def begin(self, z: Vector, p: Vector, w: Vector) -> tuple[Vector, Vector]:
        """States at the start, shape (n,), and their derivatives by the slots, shape (n, slots)."""
        x, by_slot = self._begin(z, p, w)
        return np.array(x).ravel(), np.array(by_slot).reshape(x.shape[0], len(self.slots))

    def stepper(self) -> Linearised:
        """Rates with their derivatives, fast, for one thread."""
        return Linearised(self._linear, len(self.states), len(self.slots))

    def observe(
        self, x: Vector, z: Vector, p: Vector, w: Vector, time: Vector
    ) -> tuple[Vector, Vector, Vector]:
        """Outputs at many points.

        Parameters
        ----------
        x : states, shape (n, points)
        z, p : slots and parameters
        w : inputs, shape (externals, points)
        time : s, shape (points,)

        Returns
        -------
        tuple of numpy.ndarray
            Outputs, shape (points, outputs); derivatives by state, shape (points, outputs, n), and by
            slot, shape (points, outputs, slots).
        """
        points, m = time.size, len(self.outputs)
        mapped = self._observe.map(points)
        ones = np.ones(points)
        y, by_state, by_slot = mapped(x, np.outer(z, ones), np.outer(p, ones), w, time[None, :])
        n, k = len(self.states), len(self.slots)
        return (
            np.array(y).T.reshape(points, m),
            np.array(by_state).reshape(m, points, n).transpose(1, 0, 2),
            np.array(by_slot).reshape(m, points, k).transpose(1, 0, 2),
        )


@lru_cache(maxsize=24)
def equations(name: str, cells: int, slots: tuple[str, ...], outputs: tuple[str, ...]) -> Equations:
    """Compiled functions of a shipped rig, kept for the next problem of the same kind."""
    return Equations(rig(name, cells), slots, outputs)


class Linearised:
    """The rates at a point with their derivatives, in arrays that are reused from call to call.

    Attributes
    ----------
    rates : shape (n,)
    by_state : shape (n, n)
    by_slot : shape (n, slots)
    """

    def __init__(self, function: Any, states: int, slots: int) -> None:
        self.x, self.w, self.time = np.zeros(states), np.zeros(function.size1_in(3)), np.zeros(1)
        self.z, self.p = np.zeros(slots), np.zeros(function.size1_in(2))
        self.rates = np.zeros(states)
        # CasADi stores by column and gives the transposes: rows of NumPy.
        self.by_state, self.by_slot = np.zeros((states, states)), np.zeros((states, slots))
        self._buffer, self.evaluate = function.buffer()
        for i, array in enumerate((self.x, self.z, self.p, self.w, self.time)):
            self._buffer.set_arg(i, memoryview(array))  # type: ignore[arg-type]
        for i, array in enumerate((self.rates, self.by_state, self.by_slot)):
            self._buffer.set_res(i, memoryview(array.reshape(-1)))  # type: ignore[arg-type]


class _Joined:
    """Symbols and expressions of all components, wires put through."""

    def __init__(self, rig: Rig, slots: tuple[str, ...]) -> None:
        import casadi as ca

        self.p = ca.SX.sym("p", len(rig.parameters))
        self.w = ca.SX.sym("w", len(rig.externals))
        self.z = ca.SX.sym("z", len(slots))
        self.time = ca.SX.sym("time")
        symbols = {name: self.p[i] for i, name in enumerate(rig.parameters)}
        symbols |= {name: self.w[i] for i, name in enumerate(rig.externals)}
        wires = {target: ca.SX.sym(target) for target in rig.connections}
        symbols |= wires
        symbols |= {name: self.z[i] for i, name in enumerate(slots)}

        states, rates, begun, names = [], [], [], []
        values: dict[str, Any] = {}
        for instance, component in rig.components.items():
            u = ca.vertcat(*(symbols[f"{instance}.{n}"] for n in component.u.names))
            d = component.settled(ca.vertcat(*(symbols[f"{instance}.{n}"] for n in component.p.names)))
            x = ca.SX.sym(instance, component.x.size)
            y = component.outputs_of(x, u, d, self.time)
            values |= {f"{instance}.{n}": y[i] for i, n in enumerate(component.y.names)}
            states.append(x)
            rates.append(component.rates_of(x, u, d, self.time))
            begun.append(component.states_at_start(u, d))
            names += [f"{instance}.{n}" for n in component.x.names]
        self.x, self.states = ca.vertcat(*states), names

        everything = ca.vertcat(*rates, *begun, *values.values())
        fed = ca.vertcat(*wires.values()) if wires else ca.SX(0, 1)
        for _ in range(len(wires) + 1):
            feeding = ca.vertcat(*(values[source] for source in rig.connections.values()))
            values = (
                dict(
                    zip(
                        values,
                        ca.vertsplit(ca.substitute(ca.vertcat(*values.values()), fed, feeding)),
                        strict=True,
                    )
                )
                if wires
                else values
            )
            everything = ca.substitute(everything, fed, feeding) if wires else everything
        count = self.x.shape[0]
        self.rates, self.begun = everything[:count], everything[count : 2 * count]
        self.values = dict(zip(values, ca.vertsplit(everything[2 * count :]), strict=True))
        left = [name for name, symbol in wires.items() if ca.depends_on(everything, symbol)]
        if left:
            raise ValueError(f"{rig.name} has an algebraic loop through {', '.join(left)}")


def _needed_states(ca: Any, x: Any, rates: Any, observed: Any) -> list[int]:
    """Indices of the states that the outputs depend on, at once or through other states."""
    by_state = np.array(ca.DM(ca.jacobian(rates, x).sparsity(), 1)) != 0
    needed = (np.array(ca.DM(ca.jacobian(observed, x).sparsity(), 1)) != 0).any(axis=0)
    while True:
        more = needed | by_state[needed].any(axis=0)
        if (more == needed).all():
            return [int(i) for i in np.flatnonzero(needed)]
        needed = more
