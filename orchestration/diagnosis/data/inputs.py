"""What is said of an experiment beside its files: parameters, noise, and inputs that nobody logged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.data.experiment import Experiment, noise_of
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.overrides import si_in_range, start_value
from warmlink.orchestration.system.units import ZERO_CELSIUS

OFF = "off"
"""What a pad that is not there is assumed to be."""

_PADS = ("pad_temperature", "pad_power")

_AMBIENT = "ambient_temperature"
"""Surrounds a run, and drives none."""


def of_scenario(scenario: str) -> tuple[str, dict[str, str]]:
    """The machine of a scenario, and values with units by variable, of parameters of its plant.

    InputError is raised if there is no such scenario, or its machine has no single plant.
    """
    loaded = load_scenario(scenario)
    if loaded.machine.program:
        raise InputError(
            f"{argument('scenario', scenario)}: {loaded.machine.name} is driven by programs of its own, and "
            "its runs say so themselves; leave it out"
        )
    machine = loaded.machine.name if loaded.file is None else str(loaded.file)
    plant = rig_of(machine).parameters
    return machine, {name: str(value) for name, value in loaded.parameters.items() if name in plant}


def with_noise(experiment: Experiment, given: Mapping[str, str]) -> Experiment:
    """Put in the noise of columns or variables, 1 sigma with its unit; InputError if it is no noise."""
    noise = dict(experiment.noise)
    for name, text in given.items():
        variable = next((c.variable for c in experiment.columns if name in (c.name, c.header)), name)
        variable = experiment.rig.columns.get(variable, variable)
        noise[variable] = noise_of(experiment.rig, variable, text, f"{argument('noise')} {name}")
    return replace(experiment, noise=noise)


def with_nominal(experiment: Experiment, settings: Mapping[str, str]) -> Experiment:
    """Set parameters of the system for all runs, and check that what is known goes together.

    `settings` are values with units by `instance.variable`, as a caller gives them. InputError is raised
    if there is no such parameter, its unit does not fit, or the system cannot be like that.
    """
    system = experiment.rig
    given = {
        name: start_value(name, text, system.components, argument("parameters"))
        for name, text in settings.items()
    }
    calibrated = {each.variable for each in experiment.calibrated}
    for name, text in settings.items():
        if name not in system.parameters:
            say = argument("assume", {name: text})
            raise InputError(f"{argument('parameters', {name: text})}: is an input; write {say}")
        if name in calibrated:
            raise InputError(
                f"{argument('parameters', {name: text})}: is calibrated; change its start under [calibrate]"
            )
    known, runs = {**experiment.known, **given}, []
    for run in experiment.runs:
        of_run = {name: value for name, value in run.known.items() if name not in given}
        runs.append(replace(run, known=of_run))
        for instance, component in system.components.items():
            all_known = {**known, **of_run}.items()
            mine = {n[len(instance) + 1 :]: v for n, v in all_known if system.part_of(n) == instance}
            try:
                limits.checked(component, instance, mine)
            except InputError as fault:
                raise InputError(f"{run.name}: {fault}") from None
    return replace(experiment, runs=tuple(runs), known=known)


def with_inputs(experiment: Experiment, assumed: Sequence[str] = ()) -> Experiment:
    """Put assumed inputs into the runs that do not have them, and remark on those that are still absent.

    `assumed` are texts `NAME=VALUE` by name of column or input, the value with its unit or in SI; a pad may
    be `off`. InputError is raised where one names no input, contradicts the file or has no such value, and
    where nothing drives a run.
    """
    given = [_assumption(experiment, text) for text in assumed]
    runs = []
    for run in experiment.runs:
        lacking = [each for each in given if not is_given(experiment, run, each[0])]
        constant = {name: np.full(run.time.size, value) for name, value in lacking}
        runs.append(replace(run, inputs={**run.inputs, **constant}))
    experiment = replace(experiment, runs=tuple(runs))
    _refuse_undriven(experiment)
    remarks = [*experiment.remarks, *(remark for run in runs for remark in run.remarks), *_absent(experiment)]
    remarks += _paused(experiment)
    unused = list(dict.fromkeys(header for run in runs for header in run.unused))
    if unused:
        example = next(iter(experiment.rig.measurable), "VARIABLE")
        remarks.append(
            f"not used: {listed(unused)}; say what a column is with {argument('names', {'COLUMN': example})}"
        )
    return replace(experiment, remarks=tuple(remarks))


def _assumption(experiment: Experiment, text: str) -> tuple[str, float]:
    """Input and value in SI; NaN for a pad that is off."""
    name, equals, written = (part.strip() for part in text.partition("="))
    system, where = experiment.rig, argument("assume", {name: written} if equals else name)
    variable = system.columns.get(name, name)
    if not equals:
        raise InputError(f"{where}: no value; write {argument('assume', {name or 'torque': '0'})}")
    if variable not in system.externals:
        names = [system.column_of(each) for group in system.required_inputs for each in group]
        raise InputError(f"{where}: {name} is no input; {instead(name, names)}")
    if all(is_given(experiment, run, variable) for run in experiment.runs):
        raise InputError(f"{where}: every run has this input; leave the assumption out")
    if variable.endswith("pad_temperature") and written == OFF:
        return variable, np.nan
    group = next((group for group in system.required_inputs if variable in group), ())
    others = [] if group[:1] and group[0].endswith(_PADS) else [each for each in group if each != variable]
    for run in experiment.runs:
        if logged := [each for each in others if is_given(experiment, run, each)]:
            told = f"{run.name} has {system.column_of(logged[0])}, and both would count"
            raise InputError(f"{where}: {told}; leave the assumption out")
    return variable, si_in_range(written, system.variables[variable], where)


def is_given(experiment: Experiment, run: Run, *inputs: str) -> bool:
    """Whether a run, or the experiment for all, says what one of some inputs is."""
    system = experiment.rig
    said = {*run.inputs, *run.known, *experiment.known, *(each.variable for each in experiment.calibrated)}
    said |= {name for name in system.externals if name.partition(".")[2] in run.covariates}
    return any(each in said for name in inputs for each in system.fed_with(name))


def _refuse_undriven(experiment: Experiment) -> None:
    driving = [group for group in experiment.rig.required_inputs if not group[0].endswith(_AMBIENT)]
    names = [experiment.rig.column_of(group[0]) for group in driving]
    for run in experiment.runs if driving else ():
        if not any(is_given(experiment, run, *group) for group in driving):
            still = argument("assume", {name: _neutral(experiment.rig, name)[1] for name in names})
            raise InputError(
                f"{run.name}: nothing drives the run: there is no column {' or '.join(names)}; add what was "
                f"logged, or say that the machine stood still: {still}"
            )


def _absent(experiment: Experiment) -> list[str]:
    """Remarks on inputs that nobody logged, with the values they are given."""
    remarks = []
    for group in experiment.rig.required_inputs:
        if without := [run.name for run in experiment.runs if not is_given(experiment, run, *group)]:
            name = experiment.rig.column_of(group[0])
            value, written = _neutral(experiment.rig, name)
            whose = f"{listed(without)}: " if len(experiment.runs) > 1 else ""
            say = argument("assume", {name: written})
            told = f"no {name} column: taken as {value}; give {say} to say so"
            remarks.append(whose + told)
    return remarks


def absent_drives(experiment: Experiment) -> dict[str, str]:
    """Sentences on inputs that make heat by working and that nobody logged in some run, by input."""
    found = {}
    for group in experiment.rig.required_inputs:
        works = not group[0].endswith((_AMBIENT, *_PADS))
        if works and not all(is_given(experiment, run, *group) for run in experiment.runs):
            names = " or ".join(experiment.rig.column_of(each) for each in group)
            name = experiment.rig.column_of(group[0])
            told = f"{names} was not logged and makes no heat in the simulation: log it"
            found[group[0]] = f"{told}, or say that it was 0 ({argument('assume', {name: '0'})})"
    return found


def _paused(experiment: Experiment) -> list[str]:
    """Remarks on pauses of the log in which nobody knows what the machine did."""
    remarks = []
    for run in experiment.runs:
        if run.pauses.size:
            row = max(run.pauses, key=lambda row: run.time[row + 1] - run.time[row])
            begins, ends = run.time[row] / 60, run.time[row + 1] / 60
            whose = f"{run.name}: " if len(experiment.runs) > 1 else ""
            count = f"{run.pauses.size} times, the longest for" if run.pauses.size > 1 else "for"
            remarks.append(
                f"{whose}the log pauses {count} {ends - begins:.4g} min from {begins:.4g} min on: the "
                "machine is taken to go on as in the row before; if it did not, add rows of what it did, "
                "with empty cells for what was not measured"
            )
    return remarks


def _neutral(system: Rig, name: str) -> tuple[str, str]:
    """Value that an absent input is given: in words, and as it is written in an assumption."""
    if name.endswith("pad_temperature"):
        return OFF, OFF
    scalar = system.variables[system.columns.get(name, name)]
    start, unit = float(scalar.start or 0.0), scalar.variable.unit
    if scalar.is_temperature:
        celsius = f"{start - ZERO_CELSIUS:g} degC"
        return celsius, celsius
    return f"{start:g}" if unit == "1" else f"{start:g} {unit}", f"{start:g}"
