"""The extended model: its values and its files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warmlink.orchestration.catalogue import components, controller
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.delivered import Delivery
from warmlink.orchestration.diagnosis.ladder.wired import with_predictor, with_remainder
from warmlink.orchestration.machine.heat_paths import extended
from warmlink.orchestration.machine.rig import Rig

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore


def extended_values(problem: Problem, fit: Fit) -> dict[str, float]:
    """Values in SI, by full variable name, of what is known of the system or was fitted.

    Where runs differ, the values are those of the first fitted run. What belongs to the log and its clock is
    no part of a model, and an input that a wire feeds takes no value.
    """
    run = problem.fitted_runs[0]
    values = problem.values(run, fit.freed, fit.theta)
    known = dict(problem.known(problem.experiment.runs[run]))
    for freed in fit.freed:
        if run in freed.runs:
            known |= {problem.slots[i]: float(values[i]) for i in freed.slots}
    rig = problem.experiment.rig
    writable = set(rig.variables)
    for instance, kind in rig.machine.parts.items():
        declared = components().get(kind)
        writable |= {f"{instance}.{scalar.name}" for scalar in declared.scalars()} if declared else set()
    writable -= rig.machine.fed.keys()
    return {name: float(v) for name, v in known.items() if name in writable and np.isfinite(v)}


def kinds_needed(rig: Rig) -> list[str]:
    """Names of the components whose FMUs the extended model is written with; none for an SSP of one's own."""
    none = controller("none").name
    return [] if rig.system else sorted(set(rig.machine.parts_with(none).values()))


def write_ssp_of(
    rig: Rig, values: Mapping[str, float], path: Path, store: FmuStore, delivery: Delivery | None = None
) -> None:
    """Write the system with the extended values bound, and what was found wired in.

    What was found is heat paths, and of a delivery its remainder and its plain fits. InputError if these need
    a compiler and there is none.
    """
    from warmlink.orchestration.system.write import write_ssp

    system = extended(rig, values, store)
    if delivery is not None and delivery.remainder is not None:
        system = with_remainder(system, delivery.remainder, store)
    if delivery is not None and delivery.predictor is not None:
        system = with_predictor(system, delivery.predictor)
    write_ssp(system, path)
