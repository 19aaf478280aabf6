"""A component integrated to a tight tolerance: what FMUs, masters and reduced models are compared with.

SciPy's BDF on the component's own rates, which CasADi evaluates. A joined component has no communication
steps between its parts, so there is no coupling error in it either.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.component.integrator import Vector

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True)
class Phase:
    """A time in s over which inputs are held, in SI units by name; the others keep what they had."""

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

    KeyError: a name is not one of the component's. ValueError: a phase is not a multiple of `every`.
    RuntimeError: the integration failed.

    Parameters
    ----------
    component : the declaration
    phases : what the inputs are, one after another; at a change, values belong to the new phase
    record : outputs by name
    every : time in s between two recorded points; it must divide each phase
    tolerance : relative tolerance, and absolute in the states' units
    parameters : values in SI units by name, where not the declared ones
    """
    from scipy.integrate import solve_ivp

    p, u = component.start_values(parameters)
    settled = np.asarray(component.settled(p), dtype=float)
    functions, places = _functions(component), [component.y.index[name] for name in record]
    state: Vector | None = None
    begun, found = 0.0, [np.empty((len(record) + 1, 0))]
    for number, phase in enumerate(phases, start=1):
        u = u.copy()
        for name, value in phase.inputs.items():
            u[component.u.index[name]] = value
        if state is None:
            state = np.asarray(component.states_at_start(u, settled), dtype=float)
        count = round(phase.duration / every)
        if not math.isclose(count * every, phase.duration):
            raise ValueError(f"a phase of {phase.duration:g} s is no multiple of {every:g} s")
        grid = begun + every * np.arange(count + 1.0)
        solution = solve_ivp(
            lambda t, x, u: np.asarray(functions["rates"](x, u, settled, t)).ravel(),
            *((begun, grid[-1]), state, "BDF", grid),
            args=(u,),
            jac=lambda t, x, u: functions["jacobian"](x, u, settled, t).sparse(),
            rtol=tolerance,
            atol=tolerance,
        )
        if not solution.success:
            raise RuntimeError(f"no integration beyond {solution.t[-1]:g} s: {solution.message}")
        kept = grid if number == len(phases) else grid[:-1]
        states, times = solution.y[:, : kept.size], kept[None, :]
        outputs = np.asarray(functions["outputs"](states, u, settled, times))
        found.append(np.vstack([times, outputs[places]]))
        state, begun = solution.y[:, -1], float(grid[-1])
    times, *values = np.concatenate(found, axis=1)
    return Trajectory(times, dict(zip(record, values, strict=True)))


@lru_cache(maxsize=16)
def _functions(component: Component) -> Mapping[str, casadi.Function]:
    """Functions of states, inputs, settled parameters and time; the Jacobian is that of the rates."""
    import casadi

    sizes = {"x": component.x.size, "u": component.u.size, "p": component.d.size, "time": 1}
    given = [casadi.SX.sym(name, size) for name, size in sizes.items()]
    rates, outputs = component.rates_of(*given), component.outputs_of(*given)
    wanted = {"rates": rates, "jacobian": casadi.jacobian(rates, given[0]), "outputs": outputs}
    return {name: casadi.Function(name, given, [each]) for name, each in wanted.items()}
