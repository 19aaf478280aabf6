"""One scenario in closed loop: the cell with a controller and without, and how far off each was."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warmlink.fmus.packaging.component import Component
from warmlink.orchestration import catalogue
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.master.algorithms import algorithm
from warmlink.orchestration.master.error_budget import estimate_coupling_error
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.result import Result
from warmlink.orchestration.master.run import Progress as MasterProgress
from warmlink.orchestration.master.run import simulate
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
    """What a scenario came to: one run without a controller and one with.

    `coupling_error_um` bounds what the finite communication step costs the elongation, by a run with half
    of it; None where a run stopped early.
    """

    scenario: Scenario
    controller: str
    fmus: FmuKind
    without: Result
    compensated: Result
    coupling_error_um: float | None
    wall_seconds: float

    @property
    def time(self) -> Series:
        """Communication points in s."""
        return self.compensated.times

    @property
    def error(self) -> Series:
        """True elongation minus correction in m at the communication points."""
        return remaining_error(self.compensated)

    @property
    def uncompensated(self) -> ErrorMetrics:
        """Figures without a controller."""
        return error_metrics(self.without.times, remaining_error(self.without), self.scenario.tolerance)

    @property
    def metrics(self) -> ErrorMetrics:
        """Figures with the controller."""
        return error_metrics(self.time, self.error, self.scenario.tolerance)

    @property
    def discretisation_error_um(self) -> float:
        """Largest estimate that the link makes of its grid's error."""
        return 1e6 * float(np.max(np.abs(self.compensated["link.discretisation_error"])))

    @property
    def stopped(self) -> str | None:
        """Why a run ended early, None where both came to their end."""
        return self.without.reason or self.compensated.reason

    def to_dict(self) -> dict[str, Any]:
        """What stands in `metrics.json`."""
        return {
            "scenario": self.scenario.name,
            "controller": self.controller,
            "fmus": self.fmus,
            "stop_time_s": self.scenario.stop_time,
            "communication_step_size_s": self.scenario.step_size,
            "master": self.scenario.master,
            "tolerance_um": 1e6 * self.scenario.tolerance,
            "uncompensated": self.uncompensated.to_dict(),
            "compensated": self.metrics.to_dict(),
            "reduction_percent": reduction_percent(self.uncompensated, self.metrics),
            "heat_balance_error_J": sum(audit.total for audit in self.compensated.audits),
            "error_budget_um": {
                "coupling": self.coupling_error_um,
                "discretisation": self.discretisation_error_um,
            },
            "stopped": self.stopped,
            "wall_seconds": self.wall_seconds,
        }


def remaining_error(result: Result) -> Series:
    """True elongation minus correction in m at the communication points."""
    return result[ELONGATION] - result[CORRECTION]


def run_scenario(
    scenario: Scenario, controller: str, store: FmuStore, progress: Progress | None = None
) -> ClosedLoop:
    """Run a scenario's cell without and with a controller, and once more at half the step.

    Raises
    ------
    InputError
        If the scenario names a controller, parameter, unit or master that does not exist, or a value that
        a component refuses.
    """
    began = time.perf_counter()
    report = progress or (lambda share: None)
    cell = _system(scenario, catalogue.controller(controller), store)
    plain = _system(_of_plant(scenario), catalogue.controller(NO_CONTROLLER), store)

    chosen = algorithm(scenario.master)
    stop, step = scenario.stop_time, scenario.step_size

    def part(done: float, whole: float) -> MasterProgress:
        return lambda at, count: report((done + whole * at / count) / 4)

    with temporary_folder() as home:

        def once(system: System, progress: MasterProgress) -> Result:
            return guarded(
                lambda line: simulate(system, stop, step, chosen, unpacked=home, line=line), progress
            )

        def again(until: float, half: float) -> Result:
            return guarded(
                lambda line: simulate(
                    cell,
                    until,
                    half,
                    chosen,
                    record=(ELONGATION,),
                    unpacked=home,
                    check_stability=False,
                    line=line,
                ),
                part(2, 2),
            )

        without, compensated = once(plain, part(0, 1)), once(cell, part(1, 1))

        (coupling,) = estimate_coupling_error(again, compensated, step, chosen.order, (ELONGATION,))
    return ClosedLoop(
        scenario=scenario,
        controller=controller,
        fmus=store.kind,
        without=without,
        compensated=compensated,
        coupling_error_um=1e6 * coupling.largest if np.isfinite(coupling.largest) else None,
        wall_seconds=time.perf_counter() - began,
    )


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
        If the scenario names a parameter or unit that does not exist, or a component refuses a value.
    """
    values = start_values(scenario.parameters, cell_components(controller), scenario.name)
    values.setdefault("duty", {}).update(scenario.duty.component_parameters())
    if "tolerance" in controller.p.index:
        values.setdefault(COMPENSATOR, {}).setdefault("tolerance", scenario.tolerance)
    return values


def _of_plant(scenario: Scenario) -> Scenario:
    """The scenario without what it sets of the controller, which `none` does not have."""
    parameters = {
        name: value for name, value in scenario.parameters.items() if name.rpartition(".")[0] != COMPENSATOR
    }
    return replace(scenario, parameters=parameters)


def _system(scenario: Scenario, controller: Component, store: FmuStore) -> System:
    kinds = WARMUP_CELL.components_with(controller.name)
    values = cell_values(scenario, controller)
    return WARMUP_CELL.system(store.files(kinds.values()), controller.name, values)
