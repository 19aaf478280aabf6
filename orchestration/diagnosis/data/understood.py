"""What was understood of files of measurements: `diagnose --check` shows it and stops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run

_GAP = 3.0
"""Usual spacings of the rows from which on a pause counts as a gap."""


def understood(experiment: Experiment) -> dict[str, Any]:
    """What each run was understood to be, with what is assumed and passed over, for people and as JSON.

    Of an experiment as `with_inputs` gives it: `system`; `runs`, each with its `form`, `rows`,
    `duration_s`, `spacing_s`, `gaps`, `not_used` and `columns` (name, variable, unit, where the unit
    stands, filled cells, least and largest value); `known` in SI; `remarks`.
    """
    return {
        "system": experiment.rig.name,
        "runs": [_run(run) for run in experiment.runs],
        "known": dict(experiment.known),
        "remarks": list(experiment.remarks),
    }


def _run(run: Run) -> dict[str, Any]:
    spacing = np.diff(run.time)
    usual = float(np.median(spacing))
    gaps = np.flatnonzero(spacing > _GAP * usual)
    return {
        "name": run.name,
        "form": run.form,
        "rows": int(run.time.size),
        "duration_s": float(run.time[-1]),
        "spacing_s": usual,
        "gaps": [{"at_s": float(run.time[i]), "lasts_s": float(spacing[i])} for i in gaps],
        "held_out": run.heldout,
        "columns": [
            {
                "column": column.header,
                "variable": column.variable,
                "unit": column.unit,
                "unit_from": column.source,
                "filled": column.filled,
                "cells": column.rows,
                "least": None if np.isnan(column.low) else column.low,
                "largest": None if np.isnan(column.high) else column.high,
            }
            for column in run.columns
        ],
        "not_used": list(run.unused),
    }


def in_words(run: Mapping[str, Any]) -> str:
    """One run of `understood` in two lines, its columns aside."""
    gaps, minutes = run["gaps"], run["duration_s"] / 60
    pauses = "no gaps"
    if gaps:
        longest = max(gaps, key=lambda gap: gap["lasts_s"])
        pauses = f"{len(gaps)} gaps, the longest {longest['lasts_s']:g} s from {longest['at_s']:g} s on"
    rows = f"{run['rows']} rows over {minutes:.4g} min, one every {run['spacing_s']:g} s, {pauses}"
    return f"{run['name']}: {run['form']}\n{rows}{', held out' if run['held_out'] else ''}"


def table(run: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """A run's columns as rows of text: column, variable, unit, cells filled, least and largest value."""
    rows = []
    for column in run["columns"]:
        ends = [f"{v:.5g}" if v is not None else "" for v in (column["least"], column["largest"])]
        filled = f"{column['filled']} of {column['cells']}"
        unit = f"{column['unit']} ({column['unit_from']})"
        rows.append((column["column"], column["variable"], unit, filled, *ends))
    return rows
