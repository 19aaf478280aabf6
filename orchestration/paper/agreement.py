"""The 1-D link against the 3-D finite elements, over the paper's cases and over duty cycles; finer meshes.

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
from warmlink.orchestration.finite_elements.transient import Drive, Fea, History, held
from warmlink.orchestration.paper.cases import Case, fea, follow, run_link
from warmlink.orchestration.paper.data import load_geometry, load_materials
from warmlink.orchestration.paper.mesh import Assembly, bare_link, paper_assembly
from warmlink.orchestration.system.units import ZERO_CELSIUS

AMBIENT = 295.15
"""K, temperature of room and cell at the start of a duty cycle."""

SAMPLE = 15.0
"""s between two points of the heat flow that both models get, straight lines between them."""

DUTY_CYCLES: dict[str, tuple[Phase, ...]] = {
    name: tuple(demand(*segment, AMBIENT) for segment in segments)
    for name, segments in {
        "continuous": [(3600.0, 3.43, 2.5)],
        "stop and go": [(600.0, 3.43, 2.5), (600.0, 0.0, 0.5)] * 3,
        "break, then heavy": [(1500.0, 3.43, 2.5), (900.0, 0.0, 0.5), (1200.0, 2.0, 4.0)],
    }.items()
}
"""Phases of duration [s], mean absolute speed [rad/s], rms torque [N.m]."""


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


@dataclass(frozen=True)
class Refinement:
    """One mesh of a convergence study: after an hour, tip temperature [degC] and elongation [um]."""

    body: str
    refinement: int
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
            suffix = "_ring" if "base_ring" in history.temperature else ""
            base, tip = (
                # The step in which a held temperature jumps says nothing: 1-D holds a node, 3-D a surface.
                _extreme((link.temperature[where] - history.temperature[where + suffix])[1:])
                for where in ("base", "tip")
            )
            growth = _extreme(link.elongation - history.elongation)
            percent = 100 * growth / float(np.abs(history.elongation).max())
            found.append(Agreement(run, name, base, tip, percent))
    return found


def duty_drive(phases: Sequence[Phase]) -> tuple[Drive, History]:
    """Run motor and 1-D link as one system; give their heat flow as a drive, and the link's course."""
    starts = np.cumsum([0.0, *(phase.duration for phase in phases)])
    link, flow = follow(plant(), phases, SAMPLE * np.arange(starts[-1] / SAMPLE + 0.5), SAMPLE)
    nominal = Instance(LINK)
    still, per_speed = nominal.get("convection_still"), nominal.get("convection_per_speed")
    speeds = [phase.inputs["link.speed"] * load_geometry().span / 2 for phase in phases]
    drive = Drive(
        convection=held(starts[:-1], [still + per_speed * speed for speed in speeds]),
        ambient=AMBIENT,
        heat_flow=lambda time: float(np.interp(time, link.time, flow)),
    )
    return drive, link


def refinements() -> list[Refinement]:
    """Convergence on the assembly (8-node displacement, to afford three meshes) and on the link alone."""
    case = Case.printed("moving")
    heated = Drive(case.convection, case.ambient, heat_flow=1.7)
    minutes = np.linspace(0.0, 3600.0, 61)
    runs = [
        *(("assembly", n, fea(Assembly(refinement=n)).body, case.drive(), case.times) for n in (1, 2, 3)),
        *(
            ("link alone, 1.7 W", n, bare_link(load_geometry(), load_materials(), n), heated, minutes)
            for n in (1, 2, 4)
        ),
    ]
    found = []
    for name, n, body, drive, times in runs:
        history = Fea(body, displacement_order=1).run(drive, times, case.ambient)
        tip = float(history.temperature["tip"][-1]) - ZERO_CELSIUS
        found.append(Refinement(name, n, tip, float(history.elongation[-1]) * 1e6))
    return found


def _extreme(values: Array) -> float:
    """The value farthest from zero, with its sign."""
    return float(values[np.argmax(np.abs(values))])
