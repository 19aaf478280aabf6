"""A scenario of the arm in closed loop: an observer an axis, and one over all axes beside them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.component import Component
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.blueprint import POSES, arm_blueprint, arm_values, axis_name, merged
from warmlink.orchestration.arm.centralised import CentralisedObserver, Readings
from warmlink.orchestration.arm.compensation import compensator_values, plant
from warmlink.orchestration.arm.outcome import CENTRALISED, RECORDED, ArmOutcome, Compensation, columns
from warmlink.orchestration.arm.program import Program
from warmlink.orchestration.arm.scenario import ArmScenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.master.compiled.loop import try_to_prepare
from warmlink.orchestration.master.error_budget import estimate_coupling_error
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import Progress as MasterProgress
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.shipped import COMPENSATOR, Blueprint

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""

_ELONGATIONS = tuple(f"{axis_name(i)}.link.elongation" for i in range(1, AXES + 1))


def run_arm(
    scenario: ArmScenario,
    controller: str,
    store: FmuStore,
    progress: Progress | None = None,
    bounded: bool = True,
) -> ArmOutcome:
    """Run a scenario with a compensator an axis, and once more at half the step.

    The compensators change nothing about heat and growth, so that the same run tells what there is without
    them, and what one observer over all axes would have left. The run at half the step is left out where the
    coupling error is not to be `bounded`.

    Raises
    ------
    InputError
        If the scenario names a controller, parameter, unit or master that does not exist, or a value that a
        component refuses.
    """
    began = time.perf_counter()
    try_to_prepare()
    report = progress or (lambda share: None)
    system, plain = arm_system(scenario, controller, store), arm_system(scenario, None, store)
    chosen = algorithm(scenario.master)
    readings = tuple(f"{axis_name(i)}.sensors.reading[{scenario.sensor_channel}]" for i in range(1, AXES + 1))

    def part(done: float, whole: float) -> MasterProgress:
        return lambda at, count: report(done + whole * at / count)

    record, stop, step = (*RECORDED, *readings), scenario.stop_time, scenario.step_size
    result = guarded(
        lambda line: simulate(system, stop, step, chosen, record=record, line=line), part(0.0, 0.3)
    )
    bounded = bounded and result.reason is None  # after a Ctrl-C nobody waits for another run
    coupling = _coupling_error(plain, result, scenario, part(0.3, 0.5)) if bounded else np.inf
    compensations = [Compensation(controller, columns(result, f"{COMPENSATOR}.correction"))]
    compensations.append(Compensation(CENTRALISED, centralised(scenario, result)))
    report(1.0)
    return ArmOutcome(
        scenario=scenario,
        fmus=store.kind,
        result=result,
        compensations=tuple(compensations),
        coupling_error_um=coupling if np.isfinite(coupling) else None,
        wall_seconds=time.perf_counter() - began,
    )


def _coupling_error(plain: System, result: Result, scenario: ArmScenario, progress: MasterProgress) -> float:
    """Bound in um on what the communication step costs any elongation; infinite where a run stopped early."""
    chosen = algorithm(scenario.master)
    bounds = estimate_coupling_error(
        lambda until, half: guarded(
            lambda line: simulate(plain, until, half, chosen, record=_ELONGATIONS, line=line), progress
        ),
        result,
        scenario.step_size,
        chosen.order,
        _ELONGATIONS,
    )
    return 1e6 * max(bound.largest for bound in bounds)


def arm_system(scenario: ArmScenario, controller: str | None, store: FmuStore) -> System:
    """The arm under a scenario's program, with a compensator an axis where there is a controller."""
    return system_of(scenario, controller, store.files(arm_kinds(controller)))


def arm_kinds(controller: str | None) -> list[str]:
    """Names of the components that an arm is made of."""
    law = None if controller is None else catalogue.controller(controller).name
    return sorted(set(arm_blueprint(compensated=law is not None).components_with(law).values()))


def system_of(
    scenario: ArmScenario, controller: str | None, fmus: Mapping[str, Path], count: int = AXES
) -> System:
    """The arm as `arm_system` gives it, from FMU files by the component's name, with so many axes."""
    blueprint, law, values = _described(scenario, controller, count)
    return blueprint.system(fmus, law, values)


def joined_arm(scenario: ArmScenario, count: int = AXES) -> Component:
    """The arm under a scenario's program with its controller, as one component with so many axes."""
    blueprint, law, values = _described(scenario, scenario.controller, count)
    return blueprint.joined(law, values)


def _described(
    scenario: ArmScenario, controller: str | None, count: int
) -> tuple[Blueprint, str | None, dict[str, dict[str, Value]]]:
    """Blueprint, component of the controller, and start values by instance."""
    law = None if controller is None else catalogue.controller(controller).name
    blueprint = replace(arm_blueprint(count, law is not None), stop_time=scenario.stop_time)
    kinds = blueprint.components_with(law)
    declared = {instance: catalogue.components()[kind] for instance, kind in kinds.items()}
    values = merged(arm_values(count), program_values(scenario.program, count))
    if controller is not None:
        values = merged(values, compensator_values(controller, scenario.sensor, scenario.sensor_noise, count))
    written = {name: value for name, value in scenario.parameters.items() if law or _of_plant(name)}
    return blueprint, law, merged(values, start_values(written, declared, scenario.name))


def _of_plant(name: str) -> bool:
    """Whether a start value belongs to what is there without compensators."""
    return name.rpartition(".")[0].rpartition(".")[2] not in ("sensors", COMPENSATOR)


def program_values(program: Program, count: int = AXES) -> dict[str, dict[str, Value]]:
    """Start values of duty cycles and poses by instance."""
    values = {f"{axis_name(i)}.duty": program.duty_values(i) for i in range(1, count + 1)}
    values[POSES] = program.pose_values()
    return values


def centralised(scenario: ArmScenario, result: Result) -> np.ndarray:
    """Elongations in m as one observer over all axes sees them, from the readings of a run, shape (n, 6)."""
    observer = CentralisedObserver(
        [plant(i) for i in range(1, AXES + 1)],
        f"{scenario.sensor}_temperature",
        scenario.sensor_noise,
    )
    return observer.run(
        Readings(
            step=scenario.step_size,
            speed=columns(result, "duty.speed"),
            torque=columns(result, "duty.torque"),
            ambient=result["axis1.duty.ambient_temperature"],
            temperature=columns(result, f"sensors.reading[{scenario.sensor_channel}]"),
        )
    )
