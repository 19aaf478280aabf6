"""Transient runs of a body: what acts on it, and temperatures and elongation over time.

Time stepping is by a two-stage, singly diagonally implicit Runge-Kutta method of order 2, L-stable and
stiffly accurate (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006): both stages share one matrix, factorised
once for each pair of step size and heat transfer coefficient and kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_matrix

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import Body, HeatModel, ThermoElasticity, symmetric_factor
from warmlink.orchestration.system.units import ZERO_CELSIUS

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


def held_course(times: ArrayLike, values: Sequence[float]) -> Course:
    """Samples at increasing times [s], each of which holds until the next; the first also before its time."""
    return lambda time: values[max(int(np.searchsorted(times, time, side="right")) - 1, 0)]


@dataclass(frozen=True)
class HeatDrive:
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
    """A run over `time` [s]: `temperature` [K] of each probe, and `elongation` [m]."""

    time: Array
    temperature: Mapping[str, Array]
    elongation: Array

    def end(self, probe: str) -> float:
        """Temperature of a probe at the end [degC]."""
        return float(self.temperature[probe][-1]) - ZERO_CELSIUS

    @property
    def growth(self) -> float:
        """Elongation at the end [um]."""
        return float(self.elongation[-1]) * 1e6


class Fea:
    """A body made ready for runs: matrices and factorisations are shared between them."""

    def __init__(self, body: Body, displacement_order: int = 2) -> None:
        self.body, self._displacement_order = body, displacement_order

    @cached_property
    def heat(self) -> HeatModel:
        """The heat equation, set up when first asked for."""
        return HeatModel(self.body)

    @cached_property
    def elasticity(self) -> ThermoElasticity:
        """The thermo-elastic model, set up when first asked for."""
        return ThermoElasticity(self.body, self._displacement_order)

    def run(self, drive: HeatDrive, times: Array, initial: float) -> History:
        """Simulate from a uniform temperature [K] over the times [s], a step from each to the next."""
        return self.history(times, self.fields(drive, times, initial))

    def history(self, times: Array, fields: Array) -> History:
        """What a run from a uniform temperature is seen by, from its temperatures at all nodes."""
        probed = {name: fields @ row for name, row in self.body.probes.items()}
        return History(times, probed, (fields - fields[0]) @ self.elasticity.elongation_row)

    def fields(self, drive: HeatDrive, times: Array, initial: float) -> Array:
        """Temperatures [K] of such a run at all nodes, shape (times, nodes)."""
        stepper = HeatStepper(self.heat, drive)
        fields = np.full((len(times), self.heat.size), initial)
        for i, start in enumerate(times[:-1].tolist()):
            # Rounded, so that steps of one size share a factorisation.
            fields[i + 1] = stepper.step(fields[i], start, round(float(times[i + 1]) - start, 9))
        return fields


class HeatStepper:
    """Advances nodal temperatures [K] under a drive; prescribed ones are imposed exactly at both stages."""

    def __init__(self, model: HeatModel, drive: HeatDrive) -> None:
        self._model, self._drive = model, drive
        self._held = np.empty(0, np.int64) if drive.temperature is None else model.heated_nodes
        self._free = np.setdiff1d(np.arange(model.size), self._held)
        self._factors: dict[tuple[float, float, float], tuple[Any, csc_matrix]] = {}

    def step(self, temperature: Array, start: float, size: float) -> Array:
        """Step by `size` from `start` [s]."""
        old = temperature.copy()
        if self._drive.temperature is not None:  # where it jumps it does so at once
            old[self._held] = within(self._drive.temperature, start, size, 0.0)
        base = old + (1 - GAMMA) * size * self._rate(old, start, size, GAMMA)
        return base + GAMMA * size * self._rate(base, start, size, 1.0)

    def _rate(self, base: Array, start: float, size: float, fraction: float) -> Array:
        """Solve one stage; return its rate [K/s]."""
        model, drive, step = self._model, self._drive, GAMMA * size
        h, ambient, flow, held = (
            within(course or 0.0, start, size, fraction)
            for course in (drive.convection, drive.ambient, drive.heat_flow, drive.temperature)
        )
        factor, matrix = self._factor(step, h, ambient)
        load = h * ambient * model.load + flow * model.heated_load
        stage = base.copy()
        stage[self._held] = held
        for _ in range(50):
            loss = model.radiant_load(stage, ambient) if drive.radiation else 0.0
            residual = load - loss - model.capacity @ ((stage - base) / step) - matrix @ stage
            change = factor.solve(residual[self._free]) if len(self._free) else np.zeros(0)
            stage[self._free] += change
            if not drive.radiation or np.abs(change).max(initial=0.0) < RADIATION_TOLERANCE:
                return (stage - base) / step
        raise InputError(f"radiation: no convergence at {start + fraction * size:.6g} s; take a smaller step")

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
