"""Controllers x programs x mismatches of the arm, in the columns that `compare.csv` has."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.orchestration.arm.blueprint import arm_values, axis_name
from warmlink.orchestration.arm.outcome import CENTRALISED, ArmOutcome, Array
from warmlink.orchestration.arm.run import run_arm
from warmlink.orchestration.arm.scenario import ArmScenario
from warmlink.orchestration.catalogue import components
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.scenarios.closed_loop import NO_CONTROLLER
from warmlink.orchestration.scenarios.metrics import reduction_percent
from warmlink.orchestration.studies.compare import COLUMNS
from warmlink.orchestration.studies.mismatch import NOMINAL, Mismatch

KINDS = {
    "duty": "DutyCycle",
    "motor": "MotorHeatSource",
    "link": "ThermalLink",
    "sensors": "TemperatureSensors",
}
"""Component behind each instance of an axis that a mismatch may change."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class ArmRow:
    """One controller in one program, its figures those of the tool point's error."""

    controller: str
    duty_cycle: str
    mismatch: str
    max_abs_um: float
    p95_abs_um: float
    time_to_tolerance_s: float | None
    removed_percent: float | None
    equal_within_um: float | None


def compare_arm(
    controllers: Sequence[str],
    scenarios: Sequence[ArmScenario],
    mismatches: Sequence[Mismatch],
    store: FmuStore,
    progress: Progress | None = None,
) -> list[ArmRow]:
    """Run every combination; beside the controllers asked for stand `none` and the centralised observer.

    Raises
    ------
    InputError
        If a controller or parameter does not exist, or a component refuses a value.
    """
    report = progress or (lambda share: None)
    laws = [name for name in dict.fromkeys(controllers) if name != NO_CONTROLLER] or [NO_CONTROLLER]
    rows: list[ArmRow] = []
    total, done = len(laws) * len(scenarios) * len(mismatches), 0
    for scenario in scenarios:
        for mismatch in mismatches:
            changed = replace(scenario, parameters={**scenario.parameters, **applied(mismatch)})
            for law in laws:
                outcome = run_arm(changed, law, store, bounded=law == laws[0])
                rows += _rows(outcome, mismatch.name, law == laws[0])
                done += 1
                report(done / total)
    order = {name: k for k, name in enumerate((NO_CONTROLLER, *laws, CENTRALISED))}
    return sorted(rows, key=lambda row: order[row.controller])


def applied(mismatch: Mismatch) -> dict[str, str | float]:
    """Start values of the arm under a mismatch of the warm-up cell, put on every axis alike.

    Factors act on what each axis has. What concerns the camera, which the arm does not have, is left out.
    """
    if mismatch.name == NOMINAL:
        return {}
    arm = arm_values()
    changed: dict[str, str | float] = {}
    for i in range(1, AXES + 1):
        for name, factor in mismatch.scale.items():
            instance, _, variable = name.partition(".")
            if instance in KINDS:
                of_axis = arm.get(f"{axis_name(i)}.{instance}", {})
                start = of_axis.get(variable, _declared(instance, variable))
                changed[f"{axis_name(i)}.{name}"] = factor * float(start)
        for name, value in mismatch.parameters.items():
            if name.partition(".")[0] in KINDS:
                changed[f"{axis_name(i)}.{name}"] = value
    return changed


def write_csv(rows: Sequence[ArmRow], path: Path) -> None:
    """Write `compare.csv`, a row a run; what is not known is left empty."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            cells = (getattr(row, name) for name in COLUMNS)
            writer.writerow(["" if c is None else round(c, 6) if isinstance(c, float) else c for c in cells])


def _rows(outcome: ArmOutcome, mismatch: str, first: bool) -> Iterator[ArmRow]:
    """Rows of one run: its controller's and, from the first, those that are the same in every run."""
    kinds: Mapping[str, Array | None] = {each.name: each.correction for each in outcome.compensations}
    if first:
        kinds = {NO_CONTROLLER: None, **kinds}
    else:
        kinds = {name: correction for name, correction in kinds.items() if name != CENTRALISED}
    before = outcome.metrics()
    coupling = outcome.coupling_error_um
    equal = None if coupling is None else coupling + outcome.discretisation_error_um
    for name, correction in kinds.items():
        after = outcome.metrics(correction)
        yield ArmRow(
            name,
            outcome.scenario.name,
            mismatch,
            after.max_abs_um,
            after.p95_abs_um,
            after.time_to_tolerance_s,
            reduction_percent(before, after),
            equal,
        )


def _declared(instance: str, variable: str) -> float:
    """Start value that a component declares; 0 where there is none of that name, which is told later."""
    starts = {s.name: s.start for s in components()[KINDS[instance]].scalars()}
    return starts.get(variable) or 0.0
