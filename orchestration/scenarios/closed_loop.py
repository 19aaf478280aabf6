"""One scenario in closed loop: how far off the cell was with a controller, and how far without."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from warmlink.fmus.packaging.component import Component
from warmlink.orchestration import catalogue
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.master.algorithms import algorithm
from warmlink.orchestration.master.error_budget import coupling_error
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slave import SlaveError
from warmlink.orchestration.own_law import OwnLaw
from warmlink.orchestration.scenarios.belief import advice, is_ideal
from warmlink.orchestration.scenarios.extent import check_extent
from warmlink.orchestration.scenarios.metrics import ErrorMetrics, Series, error_metrics, reduction_percent
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.shipped import COMPENSATOR, WARMUP_CELL

ELONGATION = "link.elongation"
CORRECTION = "compensator.correction"

NO_CONTROLLER = "none"

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


@dataclass(frozen=True)
class ClosedLoop:
    """What a scenario came to, with a controller and without.

    No controller acts on motor or link, so the elongation of the one run is also the error without any.

    Attributes
    ----------
    controller : its name
    result : the run
    coupling_error_um : bound on what the finite communication step costs the elongation, by a run with half
        of it; None where one of the two stopped early
    cut_short : why a run ended early, None where both came to their end
    advice : what to do where the controller was made for another cell, None where it was not
    ideal : whether the cell and its thermometers are just what the controller was designed for
    """

    scenario: Scenario
    controller: str
    fmus: FmuKind
    result: Result
    coupling_error_um: float | None
    cut_short: str | None
    advice: str | None
    ideal: bool
    wall_seconds: float

    @property
    def time(self) -> Series:
        """Communication points in s."""
        return self.result.times

    @property
    def error(self) -> Series:
        """True elongation minus correction in m at the communication points."""
        return remaining_error(self.result)

    @property
    def uncompensated(self) -> ErrorMetrics:
        """Figures without a controller."""
        return error_metrics(self.time, self.result[ELONGATION], self.scenario.tolerance)

    @property
    def metrics(self) -> ErrorMetrics:
        """Figures with the controller."""
        return error_metrics(self.time, self.error, self.scenario.tolerance)

    @property
    def discretisation_error_um(self) -> float:
        """Largest estimate that the link makes of its grid's error."""
        return 1e6 * float(np.max(np.abs(self.result["link.discretisation_error"])))

    @property
    def reduction_percent(self) -> float | None:
        """Share of the largest error that the controller removes; None where that means nothing."""
        budget = (self.coupling_error_um or 0.0) + self.discretisation_error_um
        return reduction_percent(self.uncompensated, self.metrics, budget)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What to know before trusting the figures."""
        flattering = self.ideal and self.metrics.max_abs_um < 1e5 * self.scenario.tolerance
        told = (*self.scenario.duty.remarks, *self.result.remarks, self.advice, IDEAL if flattering else None)
        return tuple(each for each in told if each)

    def to_dict(self) -> dict[str, Any]:
        """What stands in `metrics.json`."""
        return {
            "scenario": self.scenario.name,
            "controller": self.controller,
            "mismatches": list(self.scenario.mismatches),
            "fmus": self.fmus,
            "stop_time_s": self.scenario.stop_time,
            "communication_step_size_s": self.scenario.step_size,
            "master": self.scenario.master,
            "tolerance_um": 1e6 * self.scenario.tolerance,
            "uncompensated": self.uncompensated.to_dict(),
            "compensated": self.metrics.to_dict(),
            "reduction_percent": self.reduction_percent,
            "heat_balance_error_J": sum(audit.total for audit in self.result.audits),
            "error_budget_um": {
                "coupling": self.coupling_error_um,
                "discretisation": self.discretisation_error_um,
            },
            "simulated_s": float(self.time[-1]),
            "stopped": self.cut_short,
            "remarks": list(self.remarks),
            "wall_seconds": self.wall_seconds,
        }


IDEAL = (
    "the thermometers are perfect and the cell is just the one that the law was designed for, which no real "
    "one is; add --mismatch thermal_high or --mismatch noisy_sensors, say"
)


def remaining_error(result: Result) -> Series:
    """True elongation minus correction in m at the communication points."""
    return result[ELONGATION] - result[CORRECTION]


def run_scenario(
    scenario: Scenario,
    controller: str,
    store: FmuStore,
    progress: Progress | None = None,
    own: OwnLaw | None = None,
) -> ClosedLoop:
    """Run a scenario's cell with a controller, and once more at half the step.

    Ctrl-C ends it in order: what was computed up to there is kept.

    Parameters
    ----------
    scenario : what to run
    controller : name of a shipped one, or what to call one's own
    store : where the FMUs are
    progress : called with the share of the work that is done
    own : a law of one's own, in the controller's place

    Raises
    ------
    InputError
        If the scenario names a controller, parameter, unit or master that does not exist, or a value that
        a component refuses.
    SlaveError
        If the run did not get to a first value.
    """
    began = time.perf_counter()
    report = progress or (lambda share: None)
    law = catalogue.controller(controller) if own is None else own.component
    cell = _system(scenario, law, store, own)
    components = cell_components(law)
    believed = scenario.parameters if scenario.believed is None else scenario.believed
    told = None if own or controller == NO_CONTROLLER else advice(controller, components, believed)
    ideal = own is None and is_ideal(controller, components, scenario.parameters)
    chosen = algorithm(scenario.master)
    stop, step = scenario.stop_time, scenario.step_size
    with temporary_folder() as home:
        result = guarded(
            lambda line: simulate(cell, stop, step, chosen, unpacked=home, line=line),
            lambda at, count: report(at / count / 3),
        )
        coupling, cut_short = None, result.reason
        if cut_short is None:
            try:
                fine = guarded(
                    lambda line: simulate(
                        cell,
                        stop,
                        step / 2,
                        chosen,
                        record=(ELONGATION,),
                        unpacked=home,
                        check_stability=False,
                        line=line,
                    ),
                    lambda at, count: report((1 + 2 * at / count) / 3),
                )
                coupling, cut_short = _coupling_um(result, fine, chosen.order), fine.reason
            except KeyboardInterrupt:
                cut_short = "interrupted"
            except SlaveError as fault:  # before its first value, which costs the first run nothing
                cut_short = str(fault)
            cut_short = cut_short and f"{cut_short} in the run at half the step"
    return ClosedLoop(
        scenario=scenario,
        controller=controller,
        fmus=store.kind,
        result=result,
        coupling_error_um=coupling,
        cut_short=cut_short,
        advice=told,
        ideal=ideal,
        wall_seconds=time.perf_counter() - began,
    )


def _coupling_um(result: Result, fine: Result, order: int) -> float | None:
    (bound,) = coupling_error(result, fine, order, (ELONGATION,))
    return 1e6 * bound.largest if np.isfinite(bound.largest) else None


def cell_components(controller: Component) -> dict[str, Component]:
    """Declaration behind each instance of the cell with a controller."""
    return {
        instance: controller if instance == COMPENSATOR else catalogue.components()[kind]
        for instance, kind in WARMUP_CELL.components.items()
    }


def cell_values(scenario: Scenario, controller: Component) -> dict[str, dict[str, Value]]:
    """Start values of the cell that a scenario asks for, in SI units by instance and variable.

    Raises
    ------
    InputError
        If the scenario names a parameter or unit that does not exist, a component refuses a value, or the
        run would be too long.
    """
    check_extent(scenario.name, scenario.stop_time, scenario.step_size)
    values = start_values(scenario.parameters, cell_components(controller), scenario.name)
    values.setdefault("duty", {}).update(scenario.duty.component_parameters())
    if "tolerance" in controller.p.index:
        values.setdefault(COMPENSATOR, {}).setdefault("tolerance", scenario.tolerance)
    return values


def _system(scenario: Scenario, law: Component, store: FmuStore, own: OwnLaw | None) -> System:
    values = cell_values(scenario, law)
    kinds = WARMUP_CELL.components_with(law.name).values()
    files = store.files(kind for kind in kinds if own is None or kind != law.name)
    if own is not None:
        files[law.name] = own.fmu(store)
    return WARMUP_CELL.system(files, law.name, values)
