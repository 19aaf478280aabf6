"""Which variables of a system each cause of the catalogue frees: one candidate for each part or channel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.causes.parts import freed_in_parts
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.model.instruments import CLOCK, channel_of, logger_of
from warmlink.orchestration.machine.rig import OFFSET, PLACE, SCALE, Rig

Named = Iterable[tuple[str, tuple[str, ...]]]
"""Names of candidates, and the variables that each frees."""


def freed_by(cause: Cause, experiment: Experiment, names: Mapping[str, str]) -> Named:
    """Names of a cause's candidates, the channel after a colon, and the variables that each frees.

    `names` are the columns by output that was measured.
    """
    rig = experiment.rig
    if cause.kind == "record" or (cause.kind == "plant" and cause.declared):
        yield cause.name, cause.frees
        groups = dict.fromkeys(logger_of(rig, variable) for variable in names)
        if cause.grouped and len(groups) > 1:
            yield from ((f"{cause.name}:{group}", (f"{cause.frees[0]}:{group}",)) for group in groups)
    elif cause.kind == "plant":
        yield from freed_in_parts(cause, rig, lambda needed: _logged(needed, experiment)).items()
    elif cause.kind == "input":
        yield from _inputs(cause, experiment)
    elif cause.kind == "declared reading":
        output, fault = cause.frees
        slot = channel_of(rig, output).variable("stem_conduction" if fault == "stem" else fault)
        yield cause.name, (f"{CLOCK}:{output}" if fault == "clock" else slot,)
    elif cause.kind != "simulation":
        cameras = [variable for variable in names if channel_of(rig, variable).is_camera]
        for variable, name in names.items():
            freed = _of_instrument(cause, rig, variable)
            if freed is not None:
                only = cause.kind == "camera" and len(cameras) == 1
                yield (cause.name if only else f"{cause.name}:{name}"), (freed,)


def _logged(needed: str, experiment: Experiment) -> bool:
    """Whether a column stands for an input, by its full name, that a cause needs."""
    name = needed.rpartition(".")[2]
    return any(name in run.covariates or needed in run.inputs for run in experiment.runs)


def _inputs(cause: Cause, experiment: Experiment) -> Named:
    """Logged inputs that a cause scales or shifts.

    No switch is; nor is the ambient temperature, which has causes of its own; and no temperature is scaled.
    """
    rig, scales = experiment.rig, cause.frees[0] == SCALE
    for name in dict.fromkeys(name for run in experiment.runs for name in run.inputs):
        unit = rig.unit(name)
        if not (
            rig.variables[name].is_discrete
            or (name.endswith(".ambient_temperature") and rig.part_of(name) not in rig.foreign)
            or unit == "1"
            or (unit == "K" and scales)
        ):
            yield f"{cause.name}:{rig.column_of(name)}", (f"{SCALE if scales else OFFSET}:{name}",)


def _of_instrument(cause: Cause, rig: Rig, variable: str) -> str | None:
    """Variable that a cause frees of the instrument that reads an output; None if it has none."""
    if cause.kind == "place":
        at = None if rig.in_loop else rig.on_link(variable)
        place = None if at is None else f"{at[0]}.sensor_position[{at[1]}]"
        return f"{PLACE}:{place}" if place in rig.parameters else None
    channel = channel_of(rig, variable)
    units = {"camera": ("m",), "reading": ("K", "m")}.get(cause.kind, ("K",))
    return channel.variable(cause.frees[0]) if channel.unit in units else None
