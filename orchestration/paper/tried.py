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

from warmlink.orchestration.paper.cases import Case, fea, steady_time
from warmlink.orchestration.paper.data import Geometry, load_geometry, load_materials, load_paper
from warmlink.orchestration.paper.fea.mesh import Assembly, paper_assembly
from warmlink.orchestration.paper.fea.simulate import Fea
from warmlink.orchestration.system.units import ZERO_CELSIUS

#: "Several minutes" ([1] III.A) taken as the time constant of the heating pad [s]; assumed.
HEATER_LAG = 180.0
#: Length [m] and expansion coefficient [1/K] of the camera's support, aluminium; assumed.
CAMERA_SUPPORT = 0.1
CAMERA_EXPANSION = 23.6e-6


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
    gaps = {
        "without": _gap_for_printed_base(radiation=False),
        "with": _gap_for_printed_base(radiation=True),
    }
    progress(0.4)
    attempts = []
    for number, case in enumerate((Case.printed("stationary"), Case.printed("moving"))):
        attempts += _attempts(case, gaps)
        progress(0.4 + 0.3 * (number + 1))
    return attempts, gaps


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
        base, tip = moving[f"base_{kind}"].value - shift, moving[f"tip_{kind}"].value - shift
        implied = implied_by_temperatures(load_geometry(), base - ambient, tip - ambient, expansion)
        found.append(Consistency(name, base, tip, implied * 1e6, moving[f"elongation_{kind}"].value))
    return found


def _attempts(case: Case, gaps: dict[str, float]) -> list[Attempt]:
    plain, joint, both = Assembly(), Assembly(pad_gap=gaps["without"]), Assembly(pad_gap=gaps["with"])
    drive = case.drive()
    tries = [
        ("as described", drive, plain),
        ("radiation", case.drive(radiation=True), plain),
        ("joint resistance", drive, joint),
        ("heater lag", case.drive(lag=HEATER_LAG), plain),
        ("cooled link only", replace(drive, cooled=("cooled_link",)), plain),
        ("effective length", drive, replace(plain, elongation_at="clear")),
        ("radiation and joint resistance", case.drive(radiation=True), both),
        (
            "all of these together",
            case.drive(radiation=True, lag=HEATER_LAG),
            replace(both, elongation_at="clear"),
        ),
    ]
    measured = load_paper()[case.name]["elongation_measured"].value
    attempts: list[Attempt] = []
    for name, with_drive, assembly in tries:
        history = fea(assembly).run(with_drive, case.times, case.ambient)
        elongation = float(history.elongation[-1]) * 1e6
        attempts.append(
            Attempt(
                case=case.name,
                name=name,
                elongation=elongation,
                base=float(history.temperature["base"][-1]) - ZERO_CELSIUS,
                tip=float(history.temperature["tip"][-1]) - ZERO_CELSIUS,
                effect=elongation - (attempts[0].elongation if attempts else elongation),
                left=elongation - measured,
                steady=steady_time(history.time, history.elongation),
            )
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
        return float(model.temperatures(drive, case.times, case.ambient)["base"][-1]) - wanted

    return float(np.round(brentq(surplus, 5e-4, 2e-2, xtol=1e-5), 6))
