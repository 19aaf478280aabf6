"""One transient run: temperatures, heat balance and elongation over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.paper.fea.drive import Drive, TimeGrid
from warmlink.orchestration.paper.fea.elasticity import ThermoElasticity
from warmlink.orchestration.paper.fea.heat import HeatModel
from warmlink.orchestration.paper.fea.mesh import Body
from warmlink.orchestration.paper.fea.stepping import HeatStepper

Array = NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """What a run recorded at every time of its grid.

    `time` [s]; `temperature` [K] of each probe; `elongation` [m]; cumulative heat [J]: `received` through
    the heated boundary, `convected` and `radiated` to the ambient, `stored` since the start; `final`
    temperatures [K] of all nodes; `initial_temperature` [K], uniform.
    """

    time: Array
    temperature: dict[str, Array]
    elongation: Array
    received: Array
    convected: Array
    radiated: Array
    stored: Array
    final: Array
    initial_temperature: float

    @property
    def balance_error(self) -> float:
        """Largest |received - lost - stored| relative to the largest heat received."""
        gap = self.received - self.convected - self.radiated - self.stored
        return float(np.abs(gap).max() / max(np.abs(self.received).max(), 1e-300))

    def at(self, time: float) -> tuple[dict[str, float], float]:
        """Probe temperatures [K] and elongation [m] at a time [s], linear between steps."""
        probes = {
            name: float(np.interp(time, self.time, values)) for name, values in self.temperature.items()
        }
        return probes, float(np.interp(time, self.time, self.elongation))


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

    def run(
        self,
        drive: Drive,
        grid: TimeGrid,
        initial_temperature: float,
        progress: Callable[[float], None] | None = None,
    ) -> History:
        """Simulate from a uniform temperature [K]; `progress` receives the fraction done."""
        model = self.heat_model(drive.cooled)
        fields, flows = self._fields(drive, grid, initial_temperature, progress)
        rise = fields - initial_temperature
        received, convected, radiated = np.cumsum(flows, axis=0).T
        return History(
            time=grid.times,
            temperature={name: fields @ model.probe(probe) for name, probe in self.body.probes.items()},
            elongation=rise @ self.elasticity.elongation_row,
            received=received,
            convected=convected,
            radiated=radiated,
            stored=rise @ np.asarray(model.capacity.sum(axis=0)).ravel(),
            final=fields[-1],
            initial_temperature=initial_temperature,
        )

    def temperatures(self, drive: Drive, grid: TimeGrid, initial_temperature: float) -> dict[str, Array]:
        """Probe temperatures [K] of such a run, without the elongation and its cost."""
        model = self.heat_model(drive.cooled)
        fields, _ = self._fields(drive, grid, initial_temperature, None)
        return {name: fields @ model.probe(probe) for name, probe in self.body.probes.items()}

    def _fields(
        self,
        drive: Drive,
        grid: TimeGrid,
        initial_temperature: float,
        progress: Callable[[float], None] | None,
    ) -> tuple[Array, Array]:
        """Temperatures [K], shape (times, nodes), and the heat moved in every step [J], shape (times, 3)."""
        model = self.heat_model(drive.cooled)
        stepper = HeatStepper(model, drive)
        times, steps = grid.times, grid.steps
        fields = np.empty((len(times), model.size))
        fields[0] = initial_temperature
        flows = np.zeros((len(times), 3))
        for i, size in enumerate(steps):
            fields[i + 1], moved = stepper.step(fields[i], float(times[i]), size)
            flows[i + 1] = moved.received, moved.convected, moved.radiated
            if progress:
                progress((i + 1) / len(steps))
        return fields, flows
