"""The paper's two cases, run by the 1-D link and by the finite elements.

The 1-D link is joined to what drives it and integrated to a tight tolerance. What holds its base at a
temperature is a heater without power of a heat capacity beyond all measure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from warmlink.controllers.analytic import law
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import join
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.plant import ROD_WIRES
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import Body
from warmlink.orchestration.finite_elements.transient import Fea, HeatDrive, History, graded
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS, PAPER
from warmlink.orchestration.paper.mesh import RodMesh, paper_assembly
from warmlink.orchestration.system.units import ZERO_CELSIUS

RIGID = 1e-4
"""K/W, thermal resistance that holds the base at a prescribed temperature to 0.001 K for a few watts."""

ENDLESS = 1e12
"""J/K, heat capacity of what does not cool."""

_PROBES = {
    "base": "link.base_temperature",
    "middle": "link.sensor_temperature[2]",
    "tip": "link.tip_temperature",
}


@dataclass(frozen=True)
class PaperCase:
    """One of the paper's experiments: `shaft`, `ambient` [K], `convection` [W/(m2.K)], `duration` [s]."""

    name: str
    shaft: float
    ambient: float
    convection: float
    duration: float

    @classmethod
    def printed(cls, name: str) -> PaperCase:
        """Read the case `stationary` or `moving` from the paper's numbers."""
        n = {key: entry.value for key, entry in PAPER[name].items()}
        shaft, ambient = n["shaft"] + ZERO_CELSIUS, n["ambient"] + ZERO_CELSIUS
        return cls(name, shaft, ambient, n["convection"], n["duration"])

    @property
    def rise(self) -> float:
        """Shaft above ambient [K]."""
        return self.shaft - self.ambient

    @property
    def times(self) -> Array:
        """Times [s] whose steps grow after the shaft's temperature jumps."""
        return graded([0.0, self.duration])

    def drive(self, *, radiation: bool = False, lag: float = 0.0) -> HeatDrive:
        """Hold the shaft's temperature; `lag` [s] delays it by a first order."""

        def heated(time: float) -> float:
            return self.ambient + self.rise * (-math.expm1(-time / lag) if lag > 0 else 1.0)

        return HeatDrive(self.convection, self.ambient, temperature=heated, radiation=radiation)


@cache
def fea(assembly: RodMesh) -> Fea:
    """Finite-element model of an assembly, which is made once."""
    return Fea(paper_assembly(assembly))


def follow(
    joined: Component,
    phases: Sequence[Phase],
    times: Array,
    every: float,
    parameters: Mapping[str, float] | None = None,
) -> tuple[History, Array]:
    """Integrate a `link` and, as first instance, what heats it: its history at some times, and its heat flow.

    The integration is recorded `every` so many s; the heat flow that the link receives is in W.
    """
    heat = f"{joined.parameters[0].name.partition('.')[0]}.heat_flow"
    record = [*_PROBES.values(), "link.elongation", heat]
    found = integrate(joined, phases, record, every=every, tolerance=1e-7, parameters=parameters)
    kept = np.searchsorted(found.time, times)
    values = {name: each[kept] for name, each in found.values.items()}
    probes = {name: values[output] for name, output in _PROBES.items()}
    return History(found.time[kept], probes, values["link.elongation"]), values[heat]


def run_link(case: PaperCase, convection: float | None = None) -> History:
    """Run a case on the link, its base held at the shaft's temperature; `convection` replaces h."""
    properties = ("conductivity", "density", "specific_heat", "expansion_coefficient")
    parameters = {
        "heater.heat_capacity": ENDLESS,
        "heater.contact_resistance": RIGID,
        "heater.initial_temperature": case.shaft,
        "link.base_position": GEOMETRY.shaft_centre,
        "link.tip_position": GEOMETRY.diode_centre,
        "link.convection_still": case.convection if convection is None else convection,
        "link.initial_temperature": case.ambient,
        **{f"link.{name}": getattr(GEOMETRY, name) for name in ("length", "width", "thickness")},
        **{f"link.{name}": getattr(MATERIALS["link"], name) for name in properties},
    }
    inputs = {"heater.on": 0.0, "link.speed": 0.0, "link.ambient_temperature": case.ambient}
    phase = Phase(case.duration, inputs)
    return follow(_rod(), [phase], case.times, float(case.times[1]), parameters)[0]


@cache
def _rod() -> Component:
    """The link and a heater at its base; joined once."""
    return join("Rod", {"heater": HEATER, "link": LINK}, ROD_WIRES)


@dataclass(frozen=True)
class CaseResult:
    """A case by both models, as described in the paper, and by Eq. (4) `corrected` and `printed`.

    `final` are the temperatures [K] at the end at all vertices of the body, `displacement` [m] that there.
    """

    case: PaperCase
    fea: History
    link: History
    body: Body
    final: Array
    displacement: Array
    corrected: Array
    printed: Array


def run_case(case: PaperCase) -> CaseResult:
    """Run a case as the paper describes it, on its mesh with every element divided in two each way."""
    model = fea(RodMesh(refinement=2))
    fields = model.fields(case.drive(), case.times, case.ambient)
    link = MATERIALS["link"]
    depth = np.sqrt(link.diffusivity * np.maximum(case.times, 1e-9))
    corrected, printed = (
        np.asarray(equation(case.rise, depth, GEOMETRY.span, link.expansion_coefficient))
        for equation in (law.corrected, law.printed)
    )
    return CaseResult(
        case,
        fea=model.history(case.times, fields),
        link=run_link(case),
        body=model.body,
        final=fields[-1],
        displacement=model.elasticity.displacement(fields[-1] - case.ambient),
        corrected=corrected,
        printed=printed,
    )


def front_profile(result: CaseResult) -> tuple[Array, Array]:
    """Position [m] and final temperature [K] along the middle of the link's front, between the holes."""
    g, mesh = GEOMETRY, result.body.mesh
    start, end = g.shaft_centre + g.shaft_diameter / 2, g.diode_centre - g.diode_diameter / 2
    x, y, z = mesh.p
    on_line = (np.abs(y) < 1e-7) & (np.abs(z - g.thickness) < 1e-7)
    nodes = np.flatnonzero(on_line & (x > start - 1e-7) & (x < end + 1e-7))
    nodes = nodes[np.argsort(x[nodes])]
    return x[nodes], result.final[nodes]


def steady_time(time: Array, values: Array) -> float:
    """Three time constants [s] of what approaches its last value from its first, `values` over `time` [s].

    A time constant is the time to (e - 1)/e of the last value ([1] VI.A).
    """
    share = (values - values[0]) / (values[-1] - values[0])
    reached = int(np.argmax(share >= 1 - math.exp(-1)))
    if reached == 0:
        return 0.0
    ends = slice(reached - 1, reached + 1)
    return 3 * float(np.interp(1 - math.exp(-1), share[ends], time[ends]))
