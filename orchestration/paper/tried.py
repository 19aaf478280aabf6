"""What was tried on each disagreement between the paper and the models, and the models on each other.

Nothing is fitted to the measured elongation. The joint resistance alone is set from a printed temperature,
the link's above the shaft in the moving case, and then kept.

The 1-D link is compared with the 3-D finite elements over the paper's cases and over duty cycles. With the
same boundary conditions (the link alone) the two should agree; with shaft and diode they differ by what these
do, which is quantified by adding one after the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.reference import Phase
from warmlink.fmus.plant import demand, plant
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.transient import Fea, HeatDrive, History, held_course
from warmlink.orchestration.paper.cases import PaperCase, fea, follow, run_link, steady_time
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS, PAPER
from warmlink.orchestration.paper.mesh import RodMesh, bare_link, paper_assembly
from warmlink.orchestration.progress import Progress
from warmlink.orchestration.system.units import ZERO_CELSIUS

HEATER_LAG = 180.0
"""s; "several minutes" ([1] III.A) taken as the time constant of the heating pad; assumed."""


@dataclass(frozen=True)
class TriedModel:
    """One change to the 3-D model and what came out after an hour, in um, degC and s.

    `effect` is that on the elongation against the model as described, `left` what is above the measured one.
    """

    case: str
    name: str
    elongation: float
    base: float
    tip: float
    effect: float
    left: float
    steady: float


@dataclass(frozen=True)
class Consistency:
    """Elongation [um] that two printed temperatures imply, whatever h, beside the one printed with them."""

    name: str
    base: float
    tip: float
    implied: float
    printed: float


def try_everything(progress: Progress) -> tuple[list[TriedModel], dict[str, float]]:
    """Run every attempt on both cases; give them, and the pad gaps [m] `without` and `with` radiation."""
    progress("gaps below the pad", 0.0)
    gaps = {"without": _gap_for_printed_base(False), "with": _gap_for_printed_base(True)}
    attempts: list[TriedModel] = []
    for share, case in ((0.4, "stationary"), (0.7, "moving")):
        progress(f"attempts at the {case} case", share)
        attempts += _attempts(PaperCase.printed(case), gaps)
    return attempts, gaps


def implied_by_temperatures(base_rise: float, tip_rise: float) -> float:
    """Elongation [m] of a steady fin between the two measured rises [K], its tip insulated.

    The ratio gives m L = acosh(base / tip), whatever the loss; the mean rise is base tanh(m L) / (m L).
    """
    m_l = math.acosh(base_rise / tip_rise)
    return MATERIALS["link"].expansion_coefficient * GEOMETRY.span * base_rise * math.tanh(m_l) / m_l


def consistency() -> list[Consistency]:
    """Elongations that the paper's own temperatures imply, also were the infrared camera 2 K too high."""
    moving, offset = PAPER["moving"], PAPER["camera"]["infrared_accuracy"].value
    ambient = moving["ambient"].value
    found = []
    for name, kind, shift in (
        ("measured", "measured", 0.0),
        (f"measured, infrared camera reading {offset:g} K high", "measured", offset),
        ("the paper's FEA", "predicted", 0.0),
    ):
        base, tip = (moving[f"{where}_{kind}"].value - shift for where in ("base", "tip"))
        implied = implied_by_temperatures(base - ambient, tip - ambient)
        found.append(Consistency(name, base, tip, implied * 1e6, moving[f"elongation_{kind}"].value))
    return found


def _attempts(case: PaperCase, gaps: dict[str, float]) -> list[TriedModel]:
    radiation, lag, joint = {"radiation": True}, {"lag": HEATER_LAG}, {"pad_gap": gaps["with"]}
    shorter = {"elongation_at": "clear"}
    measured = PAPER[case.name]["elongation_measured"].value
    attempts: list[TriedModel] = []
    tried: tuple[tuple[str, dict[str, Any], dict[str, Any]], ...] = (
        ("as described", {}, {}),
        ("radiation", radiation, {}),
        ("joint resistance", {}, {"pad_gap": gaps["without"]}),
        ("heater lag", lag, {}),
        ("cooled link only", {}, {"only_link_cooled": True}),
        ("effective length", {}, shorter),
        ("radiation and joint resistance", radiation, joint),
        ("all of these together", radiation | lag, joint | shorter),
    )
    for name, driven, built in tried:
        run = fea(RodMesh(**built)).run(case.drive(**driven), case.times, case.ambient)
        effect = run.growth - (attempts[0].elongation if attempts else run.growth)
        ends, steady = (run.end("base"), run.end("tip")), steady_time(run.time, run.elongation)
        attempts.append(TriedModel(case.name, name, run.growth, *ends, effect, run.growth - measured, steady))
    return attempts


def _gap_for_printed_base(radiation: bool) -> float:
    """Bare shaft [m] between pad and link that brings the link to its measured temperature there."""
    case = PaperCase.printed("moving")
    wanted = PAPER["moving"]["base_measured"].value + ZERO_CELSIUS
    drive = case.drive(radiation=radiation)

    def surplus(gap: float) -> float:
        # Not by `fea`, which would keep a model of each gap tried.
        model = Fea(paper_assembly(RodMesh(pad_gap=gap)))
        return float(model.fields(drive, case.times, case.ambient)[-1] @ model.body.probes["base"]) - wanted

    return float(np.round(brentq(surplus, 5e-4, 2e-2, xtol=1e-5), 6))


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
    """Largest difference over a run, 1-D minus 3-D, of base and tip [K], and of the elongation [%]."""

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


def agreements(progress: Progress) -> list[Agreement]:
    """Compare the link alone and with what is attached to it, over two cases and three duty cycles."""
    storeless = {**MATERIALS, "shaft": replace(MATERIALS["shaft"], specific_heat=1e-2)}
    with_shaft, with_diode = (RodMesh(diode=diode, elongation_at="centre") for diode in (False, True))
    bodies = {
        "link alone": bare_link(2),
        "with shaft": paper_assembly(with_shaft),
        "with shaft and diode": paper_assembly(with_diode),
        "with a shaft that stores no heat": paper_assembly(with_shaft, storeless),
    }
    models = {name: Fea(body, displacement_order=1) for name, body in bodies.items()}
    cases = [PaperCase.printed(name) for name in ("stationary", "moving")]
    runs = {case.name: (case.drive(), run_link(case)) for case in cases}
    runs |= {name: duty_drive(phases) for name, phases in DUTY_CYCLES.items()}
    found = []
    for done, (run, (drive, link)) in enumerate(runs.items()):
        progress(f"the 1-D link beside 3-D: {run}", done / len(runs))
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


def duty_drive(phases: Sequence[Phase]) -> tuple[HeatDrive, History]:
    """Run motor and 1-D link as one system; give their heat flow as a drive, and the link's course."""
    starts = np.cumsum([0.0, *(phase.duration for phase in phases)])
    link, flow = follow(plant(), phases, SAMPLE * np.arange(starts[-1] / SAMPLE + 0.5), SAMPLE)
    nominal = Instance(LINK)
    still, per_speed = nominal.get("convection_still"), nominal.get("convection_per_speed")
    speeds = [phase.inputs["link.speed"] * GEOMETRY.span / 2 for phase in phases]
    drive = HeatDrive(
        convection=held_course(starts[:-1], [still + per_speed * speed for speed in speeds]),
        ambient=AMBIENT,
        heat_flow=lambda time: float(np.interp(time, link.time, flow)),
    )
    return drive, link


def refinements() -> list[Refinement]:
    """Convergence on the assembly (8-node displacement, to afford three meshes) and on the link alone."""
    case = PaperCase.printed("moving")
    heated = HeatDrive(case.convection, case.ambient, heat_flow=1.7)
    minutes = np.linspace(0.0, 3600.0, 61)
    runs = [
        *(("assembly", n, fea(RodMesh(refinement=n)).body, case.drive(), case.times) for n in (1, 2, 3)),
        *(("link alone, 1.7 W", n, bare_link(n), heated, minutes) for n in (1, 2, 4)),
    ]
    found = []
    for name, n, body, drive, times in runs:
        run = Fea(body, displacement_order=1).run(drive, times, case.ambient)
        found.append(Refinement(name, n, run.end("tip"), run.growth))
    return found


def _extreme(values: Array) -> float:
    """The value farthest from zero, with its sign."""
    return float(values[np.argmax(np.abs(values))])
