"""The folder of a diagnosis: its page, `diagnosis.json` and the extended model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import (
    SHOWN,
    cause_entry,
    errors_by_run,
    errors_in_noise,
    json_content,
    shown,
    wrong_entries,
)
from warmlink.orchestration.diagnosis.answer.extension import extended_values, write_ssp_of, write_ssv_of
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.answer.next_files import DUTY, SCENARIO, write_next
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.fit.residuals import Wrong
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.report.figures import DASHES, styled
from warmlink.orchestration.report.missing_heat import heat_sections
from warmlink.orchestration.report.page import Section, Table, versions, write_page

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

SSV, SSP, JSON, PAGE = "extended.ssv", "extended.ssp", "diagnosis.json", "report.html"

Vector = NDArray[np.float64]

_MEASURED, _BEFORE, _AFTER = "#9aa3b2", "#d1603d", "#3b6fb6"
_RANKED = 10


def write_diagnosis(diagnosis: Diagnosis, folder: Path, store: FmuStore | None = None) -> dict[str, Path]:
    """Write `diagnosis.json`, the page, the extended model, and the next experiment where one is proposed.

    Parameters
    ----------
    diagnosis : what was found
    folder : where to; made if need be
    store : FMUs for the extended `.ssp`; without them only the `.ssv` is written

    Returns
    -------
    dict
        Paths by name of the file.
    """
    values = extended_values(diagnosis.assessment.problem, diagnosis.chosen())
    with fresh_folder(folder) as work:
        write_ssv_of(values, work / SSV)
        if store is not None:
            write_ssp_of(diagnosis.experiment.rig.name, values, work / SSP, store)
        write_json(json_content(diagnosis, SSV, SSP if store is not None else None), work / JSON)
        write_report(diagnosis, work / PAGE)
        if diagnosis.proposed is not None and diagnosis.proposed.duty:
            write_next(diagnosis.proposed, diagnosis.experiment.rig, diagnosis.experiment.known, work)
        names = [path.name for path in work.iterdir()]
    for name in {SCENARIO, DUTY} - set(names):  # an older proposal would be taken for today's
        (folder / name).unlink(missing_ok=True)
    return {name: folder / name for name in names}


def write_json(content: dict[str, Any], path: Path) -> None:
    """Write a JSON file that people can read too."""
    text = json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")


def write_report(diagnosis: Diagnosis, path: Path) -> None:
    """Write the page; it opens from disk without a network."""
    lines = summary(diagnosis).splitlines()
    sections = [
        Section("In short", "\n".join(lines[2:]), warning=_growing(diagnosis)),
        *_remarks(diagnosis),
        *_causes(diagnosis),
        *heat_sections(diagnosis.missing_heat),
        *_figures(diagnosis),
        Section(
            "What the simulation gets wrong",
            "As it stands, on the rows that were fitted. A whiteness of 1 is pure noise, near 0 a course.",
            _wrong_table(diagnosis, diagnosis.wrong),
        ),
        Section(
            "What is left",
            "The same with the chosen model"
            + (
                " (the nearest causes, none of which explains it)." if diagnosis.verdict == "unknown" else "."
            ),
            _wrong_table(diagnosis, diagnosis.remaining),
        ),
        Section(
            "Ranking",
            "Sets of causes by chi-square plus a penalty for each cause, which chance alone reaches in "
            "seven of a thousand runs with nothing wrong. A set whose parameter would rather lie beyond "
            "a physical bound is rejected, however well it fits.",
            _ranking(diagnosis),
        ),
        *_next(diagnosis.proposed),
        Section("The improvement", _gain_text(diagnosis), _gain_table(diagnosis)),
        Section("Made with", table=versions()),
    ]
    write_page(path, lines[0], lines[1], sections)


def _growing(diagnosis: Diagnosis) -> str:
    """Warn where the model to use from now on predicts the held-out rows worse than the uncorrected one."""
    before, after = diagnosis.held_out[:2]
    if before is None or after is None or after.in_noise <= before.in_noise or not diagnosis.causes:
        return ""
    grown = f"from {before.in_noise:.3g} to {after.in_noise:.3g} times the noise"
    return f"The error on held-out rows grows {grown}."


def _remarks(diagnosis: Diagnosis) -> list[Section]:
    remarks = diagnosis.experiment.remarks
    return [Section("How the measurements were read", "\n".join(remarks))] if remarks else []


def _causes(diagnosis: Diagnosis) -> list[Section]:
    sections = []
    for item in diagnosis.causes:
        entry = cause_entry(diagnosis, item)
        rows = [
            (name, f"{p['value']:.4g}", f"{p['low95']:.4g} to {p['high95']:.4g}", p["unit"])
            for name, p in entry["parameters"].items()
        ]
        text = (
            f"{item.cause.sentence}\nIt looks like this: {item.cause.looks_like}.\nCheck: {item.cause.check}"
        )
        sections.append(
            Section(item.title, text, Table(("variable", "value", "95 % interval", "unit"), rows))
        )
    return sections


def _figures(diagnosis: Diagnosis) -> list[Section]:
    sections = []
    problem = diagnosis.scores.problem
    for run, (measured, data) in enumerate(zip(diagnosis.experiment.runs, problem.data, strict=True)):
        role = "held out" if measured.heldout else "fitted"
        part = (
            "" if measured.fit_until > data.time[-1] else f", from {measured.fit_until / 60:.0f} min held out"
        )
        sections.append(
            Section(
                f"{measured.name} ({role}{part})",
                "Left: measured and simulated. Right: measured minus simulated, over the noise's sigma.",
                figure=_figure(diagnosis, run),
            )
        )
    return sections


def _figure(diagnosis: Diagnosis, run: int) -> Any:
    from plotly.subplots import make_subplots

    problem = diagnosis.scores.problem
    data = problem.data[run]
    channels = [i for i in range(len(problem.variables)) if np.isfinite(data.readings[:, i]).any()]
    figure = make_subplots(
        rows=len(channels),
        cols=2,
        shared_xaxes=True,
        vertical_spacing=0.22 / max(len(channels), 3),
        horizontal_spacing=0.08,
        column_widths=[0.6, 0.4],
        column_titles=("measured, simulated", "error / sigma"),
    )
    minutes = data.time / 60
    pairs = [("as it stands", diagnosis.before, _BEFORE)]
    if diagnosis.after is not diagnosis.before:
        pairs.append(
            ("nearest causes" if diagnosis.verdict == "unknown" else "extended", diagnosis.after, _AFTER)
        )
    for row, i in enumerate(channels, start=1):
        name = problem.names[problem.variables[i]]
        unit = diagnosis.units()[name]
        factor, zero = (SHOWN[shown(unit)], 273.15 if shown(unit) == "K" else 0.0)
        measured = data.readings[:, i]
        _trace(figure, (row, 1), "measured", minutes, (measured - zero) * factor, _points(_MEASURED))
        for (word, predicted, colour), dash in zip(pairs, DASHES, strict=False):
            readings = predicted.readings[run][:, i]
            line = {"mode": "lines", "line": {"color": colour, "width": 2, "dash": dash}}
            _trace(figure, (row, 1), word, minutes, (readings - zero) * factor, line)
            error = (measured - readings) / diagnosis.scores.scales[run][i]
            _trace(figure, (row, 2), word, minutes, error, _points(colour))
        label = "degC" if shown(unit) == "K" else unit
        figure.update_yaxes(title_text=f"{name.replace('_', ' ')}<br>[{label}]", row=row, col=1)
    figure.update_xaxes(title_text="time [min]", row=len(channels))
    until = diagnosis.experiment.runs[run].fit_until
    if until < data.time[-1]:
        figure.add_vrect(
            x0=until / 60, x1=float(minutes[-1]), fillcolor="#5b6577", opacity=0.08, line_width=0
        )
    return styled(figure, 170 * len(channels) + 90, 600).update_layout(margin_t=60)


def _points(colour: str) -> dict[str, Any]:
    return {"mode": "markers", "marker": {"size": 3, "color": colour}}


def _trace(
    figure: Any, place: tuple[int, int], word: str, minutes: Vector, values: Vector, style: dict[str, Any]
) -> None:
    """Draw a signal at a row and column of the figure; the legend names those of the first place."""
    figure.add_scatter(
        x=minutes.astype(np.float32),
        y=values.astype(np.float32),
        name=word,
        legendgroup=word,
        showlegend=place == (1, 1),
        row=place[0],
        col=place[1],
        **style,
    )


def _wrong_table(diagnosis: Diagnosis, wrong: dict[str, Wrong]) -> Table:
    rows = []
    for name, each in wrong_entries(diagnosis, wrong).items():
        follows = [f"{signal['signal']} ({signal['r']:+.2f})" for signal in each["correlates_with"]]
        rows.append(
            (
                f"{name} [{each['unit']}]",
                f"{each['rmse']:.3g}",
                f"{each['noise']:.2g}",
                f"{each['bias']:+.2g}",
                f"{each['whiteness_p']:.2g}",
                *([*each["when"], "-"][:1]),
                *([*follows, "-"][:1]),
            )
        )
    return Table(("channel", "RMSE", "noise", "bias", "whiteness", "wrong when", "follows"), rows)


def _ranking(diagnosis: Diagnosis) -> Table:
    assessment = diagnosis.assessment
    search = assessment.search
    fits = sorted(search.fits.values(), key=lambda fit: fit.chi2 + search.penalty(fit.items))
    # Whatever the score, each single cause that was fitted is of interest, but few rows are read.
    rows = []
    for fit in fits[:_RANKED]:
        score = fit.chi2 + search.penalty(fit.items)
        state = "" if fit.admissible else "rejected: beyond a bound"
        if fit is assessment.best:
            state = "chosen" if diagnosis.causes or diagnosis.verdict == "adequate" else "nearest"
        name = " + ".join(sorted(fit.key)) or "as it stands"
        rows.append(
            (name, f"{fit.chi2:.1f}", f"{score:.1f}", f"{score - search.score(assessment.best):+.1f}", state)
        )
    return Table(("causes", "chi-square", "score", "to the best", ""), rows)


def _next(proposed: Proposed | None) -> list[Section]:
    if proposed is None:
        return []
    cycle, times = proposed.cycle
    rows = [
        (
            f"{stage.duration / 60:.0f}",
            f"{stage.speed:.2f}",
            f"{stage.torque:.1f}",
            "-" if np.isnan(stage.pad) else f"{stage.pad - 273.15:.0f}",
        )
        for stage in cycle
    ]
    table = Table(("minutes", "speed [rad/s]", "torque [N.m]", "pad [degC]"), rows) if rows else None
    text = (
        f"{proposed.why}\nExpected separation: {proposed.expected_separation_sigma:.1f} sigma; "
        f"chance of naming the cause: {100 * proposed.expected_chance:.0f} %."
    )
    if times > 1:
        text += f"\nThe stages below are gone through {times} times."
    return [Section("The next experiment", text, table)]


def _gain_text(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes:
        return "No cause is added, so nothing changes."
    told = []
    for words, pair in (
        ("the model's elongation is taken out as a feed-forward", diagnosis.feed_forward),
        ("the observer designed on the model goes by the thermometers", diagnosis.observer),
    ):
        if pair is not None:
            first, then = (
                f"{1e6 * each.largest:.2f} um ({1e6 * each.low95:.2f} to {1e6 * each.high95:.2f})"
                for each in pair
            )
            told.append(f"{first} before, {then} after, when {words}.")
    if not told:
        return ""
    return "Largest error of the tool point, of two-minute means (95 %):\n" + "\n".join(told)


def _gain_table(diagnosis: Diagnosis) -> Table:
    rows = []
    for word, heldout in (("fitted rows", False), ("held-out rows", True)):
        errors = errors_in_noise(diagnosis, diagnosis.adopted, heldout)
        if errors is not None:
            first, then = (
                f"{errors[key]:.3g} ({errors[f'{key}_95'][0]:.3g} to {errors[f'{key}_95'][1]:.3g})"
                for key in ("rmse_before", "rmse_after")
            )
            rows.append((f"{word} [sigma]", first, then))
    for run, channels in errors_by_run(diagnosis, diagnosis.adopted).items():
        rows += [
            (f"{run}: {name} [{each['unit']}]", f"{each['rmse_before']:.3g}", f"{each['rmse_after']:.3g}")
            for name, each in channels.items()
        ]
    return Table(("RMSE (95 % interval)", "before", "after"), rows)
