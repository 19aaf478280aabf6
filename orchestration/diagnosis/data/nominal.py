"""The nominal system that a diagnosis starts from: what is known of it, and of the noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from warmlink.fmus.component import limits
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.rig import rig
from warmlink.orchestration.scenarios.overrides import start_value, to_si
from warmlink.orchestration.scenarios.setup import CELL


def parameters_of(scenario: str) -> dict[str, str]:
    """Values with units, by variable, that a scenario gives for parameters of the cell's motor and link.

    Raises
    ------
    InputError
        There is no such scenario, or it is one of another system.
    """
    loaded = load_scenario(scenario)
    if loaded.setup is not CELL:
        raise InputError(
            f"--scenario {scenario}: is of another system than the warm-up cell; give an experiment (TOML)"
        )
    plant = rig("WarmupCell").parameters
    return {name: str(value) for name, value in loaded.parameters.items() if name in plant}


def with_noise(experiment: Experiment, given: Mapping[str, str]) -> Experiment:
    """Put in the noise of columns or variables, 1 sigma with its unit; raises InputError where it is none."""
    noise = dict(experiment.noise)
    for name, text in given.items():
        variable = next((c.variable for c in experiment.columns if name in (c.name, c.header)), name)
        variable = experiment.rig.columns.get(variable, variable)
        where = f"--noise {name}={text}"
        value = to_si(text, experiment.rig.scalar(variable, where), where, difference=True)
        if not value > 0:
            raise InputError(f"{where}: is not a standard deviation above 0")
        noise[variable] = value
    return replace(experiment, noise=noise)


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
            mine = {
                n.removeprefix(f"{instance}."): v
                for n, v in known.items()
                if experiment.rig.part_of(n) == instance
            }
            try:
                limits.checked(component, instance, mine)
            except InputError as fault:
                raise InputError(f"{run.name}: {fault}") from None
    return experiment
