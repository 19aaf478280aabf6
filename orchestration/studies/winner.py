"""The winning start values as parameter sets (SSV) that any SSP tool reads."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.studies.study import Point, Study
from warmlink.orchestration.system.shipped import COMPENSATOR
from warmlink.orchestration.system.ssp.parameter_values import Parameter, write_ssv
from warmlink.orchestration.system.units import parse_unit


def write_winner(study: Study, point: Point, folder: Path) -> list[Path]:
    """Write `winner.ssv` for the compensator, and `winner-INSTANCE.ssv` for what else was varied."""
    sets: dict[str, dict[str, Parameter]] = {}
    for axis in study.axes:
        instance, _, variable = axis.name.partition(".")
        value = point[axis.name]
        held = (
            Parameter(variable, "Integer", int(value))
            if axis.integer
            else Parameter(variable, "Real", value, None if axis.unit == "1" else parse_unit(axis.unit))
        )
        sets.setdefault(instance, {})[variable] = held
    paths = []
    for instance, values in sets.items():
        path = folder / ("winner.ssv" if instance == COMPENSATOR else f"winner-{instance}.ssv")
        write_ssv(values, path, f"{study.name}, {instance}")
        paths.append(path)
    return paths
