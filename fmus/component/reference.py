"""A component integrated to a tight tolerance: what FMUs, masters and reduced models are compared with.

SciPy's BDF on the component's own rates. A joined component has no communication steps between its parts,
so there is no coupling error in it either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Component
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.integrator import ComplexStepJacobian, Vector


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
    rows: list[NDArray[np.float64]] = []
    state: Vector | None = None
    begun = 0.0
    for number, phase in enumerate(phases, start=1):
        for name, value in phase.inputs.items():
            u[component.u.index[name]] = value
        if state is None:
            state = np.asarray(component.states_at_start(u, settled), dtype=float)
        grid = begun + every * np.arange(round(phase.duration / every) + 1.0)
        rates = partial(_rates, component, u.copy(), settled)
        found = solve_ivp(
            rates,
            (begun, grid[-1]),
            state,
            "BDF",
            t_eval=grid,
            rtol=tolerance,
            atol=tolerance,
            jac=_SparseJacobian(rates, begun, state),
        )
        if not found.success:
            raise RuntimeError(f"no integration beyond {found.t[-1]:g} s: {found.message}")
        kept = grid if number == len(phases) else grid[:-1]
        times.append(kept)
        for time, each in zip(kept, found.y.T, strict=False):
            rows.append(np.asarray(component.outputs_of(each, u, settled, time), dtype=float)[places])
        state, begun = found.y[:, -1], float(grid[-1])
    return Trajectory(np.concatenate(times), dict(zip(record, np.transpose(rows), strict=True)))


def _rates(component: Component, u: Vector, settled: Vector, time: float, state: Number) -> Number:
    return component.rates_of(state, u, settled, time)


class _SparseJacobian:
    """Jacobian by complex step, with the structure that it has at a point."""

    def __init__(self, rates: partial[Number], time: float, state: Vector) -> None:
        size = len(state)
        every = ComplexStepJacobian(np.ones((size, size), dtype=bool))
        structure = every(partial(rates, time), state) != 0
        self._jacobian = ComplexStepJacobian(structure | np.eye(size, dtype=bool))
        self._rates = rates

    def __call__(self, time: float, state: Vector) -> Any:
        from scipy.sparse import csc_matrix

        return csc_matrix(self._jacobian(partial(self._rates, time), state))
