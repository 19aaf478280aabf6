"""The extended model as files that run as they are: a parameter set, and the shipped system with it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warmlink.orchestration.catalogue import components, controller
from warmlink.orchestration.diagnosis.data.rig import Rig
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore


def extended_values(problem: Problem, fit: Fit) -> dict[str, float]:
    """Values in SI, by full variable name, of everything that differs from the nominal system.

    Where runs differ, the values are those of the first fitted run. What belongs to the log and its clock is
    no part of a model.
    """
    run = problem.fitted_runs[0]
    values = problem.values(run, fit.freed, fit.theta)
    known = dict(problem.known(problem.experiment.runs[run]))
    for freed in fit.freed:
        if run in freed.runs:
            known |= {problem.slots[i]: float(values[i]) for i in freed.slots}
    return {name: float(v) for name, v in known.items() if _is_ours(problem, name) and np.isfinite(v)}


def _is_ours(problem: Problem, name: str) -> bool:
    """Whether a component of the system has the variable."""
    rig = problem.experiment.rig
    instance = rig.part_of(name)
    known = components().get(rig.blueprint.components.get(instance, ""))
    return name in rig.variables or (
        known is not None and any(f"{instance}.{scalar.name}" == name for scalar in known.scalars())
    )


def write_ssp_of(rig: Rig, values: Mapping[str, float], path: Path, store: FmuStore) -> None:
    """Write the system with the extended values bound, and the heat paths that were found wired in."""
    from warmlink.orchestration.system.write import write_ssp

    if rig.own is not None:
        write_ssp(rig.own.extended(values), path)
        return
    none = controller("none").name
    by_instance: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        instance, _, variable = name.partition(".")
        if instance in rig.blueprint.components:
            by_instance.setdefault(instance, {})[variable] = value
    files = store.files(rig.blueprint.components_with(none).values())
    write_ssp(rig.blueprint.system(files, none, by_instance), path)
