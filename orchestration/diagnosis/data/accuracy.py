"""The error that matters to whoever asks: below it a model is good enough, however small the noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.diagnosis.data.experiment import Experiment, noise_of


def with_accuracy(experiment: Experiment, given: Sequence[str]) -> Experiment:
    """Put in the error that matters, of every column that has the quantity, or of one.

    Parameters
    ----------
    experiment : as it was read
    given : texts `0.5 K`, or `tip_temperature=0.5 K` by the name of a column or variable

    Raises
    ------
    InputError
        There is no such column, or a value is not above 0, or no column has its quantity.
    """
    accuracy = dict(experiment.accuracy)
    for text in given:
        name, named, value = (part.strip() for part in text.rpartition("="))
        if named:
            variable = next((c.variable for c in experiment.columns if name in (c.name, c.header)), name)
            variable = experiment.rig.columns.get(variable, variable)
            _refuse_unmeasured(experiment, variable, f"{argument('accuracy')} {name}")
            where = f"{argument('accuracy')} {name}"
            accuracy[variable] = noise_of(experiment.rig, variable, value, where, "an error")
        else:
            accuracy |= _of_all(experiment, value)
    told = _judged_by_noise(experiment, accuracy)
    return replace(experiment, accuracy=accuracy, remarks=(*experiment.remarks, *told))


def _judged_by_noise(experiment: Experiment, accuracy: Mapping[str, float]) -> tuple[str, ...]:
    """A remark on columns for which nobody said which error matters, where it is said of others."""
    names = [column.name for column in experiment.columns if column.variable not in accuracy]
    if not names or not accuracy:
        return ()
    unit = next(column.unit for column in experiment.columns if column.name == names[0])
    usual = {"degC": "0.5 K", "um": "2 um"}.get(unit, f"1 {unit}")
    say = argument("accuracy", {names[0]: usual})
    return (f"which error matters is not said of {listed(names)}, so that noise judges it; give {say}",)


def _refuse_unmeasured(experiment: Experiment, variable: str, where: str) -> None:
    names = [column.name for column in experiment.columns]
    if variable not in [column.variable for column in experiment.columns]:
        raise InputError(f"{where}: is not measured; name one of {listed(names)}")


def _of_all(experiment: Experiment, text: str) -> Mapping[str, float]:
    """The error that matters in every column whose quantity fits the text."""
    found, fault = {}, None
    for column in experiment.columns:
        try:
            where = argument("accuracy", text)
            found[column.variable] = noise_of(experiment.rig, column.variable, text, where, "an error")
        except InputError as said:
            fault = fault or said
    if not found and fault is not None:
        raise fault
    return found
