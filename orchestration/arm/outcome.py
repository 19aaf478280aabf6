"""What a scenario of the arm came to: errors of the tool point without compensation and with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arm_kinematics.equations import AXES, COORDINATES
from warmlink.orchestration.arm.blueprint import KINEMATICS, POSES, axis_name
from warmlink.orchestration.arm.geometry import axes
from warmlink.orchestration.arm.pose import sensitivities
from warmlink.orchestration.arm.scenario import ArmScenario
from warmlink.orchestration.fmu_store import FmuKind
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.scenarios.metrics import ErrorMetrics, error_metrics, reduction_percent
from warmlink.orchestration.system.shipped import COMPENSATOR

Array = NDArray[np.float64]

CENTRALISED = "centralised"
"""One observer over all axes, in the figures beside the law of each axis."""

_RECORDED_BY_AXIS = (
    "duty.speed",
    "duty.torque",
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "motor.neighbour_heat_flow",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
    "link.elongation",
    "link.discretisation_error",
    f"{COMPENSATOR}.correction",
)

RECORDED = (
    *(f"{axis_name(i)}.{name}" for i in range(1, AXES + 1) for name in _RECORDED_BY_AXIS),
    "axis1.duty.ambient_temperature",
    *(f"{POSES}.angle[{i}]" for i in range(1, AXES + 1)),
    *(f"{KINEMATICS}.{name}[{k}]" for name in ("position", "error") for k in (1, 2, 3)),
    f"{KINEMATICS}.error_norm",
    f"{KINEMATICS}.uncompensated_error_norm",
)
"""What of a run is kept, besides the readings of the one thermometer an axis."""


@dataclass(frozen=True)
class Compensation:
    """One way of compensating: estimated elongations in m at the communication points, shape (n, 6)."""

    name: str
    correction: Array


@dataclass(frozen=True)
class ArmOutcome:
    """A run of the arm with a compensator an axis, and what others would have left.

    Attributes
    ----------
    result : the run
    compensations : those that are held against each other, the one in the run first
    coupling_error_um : bound on what the communication step costs any elongation; None where it is not known
    """

    scenario: ArmScenario
    fmus: FmuKind
    result: Result
    compensations: tuple[Compensation, ...]
    coupling_error_um: float | None
    wall_seconds: float

    @property
    def time(self) -> Array:
        """Communication points in s."""
        return self.result.times

    @cached_property
    def growth(self) -> Array:
        """True elongation of each link in m, shape (n, 6)."""
        return columns(self.result, "link.elongation")

    @cached_property
    def sensitivity(self) -> Array:
        """Derivative of the tool point by each elongation in the pose held, shape (n, 3, 6)."""
        return sensitivities(
            np.column_stack([self.result[f"{POSES}.angle[{i}]"] for i in range(1, AXES + 1)])
        )

    def tool_error(self, correction: Array | None = None) -> Array:
        """Error of the tool point in m, x, y and z, shape (n, 3), with a correction or without."""
        left = self.growth if correction is None else self.growth - correction
        return np.asarray(np.einsum("nki,ni->nk", self.sensitivity, left))

    def metrics(self, correction: Array | None = None) -> ErrorMetrics:
        """Figures of the error's length."""
        norm = np.linalg.norm(self.tool_error(correction), axis=1)
        return error_metrics(self.time, norm, self.scenario.tolerance)

    def by_axis(self, correction: Array | None = None) -> Array:
        """What each link adds, in m, to the error's length when that is largest, shape (6,); sums to it."""
        error = self.tool_error(correction)
        length = np.linalg.norm(error, axis=1)
        worst = int(np.argmax(length))
        left = self.growth[worst] if correction is None else (self.growth - correction)[worst]
        if length[worst] == 0:
            return np.zeros(AXES)
        along = error[worst] / length[worst] @ self.sensitivity[worst]
        return np.asarray(along * left)

    @property
    def discretisation_error_um(self) -> float:
        """Largest estimate that any link makes of its grid's error."""
        return 1e6 * float(np.abs(columns(self.result, "link.discretisation_error")).max())

    @property
    def stopped(self) -> str | None:
        """Why the run ended early, None where it came to its end."""
        return self.result.reason

    def to_dict(self) -> dict[str, Any]:
        """What stands in `metrics.json`."""
        before = self.metrics()
        return {
            "scenario": self.scenario.name,
            "system": "SixAxisArm",
            "controller": self.compensations[0].name,
            "sensor": self.scenario.sensor,
            "fmus": self.fmus,
            "stop_time_s": self.scenario.stop_time,
            "communication_step_size_s": self.scenario.step_size,
            "master": self.scenario.master,
            "tolerance_um": 1e6 * self.scenario.tolerance,
            "uncompensated": self._figures(None),
            "compensated": self._figures(self.compensations[0].correction),
            "reduction_percent": reduction_percent(before, self.metrics(self.compensations[0].correction)),
            "compensations": {
                each.name: {
                    **self._figures(each.correction),
                    "reduction_percent": reduction_percent(before, self.metrics(each.correction)),
                }
                for each in self.compensations
            },
            "heat_balance_error_J": sum(audit.total for audit in self.result.audits),
            "error_budget_um": {
                "coupling": self.coupling_error_um,
                "discretisation": self.discretisation_error_um,
            },
            "stopped": self.stopped,
            "wall_seconds": self.wall_seconds,
        }

    def _figures(self, correction: Array | None) -> dict[str, Any]:
        largest = 1e6 * np.abs(self.tool_error(correction)).max(axis=0)
        shares = 1e6 * self.by_axis(correction)
        left = self.growth if correction is None else self.growth - correction
        return {
            **self.metrics(correction).to_dict(),
            "max_abs_um_by_coordinate": dict(zip(COORDINATES, largest.tolist(), strict=True)),
            "largest_error_by_axis_um": by_name(shares),
            "max_abs_elongation_error_um_by_axis": by_name(1e6 * np.abs(left).max(axis=0)),
        }


def columns(result: Result, variable: str) -> Array:
    """A variable of each axis, shape (n, 6)."""
    return np.column_stack([result[f"{axis_name(i)}.{variable}"] for i in range(1, AXES + 1)])


def by_name(values: Array) -> Mapping[str, float]:
    """A value an axis under the axes' names."""
    return {axis.name: float(value) for axis, value in zip(axes(), values, strict=True)}
