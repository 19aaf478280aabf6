"""Time stepping of the heat equation: a two-stage, singly diagonally implicit Runge-Kutta method.

Order 2, L-stable and stiffly accurate (R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006): both stages
share one matrix, factorised once for each pair of step size and heat transfer coefficient and kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from warmlink.fmus.errors import InputError
from warmlink.orchestration.paper.fea.drive import Drive, within
from warmlink.orchestration.paper.fea.heat import HeatModel

Array = NDArray[np.float64]

GAMMA = 1 - 1 / np.sqrt(2)
#: Radiation is iterated until no node changes by more than this [K].
RADIATION_TOLERANCE = 1e-8
#: The radiation matrix is taken at the ambient temperature plus this [K], so that the iteration contracts
#: fast.
RADIATION_CENTRE = 7.0


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
        """Step by `size` [s] from `start` [s].

        Returns
        -------
        new temperatures [K], and heat moved [J]: received at the heated boundary, convected and radiated away
        """
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
