"""What each cause of the catalogue may free in an experiment: names, and the variables that they free."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.rig import AT_SENSOR, Rig
from warmlink.orchestration.diagnosis.model.equations import OFFSET, PLACE, SCALE
from warmlink.orchestration.diagnosis.model.instruments import channel_of, logger_of

Named = tuple[str, tuple[str, ...]]
"""Name of a candidate, with its channel after a colon, and the variables that it frees."""

INNER = ("plant", "input", "place")
"""Kinds of causes that change the simulation itself, not only what is read from it."""


def freed_by(cause: Cause, experiment: Experiment, names: Mapping[str, str]) -> Iterable[Named]:
    """Candidates of a cause.

    Parameters
    ----------
    cause : of the catalogue
    experiment : what was measured
    names : column by output that was measured
    """
    rig = experiment.rig
    if cause.kind == "plant":
        covered = cause.covariate is None or any(
            cause.covariate in run.covariates or any(n.endswith(cause.covariate) for n in run.inputs)
            for run in experiment.runs
        )
        variables = tuple(v for v in cause.frees if v in rig.parameters)
        if variables and covered:
            yield cause.name, variables
    elif cause.kind == "input":
        yield from _inputs(cause, experiment)
    elif cause.kind == "record":
        yield cause.name, cause.frees
        groups = dict.fromkeys(logger_of(rig, variable) for variable in names)
        if cause.grouped and len(groups) > 1:
            yield from ((f"{cause.name}:{group}", (f"{cause.frees[0]}:{group}",)) for group in groups)
    elif cause.kind != "simulation":
        for variable, name in names.items():
            freed = _of_instrument(cause, rig, variable)
            if freed is not None:
                yield (cause.name if cause.kind == "camera" else f"{cause.name}:{name}"), (freed,)


def _inputs(cause: Cause, experiment: Experiment) -> Iterable[Named]:
    """Logged inputs; the ambient has causes of its own, a temperature has no scale, a switch neither."""
    rig, scales = experiment.rig, cause.frees[0] == SCALE
    for name in dict.fromkeys(name for run in experiment.runs for name in run.inputs):
        unit = rig.unit(name)
        if not (
            rig.variables[name].is_discrete
            or name.endswith(".ambient_temperature")
            or unit == "1"
            or (unit == "K" and scales)
        ):
            yield f"{cause.name}:{rig.column_of(name)}", (f"{SCALE if scales else OFFSET}:{name}",)


def _of_instrument(cause: Cause, rig: Rig, variable: str) -> str | None:
    """Variable that a cause frees of the instrument that reads an output; None where it has no such one."""
    if cause.kind == "place":
        own, _, element = variable.partition("[")
        at = AT_SENSOR.get(variable, element.rstrip("]") if own == "link.sensor_temperature" else None)
        return None if at is None else f"{PLACE}:link.sensor_position[{at}]"
    channel = channel_of(rig, variable)
    if channel is None or (cause.kind != "reading" and (cause.kind == "camera") != channel.is_camera):
        return None
    return channel.variable(cause.frees[0])
