"""A component integrated to a tight tolerance: what FMUs, masters and reduced models are compared with.

SciPy's BDF on the component's own rates, which CasADi evaluates. A joined component has no communication
steps between its parts, so there is no coupling error in it either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.component.integrator import Vector

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True)
class Phase:
    """A stretch of time over which the inputs are held.

    Attributes
    ----------
    duration : length in s
    inputs : values in SI units by name, as `motor.speed`; the others keep what they had
    """

    duration: float
    inputs: Mapping[str, float]


@dataclass(frozen=True)
class Trajectory:
    """What was found: times in s, shape (n,), and values by name, each of shape (n,)."""

    time: Vector
    values: Mapping[str, Vector]


def integrate(
    component: Component,
    phases: Sequence[Phase],
    record: Sequence[str],
    *,
    every: float = 10.0,
    tolerance: float = 1e-9,
    parameters: Mapping[str, float] | None = None,
) -> Trajectory:
    """Integrate a component that nothing samples, from its declared start through the phases.

    Parameters
    ----------
    component : the declaration
    phases : what the inputs are, one after another; at a change, values belong to the new phase
    record : outputs by name
    every : time in s between two recorded points; it must divide each phase
    tolerance : relative tolerance, and absolute in the states' units
    parameters : values in SI units by name, where not the declared ones

    Raises
    ------
    KeyError
        A name is not one of the component's.
    RuntimeError
        The integration failed.
    """
    from scipy.integrate import solve_ivp

    p, u = component.start_values(parameters)
    settled = np.asarray(component.settled(p), dtype=float)
    places = [component.y.index[name] for name in record]
    times: list[Vector] = []
    rows: list[Vector] = []
    state: Vector | None = None
    begun = 0.0
    for number, phase in enumerate(phases, start=1):
        for name, value in phase.inputs.items():
            u[component.u.index[name]] = value
        if state is None:
            state = np.asarray(component.states_at_start(u, settled), dtype=float)
        grid = begun + every * np.arange(round(phase.duration / every) + 1.0)
        held = _Held(component, u.copy(), settled)
        found = solve_ivp(
            held.rates,
            (begun, grid[-1]),
            state,
            "BDF",
            t_eval=grid,
            rtol=tolerance,
            atol=tolerance,
            jac=held.jacobian,
        )
        if not found.success:
            raise RuntimeError(f"no integration beyond {found.t[-1]:g} s: {found.message}")
        kept = grid if number == len(phases) else grid[:-1]
        times.append(kept)
        rows.append(held.outputs(kept, found.y[:, : kept.size])[places])
        state, begun = found.y[:, -1], float(grid[-1])
    return Trajectory(np.concatenate(times), dict(zip(record, np.concatenate(rows, axis=1), strict=True)))


class _Held:
    """A component's functions while its inputs are held."""

    def __init__(self, component: Component, u: Vector, settled: Vector) -> None:
        self._functions = _functions(component)
        self._held = u, settled

    def rates(self, time: float, state: Vector) -> Vector:
        return np.asarray(self._functions["rates"](state, *self._held, time)).ravel()

    def jacobian(self, time: float, state: Vector) -> Any:
        """Derivative of the rates by the state, sparse, shape (n, n)."""
        return self._functions["jacobian"](state, *self._held, time).sparse()

    def outputs(self, times: Vector, states: Vector) -> Vector:
        """Outputs at times, shape (outputs, times), for states of shape (n, times)."""
        return np.asarray(self._functions["outputs"](states, *self._held, times[None, :]))


@lru_cache(maxsize=16)
def _functions(component: Component) -> Mapping[str, casadi.Function]:
    """Functions of states, inputs, settled parameters and time."""
    import casadi

    sizes = {"x": component.x.size, "u": component.u.size, "p": component.d.size, "time": 1}
    given = [casadi.SX.sym(name, size) for name, size in sizes.items()]
    rates, outputs = component.rates_of(*given), component.outputs_of(*given)
    wanted = {"rates": rates, "jacobian": casadi.jacobian(rates, given[0]), "outputs": outputs}
    return {name: casadi.Function(name, given, [each]) for name, each in wanted.items()}
