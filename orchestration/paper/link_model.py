"""The 1-D link under the same drive as the finite elements, so that the two can be compared.

The equations are those of the ThermalLink component; only what drives its base differs from the FMU: a held
temperature acts through a conductance within the same implicit step, so that it may be as stiff as wanted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.integrator import ComplexStepJacobian, rosenbrock_step
from warmlink.fmus.thermal_link.component import COMPONENT
from warmlink.fmus.thermal_link.grid import stretches
from warmlink.orchestration.paper.data import Geometry, Material
from warmlink.orchestration.paper.fea.drive import Drive, TimeGrid

Array = NDArray[np.float64]

#: Conductance [W/K] that holds the base at a prescribed temperature to 0.001 K for a few watts.
RIGID = 1e4


@dataclass(frozen=True)
class LinkHistory:
    """What the 1-D link did: `time` [s], `temperature` [K] by name, `elongation` [m], `received` heat [J]."""

    time: Array
    temperature: dict[str, Array]
    elongation: Array
    received: Array


@dataclass(frozen=True)
class LinkModel:
    """The 1-D link with a geometry and a material.

    `contact_conductance` [W/K] lies between a held temperature and the link's base; `parameters` are further
    parameters of the ThermalLink component, by name. `largest_step` [s] bounds the integrator's steps.
    """

    geometry: Geometry
    material: Material
    contact_conductance: float = RIGID
    parameters: Mapping[str, float] = field(default_factory=dict)
    largest_step: float = 5.0

    def run(self, drive: Drive, grid: TimeGrid, initial_temperature: float) -> LinkHistory:
        """Simulate from a uniform temperature [K] over the grid; all surfaces are cooled.

        Raises
        ------
        InputError
            A parameter is unknown or out of range.
        """
        instance = self._instance(drive, initial_temperature)
        p = COMPONENT.settled(np.array([instance.get(name) for name in COMPONENT.p.names]))
        u = np.array([instance.get(name) for name in COMPONENT.u.names])
        x = np.asarray(COMPONENT.states_at_start(u, p), dtype=float)
        full = ComplexStepJacobian(np.ones((x.size, x.size), dtype=bool))
        first = _Step(self, drive, u, p, grid.start, grid.steps[0], grid.start, grid.steps[0])
        jacobian = ComplexStepJacobian(full(partial(first.rates, time=grid.start), x) != 0)
        outputs = [COMPONENT.outputs_of(x, u, p, 0.0)]
        for start, size in zip(grid.times[:-1].tolist(), grid.steps, strict=True):
            count = max(1, int(np.ceil(size / self.largest_step - 1e-9)))
            micro = size / count
            for i in range(count):
                step = _Step(self, drive, u, p, start, size, start + i * micro, micro)
                matrix = jacobian(partial(step.rates, time=step.begin), x)
                x = rosenbrock_step(step.rates, matrix, x, step.begin, micro)
            outputs.append(COMPONENT.outputs_of(x, u, p, start + size))
        return _history(grid.times, np.array(outputs))

    def _instance(self, drive: Drive, initial_temperature: float) -> Instance:
        """An instance with every parameter set and checked."""
        g, m = self.geometry, self.material
        instance = Instance(COMPONENT, "link")
        instance.set(
            {
                "length": g.length,
                "width": g.width,
                "thickness": g.thickness,
                "base_position": g.shaft_centre,
                "tip_position": g.diode_centre,
                "conductivity": m.conductivity,
                "density": m.density,
                "specific_heat": m.specific_heat,
                "expansion_coefficient": m.expansion_coefficient,
                "emissivity": m.emissivity if drive.radiation else 0.0,
                # The drive gives the coefficient itself: one W/(m2.K) a rad/s makes the speed carry it.
                "convection_still": 0.0,
                "convection_per_speed": 2 / g.span,
                "initial_temperature": initial_temperature,
                **self.parameters,
            }
        )
        instance.initialize()
        return instance


@dataclass(frozen=True)
class _Step:
    """One micro step from `begin` [s], inside the grid's step from `start` of length `size` [s]."""

    model: LinkModel
    drive: Drive
    inputs: Array
    parameters: Array
    start: float
    size: float
    begin: float
    micro: float

    def rates(self, x: Number, time: float) -> Number:
        """Rates of the link's states with the drive acting at this time [s]."""
        fraction = (time - self.start) / self.size
        u = self.inputs.astype(x.dtype)
        index = COMPONENT.u.index
        u[index["ambient_temperature"]] = self.drive.ambient.within(self.start, self.size, fraction)
        u[index["speed"]] = self.drive.convection.within(self.start, self.size, fraction)
        if self.drive.temperature is not None:
            temperature = COMPONENT.x.read(x).temperature
            base = temperature[stretches(temperature.shape[0]).base_node]
            held = self.drive.temperature.within(self.start, self.size, fraction)
            u[index["heat_flow"]] = self.model.contact_conductance * (held - base)
        elif self.drive.heat_flow is not None:
            u[index["heat_flow"]] = self.drive.heat_flow.within(self.start, self.size, fraction)
        return COMPONENT.rates_of(x, u, self.parameters, time)


def _history(time: Array, outputs: Array) -> LinkHistory:
    column = COMPONENT.y.index
    names = {"base": "base_temperature", "middle": "sensor_temperature[2]", "tip": "tip_temperature"}
    return LinkHistory(
        time=time,
        temperature={name: outputs[:, column[output]] for name, output in names.items()},
        elongation=outputs[:, column["elongation"]],
        received=outputs[:, column["heat_received"]],
    )
