"""The nominal system that a diagnosis starts from: what is known of it, and other start values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.scenarios.overrides import start_value


def with_nominal(experiment: Experiment, settings: Mapping[str, str]) -> Experiment:
    """Set parameters of the system for all runs, and check that what is known goes together.

    Parameters
    ----------
    experiment : as it was read
    settings : values with units by `instance.variable`, as `--set` gives them

    Raises
    ------
    InputError
        There is no such parameter, its unit does not fit, or the system cannot be like that.
    """
    components = experiment.rig.components
    given = {name: start_value(name, text, components, "--set") for name, text in settings.items()}
    calibrated = {each.variable for each in experiment.calibrated}
    for name, text in settings.items():
        if name not in experiment.rig.parameters:
            raise InputError(f"--set {name}={text}: is an input; write --assume {name}={text}")
        if name in calibrated:
            raise InputError(f"--set {name}={text}: is calibrated; change its start under [calibrate]")
    runs = tuple(
        replace(run, known={n: v for n, v in run.known.items() if n not in given}) for run in experiment.runs
    )
    experiment = replace(experiment, runs=runs, known={**experiment.known, **given})
    for run in runs:
        known = {**experiment.known, **run.known}
        for instance, component in components.items():
            starts = {
                name: experiment.rig.variables[f"{instance}.{name}"].start for name in component.p.names
            }
            values = [float(known.get(f"{instance}.{name}", start or 0.0)) for name, start in starts.items()]
            for sentence in limits.problems(component, instance, values):
                raise InputError(f"{run.name}: {sentence}")
    return experiment
