"""The 1-D link against the 3-D finite elements, over the paper's cases and over duty cycles.

With the same boundary conditions (the link alone) the two should agree; with shaft and diode they differ by
what these do, which is quantified by adding one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.plant import demand, plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.paper.cases import Bench, Case
from warmlink.orchestration.paper.fea.drive import Drive, Held, Smooth, TimeGrid
from warmlink.orchestration.paper.fea.mesh import Assembly, Body, bare_link, paper_assembly
from warmlink.orchestration.paper.fea.simulate import Fea, History
from warmlink.orchestration.paper.link_model import LinkHistory, LinkModel

Array = NDArray[np.float64]

#: Temperature of room and cell at the start of a duty cycle [K].
AMBIENT = 295.15
#: The heat flow is averaged over so many seconds when it is handed to both models [s].
SAMPLE = 30.0


def _cycle(*segments: tuple[float, float, float]) -> tuple[Phase, ...]:
    """Phases of duration [s], mean absolute speed [rad/s], rms torque [N.m]."""
    return tuple(demand(*segment, AMBIENT) for segment in segments)


DUTY_CYCLES: dict[str, tuple[Phase, ...]] = {
    "continuous": _cycle((3600.0, 3.43, 2.5)),
    "stop and go": _cycle(*((600.0, 3.43, 2.5), (600.0, 0.0, 0.5)) * 3),
    "break, then heavy": _cycle((1500.0, 3.43, 2.5), (900.0, 0.0, 0.5), (1200.0, 2.0, 4.0)),
}


@dataclass(frozen=True)
class Agreement:
    """Largest difference over a run, 1-D minus 3-D: `base`, `tip` [K]; `elongation` [% of its largest].

    Base and tip of a body with holes are the means around them.
    """

    run: str
    body: str
    base: float
    tip: float
    elongation: float


def agreements(bench: Bench, progress: Callable[[float], None] | None = None) -> list[Agreement]:
    """Compare the link alone and with what is attached to it, over two cases and three duty cycles."""
    geometry, materials = bench.geometry, bench.materials
    storeless = replace(materials, shaft=replace(materials.shaft, specific_heat=1e-2))
    with_shaft, with_diode = (Assembly(diode=diode, elongation_at="centre") for diode in (False, True))
    bodies = {
        "link alone": bare_link(geometry, materials),
        "with shaft": paper_assembly(geometry, materials, with_shaft),
        "with shaft and diode": paper_assembly(geometry, materials, with_diode),
        "with a shaft that stores no heat": paper_assembly(geometry, storeless, with_shaft),
    }
    models = {name: Fea(body, displacement_order=1) for name, body in bodies.items()}
    found = []
    runs = drives(bench)
    for done, (run, (drive, grid)) in enumerate(runs.items()):
        if progress:
            progress(done / len(runs))
        link = LinkModel(bench.geometry, bench.materials.link).run(drive, grid, AMBIENT)
        for name, model in models.items():
            history = model.run(drive, grid, AMBIENT)
            found.append(compare(run, name, model.body, link, history))
    return found


def drives(bench: Bench) -> dict[str, tuple[Drive, TimeGrid]]:
    """Drives of the paper's cases, the shaft's temperature held, and of duty cycles, heat flow given."""
    found = {}
    for name in ("stationary", "moving"):
        case = Case.printed(name)
        found[name] = (case.drive(), case.grid)
    for name, segments in DUTY_CYCLES.items():
        found[name] = duty_drive(bench, segments)
    return found


def duty_drive(bench: Bench, phases: Sequence[Phase]) -> tuple[Drive, TimeGrid]:
    """Run motor and 1-D link as one system; hand on their heat flow, and the convection by speed."""
    received = integrate(plant(), phases, ["link.heat_received"], every=SAMPLE, tolerance=1e-7)
    flow = np.diff(received.values["link.heat_received"]) / SAMPLE
    starts = np.concatenate([[0.0], np.cumsum([phase.duration for phase in phases])])
    nominal = Instance(LINK)
    still, per_speed = nominal.get("convection_still"), nominal.get("convection_per_speed")
    convection = [
        still + per_speed * phase.inputs["link.speed"] * bench.geometry.span / 2 for phase in phases
    ]
    drive = Drive(
        convection=Held(tuple(starts[:-1]), tuple(convection)),
        ambient=Smooth(AMBIENT),
        heat_flow=Held(tuple(received.time[:-1]), tuple(flow)),
    )
    return drive, TimeGrid(((len(flow), SAMPLE),))


def compare(run: str, name: str, body: Body, link: LinkHistory, history: History) -> Agreement:
    """Return the largest differences between both models' histories on one time grid."""
    suffix = "_ring" if "base_ring" in body.probes else ""
    # The step in which a held temperature jumps says nothing: 1-D holds a node, 3-D a surface.
    later = slice(1, None)
    difference = {w: (link.temperature[w] - history.temperature[w + suffix])[later] for w in ("base", "tip")}
    growth = link.elongation - history.elongation
    return Agreement(
        run=run,
        body=name,
        base=_extreme(difference["base"]),
        tip=_extreme(difference["tip"]),
        elongation=100 * _extreme(growth) / float(np.abs(history.elongation).max()),
    )


def _extreme(values: Array) -> float:
    """The value farthest from zero, with its sign."""
    return float(values[np.argmax(np.abs(values))])
