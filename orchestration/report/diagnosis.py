"""The folder of a diagnosis: its page, `diagnosis.json`, the extended model and the next experiment."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import (
    cause_entry,
    errors_in_noise,
    wrong_entries,
)
from warmlink.orchestration.diagnosis.answer.extension import extended_values, write_ssp_of
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.answer.profile import (
    calibration,
    calibration_doubts,
    met_bounds,
    profiles_of,
)
from warmlink.orchestration.diagnosis.diagnose import write_next
from warmlink.orchestration.diagnosis.fit.fitted import Wrong
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.search import NEAR
from warmlink.orchestration.diagnosis.ladder.judged import EQUATION
from warmlink.orchestration.diagnosis.ladder.wired import predictor_file
from warmlink.orchestration.diagnosis.terms.entries import content_with
from warmlink.orchestration.diagnosis.terms.equation import Equation
from warmlink.orchestration.diagnosis.terms.words import summary_with
from warmlink.orchestration.report.diagnosis_figures import (
    equation_sections,
    heat_sections,
    profile_figure,
    run_sections,
)
from warmlink.orchestration.report.ladder import improvement_sections, ladder_sections
from warmlink.orchestration.report.page import PageTable, Section, write_page
from warmlink.orchestration.results import ASKED, results_folder
from warmlink.orchestration.system.ssp.parameter_values import write_ssv
from warmlink.orchestration.system.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

_RANKED, _FEWEST = 10, 6
"""Sets in the ranking at most; and at least, where so many were thought of."""

SSV, SSP, JSON, PAGE = "extended.ssv", "extended.ssp", "diagnosis.json", "report.html"
_USUAL = (
    "The machine's usual parameters, fitted together, each held near its usual value as far as the log does "
    "not tell it. The intervals count what such a model lacks."
)
VIRTUAL = "VirtualMeasurement.fmu"  # the growth by what thermometers read


def write_report(diagnosis: Diagnosis, path: Path, equation: Equation | None = None) -> None:
    """Write the page; it opens from disk without a network."""
    title, lead, *lines = summary_with(diagnosis, equation).splitlines()
    remarks = "\n".join(diagnosis.remarks)
    nearest = " (the nearest causes, none of which explains it)" if diagnosis.verdict == "unknown" else ""
    nearest = " (that with the equation)" if diagnosis.delivered == EQUATION else nearest
    by_equation, leads = ([], False) if equation is None else (equation_sections(equation), equation.leads)
    by_place = equation is not None and bool(equation.discovery.missing)
    sections = [
        Section("In short", "\n".join(lines), warning=_growing(diagnosis)),
        *(by_equation if leads else []),
        *ladder_sections(diagnosis),
        *([Section("How the measurements were read", remarks)] if remarks else []),
        *_calibrated(diagnosis),
        *_causes(diagnosis),
        *([] if leads else by_equation),
        *([] if by_place else heat_sections(diagnosis.missing_heat)),
        *run_sections(diagnosis),
        Section(
            "What the simulation gets wrong",
            "As it stands, on the rows that were fitted. A whiteness of 1 is pure noise, near 0 a course.",
            _wrong_table(diagnosis, diagnosis.wrong),
        ),
        Section(
            "What is left",
            f"The same with the chosen model{nearest}.",
            _wrong_table(diagnosis, diagnosis.remaining),
        ),
        Section(
            "Ranking",
            "Sets of causes by chi-square plus a penalty for each cause, which chance alone reaches in "
            "seven of a thousand runs with nothing wrong. A set whose parameter would rather lie beyond "
            "a physical bound is rejected, however well it fits.",
            _ranking(diagnosis),
        ),
        *([] if (proposed := _proposed(diagnosis, equation)) is None else [_next(proposed)]),
        *improvement_sections(diagnosis),
    ]
    write_page(path, title, lead, sections)


def _growing(diagnosis: Diagnosis) -> str:
    """Warn where the model to use from now on predicts the held-out rows worse than the uncorrected one."""
    errors = errors_in_noise(diagnosis, diagnosis.adopted, heldout=True)
    if errors is None or errors["rmse_after"] <= errors["rmse_before"] or not diagnosis.causes:
        return ""
    grown = f"from {errors['rmse_before']:.3g} to {errors['rmse_after']:.3g} times the noise"
    return f"The error on held-out rows grows {grown}."


def _calibrated(diagnosis: Diagnosis) -> list[Section]:
    rows = [(*_number(c.name, asdict(c)), ", ".join(c.alike) or "-") for c in calibration(diagnosis)]
    text = "Numbers that every model fits, as the experiment asks; here those of the model to use."
    text = text if diagnosis.experiment.calibrated else _USUAL
    told, table = [text, *calibration_doubts(diagnosis)], PageTable((*_NUMBER, "not told apart from"), rows)
    return [Section("Calibrated", "\n".join(told), table, warning=met_bounds(diagnosis))] if rows else []


_NUMBER = ("variable", "value", "95 % interval", "unit")


def _number(name: str, of: Mapping[str, Any]) -> tuple[str, ...]:
    return name, f"{of['value']:.4g}", f"{of['low95']:.4g} to {of['high95']:.4g}", of["unit"]


def _causes(diagnosis: Diagnosis) -> list[Section]:
    sections = []
    for item in diagnosis.causes:
        rows = [_number(*each) for each in cause_entry(diagnosis, item)["parameters"].items()]
        cause = item.cause
        near = "A nearest cause, not established.\n" * (diagnosis.verdict == "empirical")
        text = f"{near}{cause.sentence}\nIt looks like this: {cause.looks_like}.\nCheck: {cause.check}"
        table = PageTable(_NUMBER, rows)
        sections.append(Section(item.title, text, table))
    profiles = profiles_of(diagnosis.assessment) if diagnosis.causes else []
    if profiles:
        text = "Each strength held at values around the best, everything else fitted anew."
        figure = profile_figure(diagnosis, profiles)
        sections.append(Section("How well the strengths are known", text, figure=figure))
    return sections


def _wrong_table(diagnosis: Diagnosis, wrong: Mapping[str, Wrong]) -> PageTable:
    rows = []
    for name, each in wrong_entries(diagnosis, wrong).items():
        follows = [f"{signal['signal']} ({signal['r']:+.2f})" for signal in each["correlates_with"]]
        numbers = [text.format(**each) for text in ("{rmse:.3g}", "{noise:.2g}", "{bias:+.2g}")]
        numbers.append("< 1e-6" if each["whiteness_p"] < 1e-6 else f"{each['whiteness_p']:.2g}")
        rows.append((f"{name} [{each['unit']}]", *numbers, [*each["when"], "-"][0], [*follows, "-"][0]))
    return PageTable(("channel", "RMSE", "noise", "bias", "whiteness", "wrong when", "follows"), rows)


def _ranking(diagnosis: Diagnosis) -> PageTable:
    search, best = diagnosis.assessment.search, diagnosis.assessment.best
    fits = sorted(search.fits.values(), key=lambda fit: fit.chi2 + search.penalty(fit.items))[:_RANKED]
    rows = [(fit.key, f"{fit.chi2:.1f}", _reason(diagnosis, fit)) for fit in fits]
    for each in search.not_fitted(max(_FEWEST - len(rows), 0)):
        if np.isfinite(each.chi2):
            worse = f"not fitted: expected to be {_worse(each.chi2 - best.chi2)}"
            rows.append((each.key, f"about {each.chi2:.1f}", worse))
    titled = [(" + ".join(sorted(key)) or "as it stands", *others) for key, *others in rows]
    return PageTable(("causes", "chi-square", "why not"), titled)


def _reason(diagnosis: Diagnosis, fit: Fit) -> str:
    best = diagnosis.assessment.best
    if fit is best:
        found = diagnosis.causes or diagnosis.verdict == "adequate"
        return "chosen" if found else "nearest, and does not explain it"
    if not fit.admissible:
        return "a strength would have to lie beyond its physical bound"
    if fit.key in {rival.key for rival in diagnosis.assessment.rivals}:
        return "nothing: these data do not tell it from the chosen one"
    return _worse(fit.chi2 - best.chi2)


def _worse(more: float) -> str:
    """How a set compares that leaves so much more of chi-square."""
    if more > NEAR:
        return f"worse: {more:.0f} more of chi-square unexplained"
    return "no better than chance would make it with as many causes"


def _proposed(diagnosis: Diagnosis, equation: Equation | None) -> Proposed | None:
    """The next experiment: that of a set of equations if there is one, else that of the causes."""
    return diagnosis.proposed if equation is None else equation.proposed or diagnosis.proposed


def _next(proposed: Proposed) -> Section:
    cycle, times = proposed.cycle
    rows = []
    for stage in cycle:
        pad = "-" if np.isnan(stage.pad) else f"{stage.pad - ZERO_CELSIUS:.0f}"
        rows.append((f"{stage.duration / 60:.0f}", f"{stage.speed:.2f}", f"{stage.torque:.1f}", pad))
    table = PageTable(("minutes", "speed [rad/s]", "torque [N.m]", "pad [degC]"), rows) if rows else None
    text = proposed.why
    if proposed.expected_chance is not None:
        text += (
            f"\nExpected separation: {proposed.expected_separation_sigma:.1f} sigma; "
            f"chance of naming the cause: {100 * proposed.expected_chance:.0f} %."
        )
    if times > 1:
        text += f"\nThe stages below are gone through {times} times."
    return Section("The next experiment", text, table)


def write_diagnosis(
    diagnosis: Diagnosis, folder: Path, store: FmuStore | None = None, equation: Equation | None = None
) -> dict[str, Path]:
    """Write `diagnosis.json`, the page, the extended model, and the next experiment where one is proposed.

    Without FMUs from a `store` the extended model is the `.ssv` alone. A model that is only the nominal one,
    as nothing explains the run, is not written. With an `equation` that was found the extended model is the
    one with it. Returns the paths by name of the file.
    """
    rig = diagnosis.experiment.rig
    values: Mapping[str, float]
    if equation is not None and equation.extends:
        rig, values = equation.extended
    else:
        values = extended_values(diagnosis.assessment.problem, diagnosis.handed_on.fit)
    compiles = store is not None and store.kind == "native"
    ssv, ssp = extended_files(diagnosis, store is not None, equation, compiles)
    proposed = _proposed(diagnosis, equation)
    with results_folder(folder, "diagnose") as work:
        if ssv is not None:
            write_ssv(values, work / ssv, name="extended")
        if ssp is not None and store is not None:
            write_ssp_of(rig, values, work / ssp, store, diagnosis.delivery)
        if compiles and diagnosis.delivery.virtual_measurement is not None:
            copyfile(predictor_file(diagnosis.delivery.virtual_measurement), work / VIRTUAL)
        _write_json(content_with(diagnosis, equation, ssv, ssp), work / JSON)
        write_report(diagnosis, work / PAGE, equation)
        if proposed is not None and proposed.duty:
            write_next(proposed, diagnosis.experiment.rig, diagnosis.experiment.known, work)
        names = [path.name for path in work.iterdir() if path.name != ASKED]
    return {name: folder / name for name in names}


def extended_files(
    diagnosis: Diagnosis, as_system: bool, equation: Equation | None = None, compiles: bool = True
) -> tuple[str | None, str | None]:
    """Names of the parameter set and the system that are written, None for what is not.

    A system that holds plain fits is written only if something here `compiles` them.
    """
    extends = equation is not None and equation.extends
    if not (diagnosis.delivers or extends):
        return None, None
    return SSV, SSP if as_system and (extends or compiles or not diagnosis.delivery.plain) else None


def write_diagnoses(parts: Mapping[str, Diagnosis], whole: dict[str, Any], folder: Path) -> None:
    """Write a folder for each part of a machine, and `diagnosis.json` with what is said of the whole."""
    for name, each in parts.items():
        write_diagnosis(each, folder / name)
    with results_folder(folder, "diagnose") as work:
        _write_json(whole, work / JSON)


def _write_json(content: dict[str, Any], path: Path) -> None:
    text = json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
