"""The numbers of the paper beside ours, each disagreement with its sentence."""

from __future__ import annotations

import math

from warmlink.orchestration.paper.cases import steady_time
from warmlink.orchestration.paper.data import load_geometry, load_materials, load_paper
from warmlink.orchestration.paper.results import CaseResult, Row
from warmlink.orchestration.paper.tried import Attempt, camera_warming
from warmlink.orchestration.system.units import ZERO_CELSIUS


def paper_rows(cases: dict[str, CaseResult], attempts: list[Attempt]) -> list[Row]:
    """Rows of Tables II and III and of the temperatures and times in the text."""
    rows = [_elongation_row(cases[name], attempts) for name in ("stationary", "moving")]
    rows += [_steady_row(cases["stationary"], attempts)]
    rows += [_temperature_row(cases["moving"], attempts, where) for where in ("base", "tip")]
    rows += [_tip_steady_row(cases["moving"])]
    return rows


def _elongation_row(result: CaseResult, attempts: list[Attempt]) -> Row:
    name = result.case.name
    paper = load_paper()[name]
    tried = {a.name: a for a in attempts if a.case == name}
    together = tried["all of these together"]
    return Row(
        place=paper["elongation_measured"].place,
        case=name,
        quantity="elongation after 1 h",
        unit="um",
        measured=paper["elongation_measured"].value,
        predicted=paper["elongation_predicted"].value,
        printed_eq4=float(result.printed[-1]) * 1e6,
        corrected=float(result.corrected[-1]) * 1e6,
        link=float(result.link.elongation[-1]) * 1e6,
        fea=float(result.fea.elongation[-1]) * 1e6,
        note=(
            f"Radiation takes off {-tried['radiation'].effect:.1f} um, joint resistance "
            f"{-tried['joint resistance'].effect:.1f} um, a length between the holes "
            f"{-tried['effective length'].effect:.1f} um, heater lag "
            f"{abs(tried['heater lag'].effect):.2f} um; together they leave {together.left:.1f} um above "
            f"the measurement, for which a camera support would have to warm by "
            f"{camera_warming(together.left):.1f} K. That part stays unexplained."
        ),
    )


def _steady_row(result: CaseResult, attempts: list[Attempt]) -> Row:
    steady = load_paper()["stationary"]["steady_time"]
    tried = {a.name: a.steady for a in attempts if a.case == "stationary"}
    return Row(
        place=steady.place,
        case="stationary",
        quantity="steady elongation after",
        unit="s",
        measured=steady.value,
        link=steady_time(result.link.time, result.link.elongation),
        fea=steady_time(result.fea.time, result.fea.elongation),
        note=(
            f"Radiation makes it {tried['radiation']:.0f} s, joint resistance "
            f"{tried['joint resistance']:.0f} s, heater lag {tried['heater lag']:.0f} s, all together "
            f"{tried['all of these together']:.0f} s; the rest stays unexplained. Eq. (4) has none."
        ),
    )


def _temperature_row(result: CaseResult, attempts: list[Attempt], where: str) -> Row:
    paper = load_paper()["moving"]
    tried = {a.name: getattr(a, where) for a in attempts if a.case == "moving"}
    case = result.case
    position = 0.0 if where == "base" else load_geometry().span
    # A semi-infinite solid whose surface is raised at t = 0 (Carslaw and Jaeger, chapter 2).
    depth = math.sqrt(load_materials().link.diffusivity * case.duration)
    rise = case.rise * math.erfc(position / (2 * depth))
    return Row(
        place=paper[f"{where}_measured"].place,
        case="moving",
        quantity=f"link above the {'shaft' if where == 'base' else 'diode'}",
        unit="degC",
        measured=paper[f"{where}_measured"].value,
        predicted=paper[f"{where}_predicted"].value,
        corrected=case.ambient + rise - ZERO_CELSIUS,
        link=float(result.link.temperature[where][-1]) - ZERO_CELSIUS,
        fea=float(result.fea.temperature[where][-1]) - ZERO_CELSIUS,
        note=_temperature_note(tried, where),
    )


def _temperature_note(tried: dict[str, float], where: str) -> str:
    if where == "base":
        return (
            f"With the whole shaft surface at 42 degC the link can hardly be cooler. Radiation brings "
            f"{tried['radiation']:.1f} degC; a joint resistance was set to meet the measured 36.6 degC. The "
            "paper does not say which surface was held at 42 degC."
        )
    return (
        f"With the base at its measured temperature: {tried['joint resistance']:.1f} degC without and "
        f"{tried['radiation and joint resistance']:.1f} degC with radiation, the measurement between them."
    )


def _tip_steady_row(result: CaseResult) -> Row:
    steady = load_paper()["moving"]["steady_time_tip"]
    return Row(
        place=steady.place,
        case="moving",
        quantity="steady tip after",
        unit="s",
        predicted=steady.value,
        link=steady_time(result.link.time, result.link.temperature["tip"]),
        fea=steady_time(result.fea.time, result.fea.temperature["tip"]),
        note="By the definition of VI.A, three time constants; the paper gives no definition for this one.",
    )
