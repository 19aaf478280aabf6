"""One closed-loop run of a study: what it needs in one value that any process can take, and its figures."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.component import Component
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.error_budget import estimate_coupling_error
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.closed_loop import (
    CORRECTION,
    ELONGATION,
    cell_values,
    remaining_error,
)
from warmlink.orchestration.scenarios.metrics import Series, error_metrics
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.shipped import WARMUP_CELL

DISCRETISATION = "link.discretisation_error"
RECORDED = (ELONGATION, CORRECTION, DISCRETISATION)

WARM_UP_GRID_S = 60.0
"""Time between the moments at which the end of a warm-up is tried, in s."""


@dataclass(frozen=True)
class Case:
    """One run of the warm-up cell.

    Attributes
    ----------
    label : what tells this run from the others of its study, as (controller, duty cycle, mismatch)
    law : component behind the compensator
    values : start values in SI units by instance and variable
    stop_time, step_size : in s
    master : name of the master algorithm
    tolerance : largest error in m that production bears
    with_budget : whether to repeat the run at half the step, which bounds the coupling error
    """

    label: tuple[str, ...]
    law: str
    values: Mapping[str, Mapping[str, Value]]
    stop_time: float
    step_size: float
    master: str
    tolerance: float
    with_budget: bool = False

    @property
    def hours(self) -> float:
        """Closed-loop hours that the run simulates."""
        return self.stop_time / 3600 * (3 if self.with_budget else 1)

    @property
    def digest(self) -> str:
        """Digest of what the run's figures depend on, the FMUs apart."""
        facts = {name: value for name, value in asdict(self).items() if name != "label"}
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Outcome:
    """Figures of one run, in um, s and min.

    Attributes
    ----------
    max_abs_um, p95_abs_um, rms_um, time_to_tolerance_s : as in `ErrorMetrics`; NaN in a run that stopped
    within_tolerance_min : time for which the error is within tolerance
    warm_up_first_min : the same for the best that warming up without compensation could have given
    correction_rate_um_s : fastest change of the correction between two communication points
    discretisation_um : largest estimate that the link makes of its grid's error
    coupling_um : bound of the coupling error of the elongation; None where it was not asked for
    stopped : why the run ended early, None where it did not
    """

    max_abs_um: float
    p95_abs_um: float
    rms_um: float
    time_to_tolerance_s: float | None
    within_tolerance_min: float
    warm_up_first_min: float
    correction_rate_um_s: float
    discretisation_um: float
    coupling_um: float | None = None
    stopped: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; NaN becomes None."""
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(self).items()
        }


def failed(reason: str) -> Outcome:
    """Outcome of a run that gave no figures, and why."""
    nan = math.nan
    return Outcome(nan, nan, nan, None, nan, nan, nan, nan, None, reason)


def case_of(
    scenario: Scenario, controller: Component, label: tuple[str, ...], *, with_budget: bool = False
) -> Case:
    """The run that a scenario describes, with its start values checked.

    Raises
    ------
    InputError
        If the scenario names a parameter, unit or master that does not exist, its step does not
        divide its time, or a component refuses a value.
    """
    algorithm(scenario.master)
    CommunicationPoints.between(0.0, scenario.stop_time, scenario.step_size)
    return Case(
        label=label,
        law=controller.name,
        values=cell_values(scenario, controller),
        stop_time=scenario.stop_time,
        step_size=scenario.step_size,
        master=scenario.master,
        tolerance=scenario.tolerance,
        with_budget=with_budget,
    )


def run_case(case: Case, fmus: Mapping[str, Path], unpacked: Path | None = None) -> Outcome:
    """Run a case; a run that stops early gives its reason instead of figures.

    Parameters
    ----------
    case : the run
    fmus : file of each FMU by the component's name
    unpacked : folder that keeps the unpacked FMUs from run to run
    """
    system = WARMUP_CELL.system(fmus, case.law, case.values)
    result = _simulated(case, system, case.stop_time, case.step_size, unpacked)
    if result.reason is not None:
        return failed(result.reason)
    coupling = _coupling_um(case, system, result, unpacked) if case.with_budget else None
    return figures(result, case.tolerance, coupling)


def figures(result: Result, tolerance: float, coupling_um: float | None = None) -> Outcome:
    """Figures of a complete run whose records hold `RECORDED`."""
    time, error = result.times, remaining_error(result)
    errors = error_metrics(time, error, tolerance)
    rate = np.abs(np.diff(result[CORRECTION])) / np.diff(time)
    return Outcome(
        max_abs_um=errors.max_abs_um,
        p95_abs_um=errors.p95_abs_um,
        rms_um=errors.rms_um,
        time_to_tolerance_s=errors.time_to_tolerance_s,
        within_tolerance_min=_minutes(np.abs(error) <= tolerance, time),
        warm_up_first_min=warm_up_first(time, result[ELONGATION], tolerance),
        correction_rate_um_s=1e6 * float(np.max(rate, initial=0.0)),
        discretisation_um=1e6 * float(np.max(np.abs(result[DISCRETISATION]))),
        coupling_um=coupling_um,
    )


def warm_up_first(time: Series, elongation: Series, tolerance: float) -> float:
    """Minutes within tolerance for who warms up without compensation and then sets the zero once.

    The best moment for the end of the warm-up is taken, on a grid of a minute, as if it had been known
    beforehand: no real warm-up gives more.

    Parameters
    ----------
    time : communication points in s, shape (n,)
    elongation : growth in m at these points, shape (n,)
    tolerance : largest error in m that production bears
    """
    stride = max(1, round(WARM_UP_GRID_S / 6 / float(time[1] - time[0])))
    at, growth = time[::stride], elongation[::stride]
    ends = np.arange(0, at.size, 6)
    best = 0.0
    for end in ends:
        best = max(best, _minutes(np.abs(growth[end:] - growth[end]) <= tolerance, at[end:]))
    return best


def _minutes(good: np.ndarray[Any, np.dtype[np.bool_]], time: Series) -> float:
    """Time in min of the communication steps that begin well."""
    return float(np.sum(np.diff(time)[good[:-1]])) / 60


def _simulated(
    case: Case, system: System, stop_time: float, step_size: float, unpacked: Path | None
) -> Result:
    chosen = algorithm(case.master)
    return simulate(system, stop_time, step_size, chosen, record=RECORDED, balances=(), unpacked=unpacked)


def _coupling_um(case: Case, system: System, result: Result, unpacked: Path | None) -> float | None:
    (bound,) = estimate_coupling_error(
        lambda until, half: _simulated(case, system, until, half, unpacked),
        result,
        case.step_size,
        algorithm(case.master).order,
        (ELONGATION,),
    )
    return 1e6 * bound.largest if math.isfinite(bound.largest) else None
