"""What was tried on each disagreement between the paper and the models, and what each attempt does.

Nothing is fitted to the measured elongation. The joint resistance alone is set from a printed temperature,
the link's above the shaft in the moving case, and then kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from warmlink.orchestration.finite_elements.transient import Fea
from warmlink.orchestration.paper.cases import Case, fea, steady_time
from warmlink.orchestration.paper.data import Geometry, load_geometry, load_materials, load_paper
from warmlink.orchestration.paper.mesh import Assembly, paper_assembly
from warmlink.orchestration.system.units import ZERO_CELSIUS

HEATER_LAG = 180.0
"""s; "several minutes" ([1] III.A) taken as the time constant of the heating pad; assumed."""

CAMERA_SUPPORT, CAMERA_EXPANSION = 0.1, 23.6e-6
"""m and 1/K, length and expansion coefficient of the camera's support, aluminium; assumed."""


@dataclass(frozen=True)
class Attempt:
    """One change to the 3-D model and what came out after an hour.

    `elongation` [um], `base` and `tip` temperature [degC]; `effect` [um] on the elongation against the model
    as described; `left` [um] above the measured elongation; `steady` time of the elongation [s].
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


def try_everything(progress: Callable[[float], None]) -> tuple[list[Attempt], dict[str, float]]:
    """Run every attempt on both cases; give them, and the pad gaps [m] `without` and `with` radiation."""
    gaps = {"without": _gap_for_printed_base(False), "with": _gap_for_printed_base(True)}
    progress(0.4)
    attempts = _attempts(Case.printed("stationary"), gaps)
    progress(0.7)
    return attempts + _attempts(Case.printed("moving"), gaps), gaps


def camera_warming(missing: float) -> float:
    """Warming [K] of the camera's support that would hide so much elongation, `missing` [um]."""
    return missing * 1e-6 / (CAMERA_EXPANSION * CAMERA_SUPPORT)


def implied_by_temperatures(geometry: Geometry, base_rise: float, tip_rise: float, expansion: float) -> float:
    """Elongation [m] of a steady fin between the two measured rises [K], its tip insulated.

    The ratio gives m L = acosh(base / tip), whatever the loss; the mean rise is base tanh(m L) / (m L).
    """
    m_l = math.acosh(base_rise / tip_rise)
    return expansion * geometry.span * base_rise * math.tanh(m_l) / m_l


def consistency() -> list[Consistency]:
    """Elongations that the paper's own temperatures imply, also were the infrared camera 2 K too high."""
    paper, expansion = load_paper(), load_materials().link.expansion_coefficient
    moving, offset = paper["moving"], paper["camera"]["infrared_accuracy"].value
    ambient = moving["ambient"].value
    found = []
    for name, kind, shift in (
        ("measured", "measured", 0.0),
        (f"measured, infrared camera reading {offset:g} K high", "measured", offset),
        ("the paper's FEA", "predicted", 0.0),
    ):
        base, tip = (moving[f"{where}_{kind}"].value - shift for where in ("base", "tip"))
        implied = implied_by_temperatures(load_geometry(), base - ambient, tip - ambient, expansion)
        found.append(Consistency(name, base, tip, implied * 1e6, moving[f"elongation_{kind}"].value))
    return found


def _attempts(case: Case, gaps: dict[str, float]) -> list[Attempt]:
    plain, joint, both = Assembly(), Assembly(pad_gap=gaps["without"]), Assembly(pad_gap=gaps["with"])
    cool, shorter = replace(plain, only_link_cooled=True), replace(plain, elongation_at="clear")
    drive, radiation, lag = case.drive(), case.drive(radiation=True), case.drive(lag=HEATER_LAG)
    slow_and_radiant = case.drive(radiation=True, lag=HEATER_LAG)
    measured = load_paper()[case.name]["elongation_measured"].value
    attempts: list[Attempt] = []
    for name, with_drive, assembly in (
        ("as described", drive, plain),
        ("radiation", radiation, plain),
        ("joint resistance", drive, joint),
        ("heater lag", lag, plain),
        ("cooled link only", drive, cool),
        ("effective length", drive, shorter),
        ("radiation and joint resistance", radiation, both),
        ("all of these together", slow_and_radiant, replace(both, elongation_at="clear")),
    ):
        history = fea(assembly).run(with_drive, case.times, case.ambient)
        base, tip = (float(history.temperature[where][-1]) - ZERO_CELSIUS for where in ("base", "tip"))
        elongation = float(history.elongation[-1]) * 1e6
        effect = elongation - (attempts[0].elongation if attempts else elongation)
        steady = steady_time(history.time, history.elongation)
        attempts.append(
            Attempt(case.name, name, elongation, base, tip, effect, elongation - measured, steady)
        )
    return attempts


def _gap_for_printed_base(radiation: bool) -> float:
    """Bare shaft [m] between pad and link that brings the link to its measured temperature there."""
    case = Case.printed("moving")
    wanted = load_paper()["moving"]["base_measured"].value + ZERO_CELSIUS
    drive = case.drive(radiation=radiation)

    def surplus(gap: float) -> float:
        # Not by `fea`, which would keep a model of each gap tried.
        model = Fea(paper_assembly(load_geometry(), load_materials(), Assembly(pad_gap=gap)))
        return float(model.fields(drive, case.times, case.ambient)[-1] @ model.body.probes["base"]) - wanted

    return float(np.round(brentq(surplus, 5e-4, 2e-2, xtol=1e-5), 6))
