"""One transient run: temperatures, heat balance and elongation over time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.paper.fea.drive import Drive
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
