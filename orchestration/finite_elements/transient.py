"""Transient runs of a body: what acts on it, and temperatures, heat balance and elongation over time.

Time stepping is by a two-stage, singly diagonally implicit Runge-Kutta method of order 2, L-stable and
stiffly accurate (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006): both stages share one matrix, factorised
once for each pair of step size and heat transfer coefficient and kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import Body, HeatModel, ThermoElasticity
from warmlink.orchestration.finite_elements.forms import symmetric_factor

Course = float | Callable[[float], float]
"""A constant, or a function of time [s]; where it jumps, a time step must end."""

JUST_BEFORE = 1 - 1e-9
"""Share of a step up to which it feels what acts; a jump at its end belongs to the next one."""

GAMMA = 1 - 1 / np.sqrt(2)

RADIATION_TOLERANCE = 1e-8
"""K; radiation is iterated until no node changes by more than this."""

RADIATION_CENTRE = 7.0
"""K above the ambient temperature, where the radiation matrix is taken, so that the iteration contracts
fast."""


def within(course: Course, start: float, step: float, fraction: float) -> float:
    """Value at `start + fraction * step` as the step from `start` of length `step` [s] sees it."""
    return float(course(start + min(fraction, JUST_BEFORE) * step) if callable(course) else course)


def held(times: ArrayLike, values: Sequence[float]) -> Course:
    """Samples at increasing times [s], each of which holds until the next; the first also before its time."""
    return lambda time: values[max(int(np.searchsorted(times, time, side="right")) - 1, 0)]


@dataclass(frozen=True)
class Drive:
    """Everything that acts from outside.

    `convection` [W/(m2.K)], `ambient` [K], and either `temperature` [K] or `heat_flow` [W] at the heated
    boundary. With `radiation` the cooled surface exchanges heat with the ambient by the emissivities.
    """

    convection: Course
    ambient: Course
    temperature: Course | None = None
    heat_flow: Course | None = None
    radiation: bool = False

    def __post_init__(self) -> None:
        if (self.temperature is None) == (self.heat_flow is None):
            raise InputError("drive: give either temperature or heat_flow at the heated boundary, not both")


def graded(breakpoints: Sequence[float]) -> Array:
    """Times [s] from the first breakpoint to the last that meet each, with steps that grow after it.

    Twenty steps of 2 s and of 10 s follow each other; the others are alike, and of a minute at most.
    """
    times = [np.array(breakpoints[:1])]
    for start, end in pairwise(breakpoints):
        for step in (2.0, 10.0):
            if end - start > 40 * step:
                times.append(start + step * np.arange(1, 21))
                start = float(times[-1][-1])
        times.append(np.linspace(start, end, int(np.ceil((end - start) / 60.0)) + 1)[1:])
    return np.concatenate(times)


@dataclass(frozen=True)
class History:
    """What a run recorded at every time of its grid.

    `time` [s]; `temperature` [K] of each probe; `elongation` [m]; cumulative heat [J]: `received` through
    the heated boundary, `convected` and `radiated` to the ambient, `stored` since the start; `final`
    temperatures [K] of all nodes.
    """

    time: Array
    temperature: dict[str, Array]
    elongation: Array
    received: Array
    convected: Array
    radiated: Array
    stored: Array
    final: Array


class Fea:
    """A body made ready for runs: matrices and factorisations are shared between them."""

    def __init__(self, body: Body, displacement_order: int = 2) -> None:
        self.body, self._displacement_order = body, displacement_order
        self.heat = HeatModel(body)
        self.probes = {name: probe.row(body.mesh) for name, probe in body.probes.items()}

    @cached_property
    def elasticity(self) -> ThermoElasticity:
        """The thermo-elastic model, set up when first asked for."""
        return ThermoElasticity(self.body, self._displacement_order)

    def run(self, drive: Drive, times: Array, initial_temperature: float) -> History:
        """Simulate from a uniform temperature [K] over the times [s], a step from each to the next."""
        fields, flows = self._fields(drive, times, initial_temperature)
        rise = fields - initial_temperature
        received, convected, radiated = np.cumsum(flows, axis=0).T
        return History(
            time=times,
            temperature={name: fields @ row for name, row in self.probes.items()},
            elongation=rise @ self.elasticity.elongation_row,
            received=received,
            convected=convected,
            radiated=radiated,
            stored=rise @ np.asarray(self.heat.capacity.sum(axis=0)).ravel(),
            final=fields[-1],
        )

    def temperature(self, probe: str, drive: Drive, times: Array, initial_temperature: float) -> Array:
        """Temperatures [K] of a probe in such a run, without the elongation and its cost."""
        return np.asarray(self._fields(drive, times, initial_temperature)[0] @ self.probes[probe])

    def _fields(self, drive: Drive, times: Array, initial_temperature: float) -> tuple[Array, Array]:
        """Temperatures [K], shape (times, nodes), and the heat moved in every step [J], shape (times, 3)."""
        stepper = HeatStepper(self.heat, drive)
        fields = np.full((len(times), self.heat.size), initial_temperature)
        flows = np.zeros((len(times), 3))
        for i, start in enumerate(times[:-1].tolist()):
            # Rounded, so that steps of one size share a factorisation.
            size = round(float(times[i + 1]) - start, 9)
            fields[i + 1], flows[i + 1] = stepper.step(fields[i], start, size)
        return fields, flows


class HeatStepper:
    """Advances nodal temperatures [K] under a drive.

    Prescribed temperatures are imposed exactly at both stages; the heat they bring in is the residual of the
    nodes' own equations, so that it is consistent with the discrete balance.
    """

    def __init__(self, model: HeatModel, drive: Drive) -> None:
        self._model, self._drive = model, drive
        self._held = model.heated_nodes[: None if drive.temperature is not None else 0]
        self._free = np.setdiff1d(np.arange(model.size), self._held)
        self._factors: dict[tuple[float, float, float], tuple[Any, csc_matrix]] = {}

    def step(self, temperature: Array, start: float, size: float) -> tuple[Array, Array]:
        """Step by `size` from `start` [s]; give temperatures [K] and heat received, convected, radiated."""
        model, drive = self._model, self._drive
        old = temperature.copy()
        jump = 0.0
        if drive.temperature is not None:
            # A jump of the prescribed temperature happens at once, and its heat counts.
            old[self._held] = within(drive.temperature, start, size, 0.0)
            jump = float((model.capacity @ (old - temperature)).sum())
        rate_1, flow_1 = self._stage(old, start, size, GAMMA)
        base = old + (1 - GAMMA) * size * rate_1
        rate_2, flow_2 = self._stage(base, start, size, 1.0)
        weights = size * np.array([1 - GAMMA, GAMMA])
        return base + GAMMA * size * rate_2, weights @ np.array([flow_1, flow_2]) + np.array([jump, 0.0, 0.0])

    def _stage(self, base: Array, start: float, size: float, fraction: float) -> tuple[Array, Array]:
        """Solve one stage; return its rate [K/s] and the heat flows [W] received, convected, radiated."""
        model, drive, step = self._model, self._drive, GAMMA * size
        h, ambient, flow = (
            within(course or 0.0, start, size, fraction)
            for course in (drive.convection, drive.ambient, drive.heat_flow)
        )
        factor, matrix = self._factor(step, h, ambient)
        load = h * ambient * model.load + flow * model.heated_load
        stage, radiated = base.copy(), np.zeros(model.size)
        if drive.temperature is not None:
            stage[self._held] = within(drive.temperature, start, size, fraction)
        for _ in range(50):
            if drive.radiation:
                radiated = model.radiant_load(stage, ambient)
            rate = (stage - base) / step
            residual = load - radiated - model.capacity @ rate - matrix @ stage
            change = factor.solve(residual[self._free]) if len(self._free) else np.zeros(0)
            stage[self._free] += change
            if not drive.radiation or np.abs(change).max(initial=0.0) < RADIATION_TOLERANCE:
                break
        else:
            raise InputError(
                f"radiation: no convergence at {start + fraction * size:.6g} s; take a smaller step"
            )
        rate = (stage - base) / step
        if drive.temperature is not None:
            residual = load - radiated - model.capacity @ rate - matrix @ stage
            flow = -float(residual[self._held].sum())
        return rate, np.array([flow, h * (model.load @ (stage - ambient)), radiated.sum()])

    def _factor(self, step: float, h: float, ambient: float) -> tuple[Any, csc_matrix]:
        """Factorise C / step + K + h B (+ radiation about the ambient); return it and K + h B."""
        centre = round(ambient / 5) * 5 + RADIATION_CENTRE if self._drive.radiation else 0.0
        key = (step, h, centre)
        if key not in self._factors:
            model = self._model
            matrix = csc_matrix(model.conduction + h * model.convection)
            system = model.capacity / step + matrix
            if self._drive.radiation:
                system = system + model.radiant_matrix(centre)
            self._factors[key] = symmetric_factor(system[self._free][:, self._free]), matrix
        return self._factors[key]
