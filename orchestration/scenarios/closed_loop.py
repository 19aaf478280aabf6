"""One scenario in closed loop: the cell with a controller and without, and how far off each was."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.component import Component
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.master.algorithms import algorithm_named
from warmlink.orchestration.master.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.metrics import ErrorMetrics, Series, error_metrics, reduction_percent
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.shipped import WARMUP_CELL

ELONGATION = "link.elongation"
CORRECTION = "compensator.correction"

NO_CONTROLLER = "none"

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


@dataclass(frozen=True)
class ClosedLoop:
    """What a scenario came to: one run without a controller and one with.

    `coupling_error_um` is what halving the communication step changes of the largest elongation error.
    """

    scenario: Scenario
    controller: str
    fmus: FmuKind
    without: Result
    compensated: Result
    coupling_error_um: float
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
    laws = store.controllers()
    for name in (controller, NO_CONTROLLER):
        if name not in laws:
            raise InputError(f"{name}: no such controller; choose {', '.join(sorted(laws))}")
    cell = _system(scenario, laws[controller], store)
    plain = _system(scenario, laws[NO_CONTROLLER], store)

    without = _simulate(plain, scenario, 1, lambda share: report(share / 4))
    compensated = _simulate(cell, scenario, 1, lambda share: report((1 + share) / 4))
    finer = _simulate(cell, scenario, 2, lambda share: report((2 + 2 * share) / 4))
    return ClosedLoop(
        scenario=scenario,
        controller=controller,
        fmus=store.kind,
        without=without,
        compensated=compensated,
        coupling_error_um=_coupling_error(compensated, finer),
        wall_seconds=time.perf_counter() - began,
    )


def _system(scenario: Scenario, controller: Component, store: FmuStore) -> System:
    kinds = WARMUP_CELL.components_with(controller.name)
    components = {instance: store.component(kind) for instance, kind in kinds.items()}
    values = start_values(scenario.parameters, components, scenario.name)
    values.setdefault("duty", {}).update(scenario.duty.parameters())
    if "tolerance" in controller.p.index:
        values.setdefault("compensator", {}).setdefault("tolerance", scenario.tolerance)
    return WARMUP_CELL.system(store.files(kinds.values()), controller.name, values)


def _simulate(system: System, scenario: Scenario, refinement: int, progress: Progress) -> Result:
    return simulate(
        system,
        scenario.stop_time,
        scenario.step_size / refinement,
        algorithm_named(scenario.master),
        progress=lambda done, count: progress(done / count),
    )


def _coupling_error(coarse: Result, fine: Result) -> float:
    """Largest change in um of the elongation when the communication step is halved, at shared times.

    A method of order 1 is off by twice that change at the coarse step (Richardson).
    """
    shared = min(len(coarse.times), (len(fine.times) + 1) // 2)
    change = coarse[ELONGATION][:shared] - fine[ELONGATION][::2][:shared]
    return 2e6 * float(np.max(np.abs(change), initial=0.0))
