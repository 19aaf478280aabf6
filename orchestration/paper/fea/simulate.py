"""One transient run: temperatures, heat balance and elongation over time.

Time stepping is by a two-stage, singly diagonally implicit Runge-Kutta method of order 2, L-stable and
stiffly accurate (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006): both stages share one matrix, factorised
once for each pair of step size and heat transfer coefficient and kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.fea.drive import Drive, within
from warmlink.orchestration.paper.fea.elasticity import ThermoElasticity
from warmlink.orchestration.paper.fea.heat import HeatModel
from warmlink.orchestration.paper.fea.mesh import Body

GAMMA = 1 - 1 / np.sqrt(2)
#: Radiation is iterated until no node changes by more than this [K].
RADIATION_TOLERANCE = 1e-8
#: The radiation matrix is taken at the ambient temperature plus this [K], so that the iteration contracts
#: fast.
RADIATION_CENTRE = 7.0


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
        self.body = body
        self._displacement_order = displacement_order
        self._models: dict[tuple[str, ...] | None, HeatModel] = {}

    @cached_property
    def elasticity(self) -> ThermoElasticity:
        """The thermo-elastic model, set up when first asked for."""
        return ThermoElasticity(self.body, self._displacement_order)

    def heat_model(self, cooled: tuple[str, ...] | None = None) -> HeatModel:
        """Return the heat equation's matrices for these cooled boundaries."""
        if cooled not in self._models:
            self._models[cooled] = HeatModel(self.body, cooled)
        return self._models[cooled]

    def run(self, drive: Drive, times: Array, initial_temperature: float) -> History:
        """Simulate from a uniform temperature [K] over the times [s], a step from each to the next."""
        model = self.heat_model(drive.cooled)
        fields, flows = self._fields(drive, times, initial_temperature)
        rise = fields - initial_temperature
        received, convected, radiated = np.cumsum(flows, axis=0).T
        return History(
            time=times,
            temperature=self._probed(fields),
            elongation=rise @ self.elasticity.elongation_row,
            received=received,
            convected=convected,
            radiated=radiated,
            stored=rise @ np.asarray(model.capacity.sum(axis=0)).ravel(),
            final=fields[-1],
        )

    def temperatures(self, drive: Drive, times: Array, initial_temperature: float) -> dict[str, Array]:
        """Probe temperatures [K] of such a run, without the elongation and its cost."""
        return self._probed(self._fields(drive, times, initial_temperature)[0])

    def _probed(self, fields: Array) -> dict[str, Array]:
        return {name: fields @ self.heat_model().probe(probe) for name, probe in self.body.probes.items()}

    def _fields(self, drive: Drive, times: Array, initial_temperature: float) -> tuple[Array, Array]:
        """Temperatures [K], shape (times, nodes), and the heat moved in every step [J], shape (times, 3)."""
        model = self.heat_model(drive.cooled)
        stepper = HeatStepper(model, drive)
        fields = np.full((len(times), model.size), initial_temperature)
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
        self._model = model
        self._drive = drive
        held = model.heated_nodes if drive.temperature is not None else np.zeros(0, dtype=np.int64)
        self._held = held
        self._free = np.setdiff1d(np.arange(model.size), held)
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
        new = base + GAMMA * size * rate_2
        weights = size * np.array([1 - GAMMA, GAMMA])
        return new, weights @ np.array([flow_1, flow_2]) + np.array([jump, 0.0, 0.0])

    def _stage(self, base: Array, start: float, size: float, fraction: float) -> tuple[Array, Array]:
        """Solve one stage; return its rate [K/s] and the heat flows [W] received, convected, radiated."""
        model, drive, surface = self._model, self._drive, self._model.surface
        h = within(drive.convection, start, size, fraction)
        ambient = within(drive.ambient, start, size, fraction)
        step = GAMMA * size
        factor, matrix = self._factor(step, h, ambient)
        flow = within(drive.heat_flow, start, size, fraction) if drive.heat_flow is not None else 0.0
        load = h * ambient * surface.load + flow * model.heated_load
        stage = base.copy()
        if drive.temperature is not None:
            stage[self._held] = within(drive.temperature, start, size, fraction)
        radiated = np.zeros(model.size)
        for _ in range(50):
            if drive.radiation:
                radiated = surface.radiant_load(stage, ambient)
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
        return rate, np.array([flow, surface.convective(stage, h, ambient), radiated.sum()])

    def _factor(self, step: float, h: float, ambient: float) -> tuple[Any, csc_matrix]:
        """Factorise C / step + K + h B (+ radiation about the ambient); return it and K + h B."""
        centre = round(ambient / 5) * 5 + RADIATION_CENTRE if self._drive.radiation else 0.0
        key = (step, h, centre)
        if key not in self._factors:
            model = self._model
            matrix = csc_matrix(model.conduction + h * model.convection)
            system = model.capacity / step + matrix
            if self._drive.radiation:
                system = system + model.surface.radiant_matrix(centre)
            free = csc_matrix(system[self._free][:, self._free])
            self._factors[key] = (
                splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}),
                matrix,
            )
        return self._factors[key]
