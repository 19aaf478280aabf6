"""The ladder in numbers and words: held-out errors of each way to predict, in the channels' own units."""

from __future__ import annotations

from typing import Any, NamedTuple

from warmlink.fmus.names import listed
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.ladder.errors import per_si, shown
from warmlink.orchestration.diagnosis.ladder.judged import (
    CALIBRATED,
    CAUSES,
    EQUATION,
    NEAREST,
    PLAIN,
    REMAINDER,
    UNCORRECTED,
)
from warmlink.orchestration.diagnosis.ladder.rungs import AS_GOOD, Ladder, Rung

_WORDS = {
    CALIBRATED: "calibrated model",
    CAUSES: "model with the causes",
    NEAREST: "model with the nearest causes",
    EQUATION: "model with the equation",
    REMAINDER: "model with a learnt remainder",
}
"""What models are called in a sentence."""

_PLAIN = {"ARX": "an ARX model", "first-order lag": "a first-order lag"}

_HOLD_OUT = "; hold out a whole run, which can tell whether it is to be used"

_MUCH = 0.5
"""Share of the delivered model's error from which a virtual measurement is worth a sentence."""


class LadderRow(NamedTuple):
    """Errors of one channel by the name of the rung, root mean square on held-out rows, in a unit."""

    channel: str
    unit: str
    errors: dict[str, float]


def rows_of(diagnosis: Diagnosis) -> list[LadderRow]:
    """Held-out errors of every channel; none if nothing is held out."""
    ladder = diagnosis.ladder
    if not ladder.is_judged:
        return []
    errors = {rung.name: ladder.rms(rung) for rung in ladder.rungs}
    rows = []
    for name, unit in diagnosis.units().items():
        factor = per_si(shown(unit))
        here = {rung: factor * of[name] for rung, of in errors.items() if name in of}
        if here:
            rows.append(LadderRow(name, shown(unit), here))
    return rows


def table_of(diagnosis: Diagnosis) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and cells: a row for each channel, a column for each rung; the delivered one is starred."""
    names = [rung.name for rung in diagnosis.ladder.rungs]
    headings = (f"{n} *" if n == diagnosis.delivered else _heading(diagnosis, n) for n in names)
    cells = [
        (f"{row.channel} [{row.unit}]", *(f"{row.errors[n]:.3g}" if n in row.errors else "-" for n in names))
        for row in rows_of(diagnosis)
    ]
    return ("held-out rms", *headings), cells


def _heading(diagnosis: Diagnosis, name: str) -> str:
    virtual = next(r.question for r in diagnosis.ladder.rungs if r.name == name) != "simulation"
    return f"{name} (thermometers)" if virtual else name


def people_write(unit: str) -> str:
    """A unit of a file as people write it."""
    return "µm" if unit == "um" else unit


def ladder_lines(diagnosis: Diagnosis) -> list[str]:
    """What is delivered and how well it predicts, in at most three sentences; none if nothing is held out."""
    rows = {row.channel: row for row in rows_of(diagnosis)}
    if not rows:
        return []
    row = rows[_telling(diagnosis, rows)]
    name = diagnosis.delivered
    before, after = row.errors[UNCORRECTED], row.errors.get(name, float("nan"))
    if not diagnosis.delivers:
        lines = [
            f"Nothing is delivered: no model predicts the held-out rows better than the uncorrected one, "
            f"which is off by {before:.3g} {people_write(row.unit)} rms in {row.channel}."
        ]
    elif name == UNCORRECTED:
        lines = [f"On held-out rows {row.channel} is off by {after:.3g} {people_write(row.unit)} rms."]
    elif name == PLAIN:
        lines = [_with_plain_fits(diagnosis, row, before, after)]
    elif name == CALIBRATED and diagnosis.by_parts is not None and after > before:
        lines = [_by_parts(diagnosis, diagnosis.by_parts, row)]
    else:
        fitted = _numbers(diagnosis) if name == CALIBRATED else ""
        change = f"from {before:.3g} to {after:.3g} {people_write(row.unit)} rms"
        lines = [
            f"To use from now on: the {_WORDS.get(name, name)}{fitted}; "
            f"held-out error of {row.channel} {change}."
        ]
    return [*lines, *_better(diagnosis, rows)]


def _numbers(diagnosis: Diagnosis) -> str:
    return f" ({len(diagnosis.adopted.fit.freed)} numbers)"


def _by_parts(diagnosis: Diagnosis, parts: Ladder, row: LadderRow) -> str:
    """What a plain calibration gains in all of the log, where the end of it speaks against."""
    factor = per_si(row.unit)
    before, after = (f"{factor * parts.rms(rung)[row.channel]:.3g}" for rung in parts.rungs)
    return (
        f"To use from now on: the calibrated model{_numbers(diagnosis)}; each part of the log by the others, "
        f"the error of {row.channel} falls from {before} to {after} {people_write(row.unit)} rms."
    )


def _with_plain_fits(diagnosis: Diagnosis, row: LadderRow, before: float, after: float) -> str:
    """Which channels plain fits tell from now on, beside which model, and where they stand."""
    by_fit: dict[str, list[str]] = {}
    for channel, rung in diagnosis.delivery.plain.items():
        by_fit.setdefault(_PLAIN[rung.name], []).append(diagnosis.ladder.channels[channel])
    fits = "; ".join(f"{fit} for {listed(names)}" for fit, names in by_fit.items())
    model = _WORDS.get(diagnosis.delivery.others.best_model, "uncorrected model")
    return (
        f"To use from now on: the {model}, and {fits} (outputs of the extended system's part predictor); "
        f"held-out error of {row.channel} from {before:.3g} to {after:.3g} {people_write(row.unit)} rms."
    )


def _telling(diagnosis: Diagnosis, rows: dict[str, LadderRow]) -> str:
    """The channel by which a prediction is told: the elongation, or the one that the model changes most."""
    growth = _growth(diagnosis)
    if growth in rows:
        return growth
    name = diagnosis.delivered
    return max(
        rows,
        key=lambda each: rows[each].errors[UNCORRECTED] / max(rows[each].errors.get(name, 1e300), 1e-300),
    )


def _growth(diagnosis: Diagnosis) -> str:
    """Column of the growth, "" if it was not measured."""
    ladder = diagnosis.ladder
    return "" if ladder.growth is None else ladder.channels[ladder.growth]


def _better(diagnosis: Diagnosis, rows: dict[str, LadderRow]) -> list[str]:
    """Where a plain fit, or the uncorrected model, is better than what is delivered."""
    ours, rungs = diagnosis.delivered, diagnosis.ladder.rungs
    plain = [rung.name for rung in rungs if rung.name in _PLAIN]
    virtual = [r.name for r in rungs if r.question != "simulation"]
    found = []
    for row in rows.values():
        for name in (*plain, UNCORRECTED):
            if name != ours and name in row.errors and row.errors[ours] > AS_GOOD * row.errors[name]:
                found.append((row.errors[ours] / row.errors[name], name, row))
    lines = []
    if found:
        _, name, row = max(found, key=lambda each: each[0])
        word = {"ARX": "an ARX model", "first-order lag": "a first-order lag"}.get(
            name, "the uncorrected model"
        )
        pair = f"{row.errors[name]:.3g} against {row.errors[ours]:.3g} {people_write(row.unit)}"
        more = len({each[2].channel for each in found}) - 1
        also = f", and {more} more channel{'s' * (more > 1)}" if more else ""
        remedy = "" if name == UNCORRECTED or diagnosis.ladder.judges_whole_runs else _HOLD_OUT
        where = " at the end of the log" if diagnosis.by_parts is not None and ours == CALIBRATED else ""
        lines.append(f"Yet {word} predicts {row.channel}{also} better{where}: {pair}{remedy}.")
    gained = [
        (row.errors[n] / max(row.errors[ours], 1e-300), n, row)
        for row in rows.values()
        for n in virtual
        if n in row.errors
    ]
    growth = _growth(diagnosis)
    for share, name, row in [] if diagnosis.causes else gained:
        if row.channel == growth and share < _MUCH:
            lines.append(
                f"Where thermometers are read, a {name} on them tells {row.channel} "
                f"to {row.errors[name]:.3g} {people_write(row.unit)}"
                f"{' (VirtualMeasurement.fmu)' if diagnosis.delivery.virtual else ''}."
            )
    return lines


def ladder_entries(diagnosis: Diagnosis) -> dict[str, Any]:
    """Entry `ladder` of `diagnosis.json`: errors in each channel's own unit, by rung."""
    ladder = diagnosis.ladder
    units = {row.channel: row.unit for row in rows_of(diagnosis)}
    return {
        "delivered": diagnosis.delivered if diagnosis.delivers else None,
        "said": ladder_lines(diagnosis),
        "plain": {ladder.channels[c]: rung.name for c, rung in diagnosis.delivery.plain.items()},
        "by_parts": _part_entries(diagnosis, units),
        "rungs": [_rung(diagnosis, rung, units) for rung in ladder.rungs if units],
    }


def _part_entries(diagnosis: Diagnosis, units: dict[str, str]) -> dict[str, Any] | None:
    """Errors in all parts of the log, each by the others, of the uncorrected model and the calibrated one."""
    parts = diagnosis.by_parts
    if parts is None:
        return None
    errors = {rung.name: parts.rms(rung) for rung in parts.rungs}
    return {
        name: {channel: per_si(units[channel]) * rms for channel, rms in of.items() if channel in units}
        for name, of in errors.items()
    }


def _rung(diagnosis: Diagnosis, rung: Rung, units: dict[str, str]) -> dict[str, Any]:
    return {
        "name": rung.name,
        "question": rung.question,
        "numbers": rung.numbers if rung.is_model else None,
        "errors": {
            row.channel: {"rms": row.errors[rung.name], "unit": units[row.channel]}
            for row in rows_of(diagnosis)
            if rung.name in row.errors
        },
    }
