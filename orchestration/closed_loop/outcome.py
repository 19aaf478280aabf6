"""One scenario in closed loop: how far off the tool point was with a controller and without one."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.names import several
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.metrics import (
    Conduct,
    ErrorMetrics,
    conduct,
    error_metrics,
    reduction_percent,
    shown_percent,
)
from warmlink.orchestration.console import Answer, remark
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.fmu_store import FmuKind, FmuStore, store
from warmlink.orchestration.master.algorithms import ERROR_CONTROLLED
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.error_budget import attempted
from warmlink.orchestration.master.recording.result import RecordTable, Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.mismatch import together
from warmlink.orchestration.scenarios.plausible import Declared, within_bands
from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO, NO_CONTROLLER, Scenario, changed
from warmlink.orchestration.simulation import in_turns, largest_step
from warmlink.orchestration.written.quantities import positive, refuse_bare

if TYPE_CHECKING:
    import pandas

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


@dataclass(frozen=True, repr=False)
class ClosedLoop(Answer):
    """Result of a scenario, with a controller and without one.

    A correction has no effect on the growth that it corrects, so that one run gives both errors. A second one
    with half the communication step bounds the coupling error, None if one of the two ended early;
    `cut_short` says why. `advice` is what to do if the controller was designed for another system; `ideal`,
    whether cell and thermometers are exactly those that it was designed for.
    """

    scenario: Scenario
    fmus: FmuKind
    result: Result
    coupling_error_um: float | None
    cut_short: str | None
    advice: str | None
    ideal: bool
    wall_seconds: float

    @property
    def controller(self) -> str:
        """Name of the controller."""
        return self.scenario.controller.name

    @property
    def time(self) -> Array:
        """Communication points in s."""
        return self.result.times

    @property
    def error(self) -> Array:
        """Error of the tool point in m at the communication points."""
        return np.asarray(self.scenario.machine.roles.score.value(self.result.__getitem__))

    @property
    def uncompensated_error(self) -> Array:
        """Error of the tool point in m at the communication points, without a controller."""
        return np.asarray(self.scenario.machine.roles.uncompensated.value(self.result.__getitem__))

    @cached_property
    def uncompensated(self) -> ErrorMetrics:
        """Figures without a controller."""
        return error_metrics(self.time, self.uncompensated_error, self.scenario.tolerance)

    @cached_property
    def metrics(self) -> ErrorMetrics:
        """Figures with the controller."""
        return error_metrics(self.time, self.error, self.scenario.tolerance)

    @cached_property
    def conduct(self) -> Conduct:
        """What the controllers say of their error, and how they move the tool point."""
        machine, found = self.scenario.machine, self.result
        ready, corrections = (
            [found[name] for name in names] for names in (machine.claims, machine.corrections)
        )
        return conduct(self.time, self.error, ready, corrections, self.scenario.tolerance)

    @property
    def discretisation_error_um(self) -> float:
        """Largest of the links' estimates of the error due to their grids, in um."""
        return discretisation_um(self.result)

    @property
    def reduction_percent(self) -> float | None:
        """Share of the largest error that the controller removes, in percent; None if that means nothing."""
        budget = (self.coupling_error_um or 0.0) + self.discretisation_error_um
        return reduction_percent(self.uncompensated, self.metrics, budget)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader should know before trusting the figures."""
        flattering = self.ideal and self.metrics.max_abs_um < 1e5 * self.scenario.tolerance
        most, bound = self.scenario.coupling_tolerance, self.coupling_error_um
        scenario = self.scenario
        asked = *scenario.remarks, *together(scenario.differences), *scenario.duty.remarks
        told = [*asked, *self.result.remarks, self.advice, IDEAL if flattering else None]
        if most is not None and bound is not None and bound > 1e6 * most:
            told.append(f"the coupling error is not within the tolerance of {1e6 * most:g} µm; allow more")
        return tuple(each for each in told if each)

    @property
    def table(self) -> RecordTable:
        """Every recorded variable, and the tool point's `error` and `uncompensated_error` in m."""
        table = self.result.table
        errors = {"error": self.error, "uncompensated_error": self.uncompensated_error}
        return replace(
            table,
            names=(*table.names, *errors),
            units={**table.units, **dict.fromkeys(errors, "m")},
            values=np.column_stack([table.values, *errors.values()]),
        )

    def to_frame(self) -> pandas.DataFrame:
        """Time series of every recorded variable and of the tool point's error, with units in their names."""
        return self.table.to_frame()

    def summary(self) -> str:
        """The result in a few lines."""
        before, after, removed = self.uncompensated, self.metrics, self.reduction_percent
        coupling = "unknown" if self.coupling_error_um is None else f"±{self.coupling_error_um:.2g} µm"
        within = f"within ±{1e6 * self.scenario.tolerance:g} µm from"
        gain = (
            ""
            if removed is None
            else f"{shown_percent(abs(removed))} {'removed' if removed >= 0 else 'worse'}"
        )
        rows = [
            ("", NO_CONTROLLER, self.controller, ""),
            ("largest error", _micrometres(before.max_abs_um), _micrometres(after.max_abs_um), gain),
            (within, _time_to_tolerance(before), _time_to_tolerance(after), ""),
            ("coupling error", coupling, coupling, ""),
        ]
        scenario, done, whole = self.scenario, float(self.time[-1]), _duration(self.scenario.stop_time)
        lasted = whole if done >= scenario.stop_time else f"{_duration(done)} of {whole}"
        how = lasted, f"{self.fmus} FMUs", f"{scenario.step_size:g} s steps", scenario.master
        head = scenario.name, *scenario.mismatches, *how
        width = max(15, len(self.controller) + 3)
        lines = [f"{a:<20}{b:>14}{c:>{width}}     {d}".rstrip() for a, b, c, d in rows]
        return "\n".join([" · ".join(head), *lines, *(f"note  {text}" for text in self.remarks)])

    def to_dict(self) -> dict[str, Any]:
        """Content of `metrics.json`."""
        scenario, detail = self.scenario, self.scenario.machine.detail
        more = {} if detail is None else detail(self.result)
        coupling, discretisation = self.coupling_error_um, self.discretisation_error_um
        return {
            "scenario": scenario.name,
            "system": scenario.machine.name,
            "controller": self.controller,
            "mismatches": list(scenario.mismatches),
            "fmus": self.fmus,
            "stop_time_s": scenario.stop_time,
            "communication_step_size_s": scenario.step_size,
            "master": scenario.master,
            "tolerance_um": 1e6 * scenario.tolerance,
            "uncompensated": {**asdict(self.uncompensated), **more.get("uncompensated", {})},
            "compensated": {**asdict(self.metrics), **asdict(self.conduct), **more.get("compensated", {})},
            "reduction_percent": self.reduction_percent,
            "heat_balance_error_J": sum(audit.total for audit in self.result.audits),
            "error_budget_um": {"coupling": coupling, "discretisation": discretisation},
            "simulated_s": float(self.time[-1]),
            "stopped": self.cut_short,
            "remarks": list(self.remarks),
            "wall_seconds": self.wall_seconds,
            **({"statistics": self.result.statistics.to_dict()} if self.result.statistics.slaves else {}),
        }


def _micrometres(value: float) -> str:
    """An error as the table shows it; a law of one's own may make it larger than any machine."""
    return f"{value:.1f} µm" if value < 1e6 else f"{value:.3g} µm"


def _time_to_tolerance(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else _duration(metrics.time_to_tolerance_s)


def _duration(seconds: float) -> str:
    if seconds >= 3600:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 60 else f"{seconds:.3g} s"


IDEAL = (
    "the thermometers are perfect and the cell is exactly the one that the law was designed for, as no real "
    "cell is; add the mismatch thermal_high or noisy_sensors, for example"
)


def discretisation_um(result: Result) -> float:
    """Largest of the links' estimates of the error due to their grids, in um; 0 if there is no estimate."""
    estimates = [result[name] for name in result.table.names if name.endswith(".discretisation_error")]
    return 1e6 * float(np.max(np.abs(estimates), initial=0.0))


def run_scenario(
    scenario: Scenario, fmus: FmuStore, progress: Progress = lambda share: None, statistics: bool = False
) -> ClosedLoop:
    """Run a scenario with its controller, and once more with half the step, with the FMUs of a store.

    Ctrl-C ends the run in order: what was computed up to there is kept. `statistics` counts and times the
    calls of each FMU in the first run. Raises InputError if a parameter, unit or master does not exist or a
    component refuses a value, and SlaveError if the run failed before its first communication point.
    """
    began = time.perf_counter()
    system, plant = scenario.system(scenario.files(fmus)), scenario.machine.roles.plant
    told, ideal = design_check(scenario)
    most, ran = scenario.coupling_tolerance, scenario
    if most is not None:
        ran = replace(scenario, step_size=largest_step(system, scenario.stop_time, scenario.step_size))
    chosen = algorithm(scenario.master)

    with temporary_folder() as home:
        whole = partial(simulate, system, ran.stop_time, ran.step_size, unpacked=home, statistics=statistics)
        half = partial(simulate, system, ran.stop_time, ran.step_size / 2, unpacked=home, record=plant)
        turns = in_turns(whole, partial(half, check_stability=False), progress)
        found = attempted(chosen, {} if most is None else dict.fromkeys(plant, most), plant, turns)
    if found.algorithm is not chosen:
        ran = replace(ran, master=ERROR_CONTROLLED)
    known = Declared(scenario.declared, scenario.machine.fed, scenario.values())
    found = found.looked_at(lambda result: within_bands(result, known))
    largest, took = max(found.bounds.values(), default=np.inf), time.perf_counter() - began
    coupling = 1e6 * largest if np.isfinite(largest) else None
    stopped = found.result.reason or found.stopped  # an end that an FMU asks for is too early here
    return ClosedLoop(ran, fmus.kind, found.result, coupling, stopped, told, ideal, took)


def run(
    scenario: str | Path | Scenario = DEFAULT_SCENARIO,
    controller: str | None = None,
    *,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    mismatches: Sequence[str | Path] | str | Path = (),
    step: str | float | None = None,
    stop: str | float | None = None,
    master: str | None = None,
    tolerance: str | float | None = None,
    fmus: str | None = None,
    statistics: bool = False,
) -> ClosedLoop:
    """Run a scenario with a controller and without one, and compute how far off the tool point is.

    Parameters
    ----------
    scenario : name of a shipped scenario, or a TOML or CSV file; what is not given below stays as it says
    controller : name of a shipped controller, or a law of your own, as `my_law.py:MyLaw`
    parameters : start values, `"2 W/K"` under `motor.joint_conductance`, or the path of a parameter set (SSV)
    mismatches : names or files; several mismatches add up
    step, stop : communication step size and stop time, `"1 h"` or in s
    master : name of the algorithm
    tolerance : largest coupling error, `"0.1 um"` or in m, for which the steps become smaller where needed
    fmus : native (C) or python; by default native if there is a C compiler
    statistics : count and time the calls of each FMU

    Raises
    ------
    InputError
        If a name does not exist, or a value is refused.
    SlaveError
        If the run failed before its first communication point.

    Examples
    --------
    >>> outcome = wl.run("stop_and_go", "lag", mismatches=["noisy_sensors"])
    >>> print(outcome)
    >>> outcome.to_frame()["error [m]"].abs().max()
    """
    found = scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))
    if isinstance(tolerance, str):
        refuse_bare(tolerance, "m", argument("tolerance"))
    most = found.coupling_tolerance if tolerance is None else positive(tolerance, "m", argument("tolerance"))
    asked = replace(
        changed(found, controller, parameters, several(mismatches)),
        duty=found.duty if stop is None else found.duty.until(positive(stop, "s", argument("stop"))),
        step_size=found.step_size if step is None else positive(step, "s", argument("step")),
        master=master or found.master,
        coupling_tolerance=most,
    )
    built = store(fmus, sorted(asked.kinds), remark)
    with progress_bar(asked.title) as progress:
        return run_scenario(asked, built, progress, statistics)
