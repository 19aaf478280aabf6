"""The 1-D link, joined to what drives it and integrated to a tight tolerance, beside the finite elements.

What holds the base at a temperature is a heater without power of a heat capacity beyond all measure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.component.join import join
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.plant import ROD_WIRES
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.cases import Case
from warmlink.orchestration.paper.data import load_geometry, load_materials

#: Thermal resistance [K/W] that holds the base at a prescribed temperature to 0.001 K for a few watts.
RIGID = 1e-4
#: Heat capacity [J/K] of what does not cool.
ENDLESS = 1e12
_PROBES = {
    "base": "link.base_temperature",
    "middle": "link.sensor_temperature[2]",
    "tip": "link.tip_temperature",
}


@dataclass(frozen=True)
class LinkHistory:
    """What the 1-D link did: `time` [s], `temperature` [K], `elongation` [m], `heat_flow` received [W]."""

    time: Array
    temperature: Mapping[str, Array]
    elongation: Array
    heat_flow: Array

    def at(self, times: Array) -> LinkHistory:
        """The same at some of its times [s]."""
        kept = np.searchsorted(self.time, times)
        probes = {name: values[kept] for name, values in self.temperature.items()}
        return LinkHistory(self.time[kept], probes, self.elongation[kept], self.heat_flow[kept])


def follow(
    joined: Component, phases: Sequence[Phase], every: float, parameters: Mapping[str, float] | None = None
) -> LinkHistory:
    """Integrate a `link` and, as first instance, what heats it; `every`: between two points [s]."""
    source = joined.parameters[0].name.partition(".")[0]
    record = [*_PROBES.values(), "link.elongation", f"{source}.heat_flow"]
    found = integrate(joined, phases, record, every=every, tolerance=1e-7, parameters=parameters)
    probes = {name: found.values[output] for name, output in _PROBES.items()}
    return LinkHistory(
        found.time, probes, found.values["link.elongation"], found.values[f"{source}.heat_flow"]
    )


def run_link(case: Case, convection: float | None = None) -> LinkHistory:
    """Run a case on the link, its base held at the shaft's temperature; `convection` replaces h."""
    geometry, material = load_geometry(), load_materials().link
    parameters = {
        "heater.heat_capacity": ENDLESS,
        "heater.contact_resistance": RIGID,
        "heater.initial_temperature": case.shaft,
        "link.length": geometry.length,
        "link.width": geometry.width,
        "link.thickness": geometry.thickness,
        "link.base_position": geometry.shaft_centre,
        "link.tip_position": geometry.diode_centre,
        "link.conductivity": material.conductivity,
        "link.density": material.density,
        "link.specific_heat": material.specific_heat,
        "link.expansion_coefficient": material.expansion_coefficient,
        "link.convection_still": case.convection if convection is None else convection,
        "link.initial_temperature": case.ambient,
    }
    phase = Phase(
        case.duration, {"heater.on": 0.0, "link.speed": 0.0, "link.ambient_temperature": case.ambient}
    )
    return follow(_rod(), [phase], float(case.times[1]), parameters).at(case.times)


@cache
def _rod() -> Component:
    """The link and a heater at its base; joined once."""
    return join("Rod", {"heater": HEATER, "link": LINK}, ROD_WIRES)
