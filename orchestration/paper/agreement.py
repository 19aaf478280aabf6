"""The 1-D link against the 3-D finite elements, over the paper's cases and over duty cycles.

With the same boundary conditions (the link alone) the two should agree; with shaft and diode they differ by
what these do, which is quantified by adding one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import Phase
from warmlink.fmus.plant import demand, plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.paper.cases import Case
from warmlink.orchestration.paper.data import load_geometry, load_materials
from warmlink.orchestration.paper.fea.drive import Drive, held
from warmlink.orchestration.paper.fea.mesh import Assembly, Body, bare_link, paper_assembly
from warmlink.orchestration.paper.fea.simulate import Fea, History
from warmlink.orchestration.paper.link_model import LinkHistory, follow, run_link

#: Temperature of room and cell at the start of a duty cycle [K].
AMBIENT = 295.15
#: Time between two points of the heat flow that both models get, straight lines between them [s].
SAMPLE = 15.0


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


def agreements(progress: Callable[[float], None]) -> list[Agreement]:
    """Compare the link alone and with what is attached to it, over two cases and three duty cycles."""
    geometry, materials = load_geometry(), load_materials()
    storeless = replace(materials, shaft=replace(materials.shaft, specific_heat=1e-2))
    with_shaft, with_diode = (Assembly(diode=diode, elongation_at="centre") for diode in (False, True))
    bodies = {
        "link alone": bare_link(geometry, materials, 2),
        "with shaft": paper_assembly(geometry, materials, with_shaft),
        "with shaft and diode": paper_assembly(geometry, materials, with_diode),
        "with a shaft that stores no heat": paper_assembly(geometry, storeless, with_shaft),
    }
    models = {name: Fea(body, displacement_order=1) for name, body in bodies.items()}
    cases = [Case.printed(name) for name in ("stationary", "moving")]
    runs = {case.name: (case.drive(), run_link(case)) for case in cases}
    runs |= {name: duty_drive(phases) for name, phases in DUTY_CYCLES.items()}
    found = []
    for done, (run, (drive, link)) in enumerate(runs.items()):
        progress(done / len(runs))
        for name, model in models.items():
            history = model.run(drive, link.time, AMBIENT)
            found.append(compare(run, name, model.body, link, history))
    return found


def duty_drive(phases: Sequence[Phase]) -> tuple[Drive, LinkHistory]:
    """Run motor and 1-D link as one system; give their heat flow as a drive, and the link's course."""
    link = follow(plant(), phases, SAMPLE)
    nominal = Instance(LINK)
    still, per_speed = nominal.get("convection_still"), nominal.get("convection_per_speed")
    starts = np.cumsum([0.0, *(phase.duration for phase in phases)])
    speeds = [phase.inputs["link.speed"] * load_geometry().span / 2 for phase in phases]
    drive = Drive(
        convection=held(starts[:-1], [still + per_speed * speed for speed in speeds]),
        ambient=AMBIENT,
        heat_flow=lambda time: float(np.interp(time, link.time, link.heat_flow)),
    )
    return drive, link


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
