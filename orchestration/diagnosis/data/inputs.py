"""Inputs that drive each run: logged, assumed, or absent, which is remarked on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.rig import Rig
from warmlink.orchestration.scenarios.overrides import to_si
from warmlink.orchestration.system.units import ZERO_CELSIUS

OFF = "off"
"""What a pad that is not there is assumed to be."""

_AMBIENT = "ambient_temperature"
"""Surrounds a run, and drives none."""

_MOST_NAMED = 6
"""Columns that a remark names."""


def with_inputs(experiment: Experiment, assumed: Sequence[str] = ()) -> Experiment:
    """Put assumed inputs into the runs that do not have them, and remark on those that are still absent.

    Parameters
    ----------
    experiment : as it was read
    assumed : `NAME=VALUE` by name of column or input, the value with its unit or in SI; a pad may be `off`

    Raises
    ------
    InputError
        An assumption names no input, contradicts the file or has no such value; nothing drives a run.
    """
    given = [_assumption(experiment, text) for text in assumed]
    runs = []
    for run in experiment.runs:
        lacking = {name: value for name, value in given if not _is_given(experiment, run, name)}
        constant = {name: np.full(run.time.size, value) for name, value in lacking.items()}
        runs.append(replace(run, inputs={**run.inputs, **constant}))
    experiment = replace(experiment, runs=tuple(runs))
    _refuse_undriven(experiment)
    cells = [remark for run in experiment.runs for remark in run.remarks]
    remarks = (*experiment.remarks, *cells, *_absent(experiment), *_unused(experiment))
    return replace(experiment, remarks=remarks)


def _assumption(experiment: Experiment, text: str) -> tuple[str, float]:
    """Input and value in SI; NaN for a pad that is off."""
    name, equals, written = (part.strip() for part in text.partition("="))
    rig = experiment.rig
    variable = rig.columns.get(name, name)
    where = f"--assume {text}"
    if not equals:
        raise InputError(f"{where}: no value; write --assume {name or 'torque'}=0")
    if variable not in rig.externals:
        raise InputError(f"{where}: {name} is no input; {instead(name, _names(rig))}")
    if all(_is_given(experiment, run, variable) for run in experiment.runs):
        raise InputError(f"{where}: every run has this input; leave the assumption out")
    if variable.endswith("pad_temperature") and written == OFF:
        return variable, np.nan
    return variable, to_si(written, rig.variables[variable], where)


def _names(rig: Rig) -> list[str]:
    """Inputs that a run should have, as a user calls them."""
    return [rig.column_of(name) for group in rig.driven_by for name in group]


def _is_given(experiment: Experiment, run: Run, name: str) -> bool:
    """Whether a run, or the experiment for all, says what an input is."""
    said: Mapping[str, object] = {**run.inputs, **run.known, **experiment.known}
    calibrated = {each.variable for each in experiment.calibrated}
    covariates = {n for n in experiment.rig.externals if n.partition(".")[2] in run.covariates}
    return any(n in said or n in calibrated or n in covariates for n in experiment.rig.fed_with(name))


def _refuse_undriven(experiment: Experiment) -> None:
    driving = [group for group in experiment.rig.driven_by if not group[0].endswith(_AMBIENT)]
    for run in experiment.runs if driving else ():
        if not any(_is_given(experiment, run, name) for group in driving for name in group):
            names = [experiment.rig.column_of(group[0]) for group in driving]
            still = " ".join(f"--assume {name}={_neutral(experiment.rig, name)[1]}" for name in names)
            raise InputError(
                f"{run.name}: nothing drives the run: there is no column {' or '.join(names)}; add what was "
                f"logged, or say that the machine stood still: {still}"
            )


def _absent(experiment: Experiment) -> list[str]:
    """Remarks on inputs that nobody logged, with the values they are given."""
    rig = experiment.rig
    remarks = []
    for group in rig.driven_by:
        without = [r.name for r in experiment.runs if not any(_is_given(experiment, r, n) for n in group)]
        if without:
            name = rig.column_of(group[0])
            value, option = _neutral(rig, name)
            whose = f"{_few(without)}: " if len(experiment.runs) > 1 else ""
            remarks.append(
                f"{whose}no {name} column: taken as {value}; give --assume {name}={option} to say so"
            )
    return remarks


def _neutral(rig: Rig, name: str) -> tuple[str, str]:
    """Value that an absent input is given: in words, and as an argument of `--assume`."""
    if name.endswith("pad_temperature"):
        return OFF, OFF
    scalar = rig.variables[rig.columns.get(name, name)]
    start = float(scalar.start or 0.0)
    if scalar.is_temperature:
        return f"{start - ZERO_CELSIUS:g} degC", f'"{start - ZERO_CELSIUS:g} degC"'
    unit = "" if scalar.variable.unit == "1" else f" {scalar.variable.unit}"
    return f"{start:g}{unit}", f"{start:g}"


def _unused(experiment: Experiment) -> list[str]:
    headers = list(dict.fromkeys(header for run in experiment.runs for header in run.unused))
    if not headers:
        return []
    return [f'not used: {_few(headers)}; say what a column is with --map "COLUMN=base_temperature"']


def _few(names: Sequence[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
