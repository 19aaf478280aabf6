"""Runs of a machine's FMUs, without a controller and without noise, to which a law is fitted."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from warmlink.controllers.design.training import DrivenRun, excitations
from warmlink.controllers.interface import SENSED
from warmlink.fmus.arguments import argument
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.console import remark
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.machine.machine import DUTY, Machine
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.duties.duty import Duty, Segment
from warmlink.orchestration.scenarios.scenario import Scenario

LONGER, SHORTEST, LONGEST = 4.0, 2 * 3600.0, 8 * 3600.0
"""Length of such a run as a multiple of the scenario's, and least and largest length in s."""

FASTER = 1.25
"""Largest speed and torque of such a run, as a multiple of the scenario's."""

ROW = 10.0
"""s between two rows of a run, or the communication step where that is longer."""

DEMANDS = ("speed", "torque", "ambient_temperature")
"""What a controller may be told of the duty."""


def run_of(scenario: Scenario, sensors: Sequence[str]) -> DrivenRun:
    """The scenario's run, to fit a regression to; raises as `_recorded`."""
    with progress_bar(f"A run of {scenario.machine.name} to fit the regression to") as show:
        return _recorded(scenario, sensors, show)


def runs_of(scenario: Scenario, sensors: Sequence[str]) -> list[DrivenRun]:
    """Runs at random, then the scenario's own, each with a row in `ROW`.

    InputError as `_recorded`, or where the scenario asks for no speed and no torque.
    """
    segments = scenario.duty.unrolled()
    speed, torque = (
        FASTER * max(abs(getattr(each, name)) for each in segments) for name in ("speed", "torque")
    )
    if speed == torque == 0:
        raise InputError(
            f"{scenario.name}: its duty cycle asks for no speed and no torque; name one that does, as "
            'duty = "stop_and_go"'
        )
    length = min(max(LONGER * scenario.stop_time, SHORTEST), LONGEST)
    driven = [tuple(Segment(*stage) for stage in each) for each in excitations(speed, torque, length)]
    every = [
        replace(scenario, duty=Duty(f"run {i}", "", "", sum(part.duration for part in each), each))
        for i, each in enumerate(driven, start=1)
    ]
    every.append(scenario)
    found = []
    with progress_bar(f"Runs of {scenario.machine.name} to find its model from") as show:
        for done, each in enumerate(every):
            found.append(_thinned(_recorded(each, sensors, partial(_shown, show, done, len(every)))))
    return found


def _shown(show: Callable[..., None], done: int, count: int, share: float) -> None:
    show((done + share) / count, f"run {done + 1} of {count}")


def _thinned(run: DrivenRun) -> DrivenRun:
    n = max(1, round(ROW / run.step))
    return DrivenRun(run.temperature[::n], run.elongation[::n], n * run.step, run.duty[::n], run.told)


def _recorded(scenario: Scenario, sensors: Sequence[str], show: Callable[[float], None]) -> DrivenRun:
    """What the controller reads in a run of the FMUs, without noise, and what it should correct.

    InputError where it reads none of a sensor that it is to go by, or the run fails.
    """
    machine = scenario.machine
    (controller, *_) = machine.controllers
    fed = {target for _, target in machine.wires}
    read = [name for name in SENSED if f"{controller}.{name}" in fed]
    told = {name: f"{controller}.{name}" for name in DEMANDS if f"{controller}.{name}" in fed}
    # What the controller is not told drives the machine all the same.
    asked = {**{name: f"{DUTY}.{name}" for name in DEMANDS}, **told}
    refuse_unread(machine, sensors, read)
    quiet = replace(scenario.as_believed, sensors=replace(scenario.in_use, noise=0.0))
    system = quiet.system(quiet.files(store(None, sorted(quiet.kinds), remark)))
    names = {**{name: f"{controller}.{name}" for name in read}, **asked}
    record = [*names.values(), *machine.roles.uncompensated.variables]
    run = simulate(
        system,
        quiet.stop_time,
        quiet.step_size,
        algorithm(quiet.master),
        record=record,
        progress=lambda done, count: show(done / count),
    )
    if run.reason is not None:
        raise InputError(f"{machine.name}: {run.reason}")
    still = np.full(run.times.size, ROOM_TEMPERATURE)
    speed, torque, around = (name in told for name in DEMANDS)
    return DrivenRun(
        np.column_stack([run[names[name]] if name in read else still for name in SENSED]),
        machine.roles.uncompensated.value(run.__getitem__),
        quiet.step_size,
        np.column_stack([run[asked[name]] for name in DEMANDS]),
        (speed, torque, around),
    )


def refuse_unread(machine: Machine, sensors: Sequence[str], read: Collection[str]) -> None:
    """Raise InputError where a controller reads none of a sensor that it is to go by, or no temperature."""
    (controller, *_) = machine.controllers
    if not read:
        raise InputError(
            f"{machine.name}: feeds no thermometer to {controller}; wire one to it, as base_temperature"
        )
    for name in sensors:
        if f"{name.removesuffix('_temperature')}_temperature" not in read:
            told = f"{machine.name} feeds no {name} to {controller}; {instead(name, read)}"
            raise InputError(f"{argument('sensors')}: {told}")
