"""A system's slaves: instantiated, and brought to consistent values at the first communication point."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import cast

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import scratch_folder
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.orchestration.master.algorithms.structure import feedthrough_order
from warmlink.orchestration.master.slaves.events import Fmi3EventSlave
from warmlink.orchestration.master.slaves.fmi import FmiSlave
from warmlink.orchestration.master.slaves.isolation import UNLIMITED, IsolatedSlave, Isolation
from warmlink.orchestration.master.slaves.models import Fmi1Model, Fmi2Model, Fmi3Model
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.scheduled import Fmi3ScheduledSlave
from warmlink.orchestration.master.slaves.slave import RunSpan, Slave, SlaveError, nominal
from warmlink.orchestration.master.slaves.versions import Fmi1Slave, Fmi2Slave, Fmi3Slave
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.described import described
from warmlink.orchestration.system.description import ModelInfo
from warmlink.orchestration.system.model import Connection, FmuPart, System, Value

# What FMI gives for reading and compiling alone.
NOT_FOR_RUNNING = ("documentation", "sources")
_here: set[tuple[str, str]] = set()
"""FMUs that allow one instance in a process and have had it, by identifier and GUID."""

_KINDS: dict[tuple[str, str], type[FmiSlave]] = {
    ("1.0", "CoSimulation"): Fmi1Slave,
    ("2.0", "CoSimulation"): Fmi2Slave,
    ("3.0", "CoSimulation"): Fmi3Slave,
    ("1.0", "ModelExchange"): Fmi1Model,
    ("2.0", "ModelExchange"): Fmi2Model,
    ("3.0", "ModelExchange"): Fmi3Model,
    ("3.0", "ScheduledExecution"): Fmi3ScheduledSlave,
}
"""Slaves by FMI version and interface."""

TOLERANCE = 1e-12
SWEEPS = 200


@dataclass
class Assembly:
    """Slaves in the system's order and connections; used once, then closed.

    Start values are by slave and variable, in the variables' own units; the parts are those of slaves that
    are FMUs; the `workplace`, where these were unpacked, is removed on closing.
    """

    slaves: Sequence[Slave]
    connections: Sequence[Connection] = ()
    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    parts: Mapping[str, FmuPart] = field(default_factory=dict)
    workplace: ExitStack = field(default_factory=ExitStack)

    def close(self) -> None:
        """End the slaves and remove what was unpacked."""
        for slave in self.slaves:
            with suppress(SlaveError):  # which changes nothing about the run that lies behind
                slave.terminate()
        self.workplace.close()


def assemble(system: System, isolation: Isolation | None = None, unpacked: Path | None = None) -> Assembly:
    """Unpack and instantiate every FMU of a system, in the folder `unpacked` where it is to be kept.

    With an isolation every FMU gets a process of its own; without one, those that a process may hold once get
    one from their second instance on. InputError where a file is not an FMU that can run here, SlaveError
    where an FMU does not instantiate.
    """
    infos = {name: described(component) for name, component in system.components.items()}
    workplace = ExitStack()
    home = unpacked or workplace.enter_context(scratch_folder())
    slaves: list[Slave] = []
    values = {name: component.values for name, component in system.components.items()}
    found = Assembly(slaves, system.connections, values, system.components, workplace)
    try:
        for name, part in system.components.items():
            folder = unpack(part.fmu, _home(part.fmu, home), without=NOT_FOR_RUNNING)
            opened = partial(open_slave, name, infos[name], folder)
            limits = isolation or (UNLIMITED if _is_here(infos[name]) else None)
            slaves.append(
                opened() if limits is None else cast(Slave, IsolatedSlave(name, infos[name], opened, limits))
            )
        for slave in slaves:
            if isinstance(slave, IsolatedSlave):
                slave.begin()
    except BaseException:
        found.close()
        raise
    return found


def _is_here(info: ModelInfo) -> bool:
    """Tell whether this process has, or had, the one instance that it may have of an FMU; it now has."""
    if not info.capabilities.once_per_process:
        return False
    fmu = info.model_identifier, info.guid
    known = fmu in _here
    _here.add(fmu)
    return known


def _home(fmu: Path, other: Path) -> Path:
    """Where an FMU is unpacked: one that warmlink keeps is so beside it, once; any other elsewhere."""
    with suppress(InputError):  # where there is no folder to keep anything in
        if fmu.is_relative_to(cache_folder()) and os.access(fmu.parent, os.W_OK):
            return fmu.parent / "unpacked"
    return other


def open_slave(name: str, info: ModelInfo, folder: Path) -> FmiSlave:
    """Instantiate an FMU that was unpacked into `folder`."""
    kind = _KINDS[info.fmi_version, info.interface]
    kind = Fmi3EventSlave if kind is Fmi3Slave and info.capabilities.event_mode else kind
    return kind(name, info, folder)


def initialize(network: Network, experiment: RunSpan, values: Mapping[str, Mapping[str, Value]]) -> None:
    """Set up the experiment, set start values, settle the connected values, leave initialization mode.

    The values are in the variables' own units, by slave and variable. They are set when the experiment is set
    up, for some FMUs then begin with their own. SlaveError where a slave refuses, a value is not finite, or a
    loop does not settle.
    """
    network.time = experiment.start_time
    for slave in network.slaves:
        slave.setup(experiment)
        given = values.get(slave.name)
        if given:
            slave.set(tuple(given), tuple(given.values()))
    for slave in network.slaves:
        slave.enter_initialization()
    settle(network)
    for slave in network.slaves:
        slave.exit_initialization()
    # Some slaves compute their first outputs only on leaving initialization mode.
    for exchange in (network.read, network.write):
        for k in range(len(network.slaves)):
            exchange(k)


def settle(network: Network) -> None:
    """Pass outputs to inputs until nothing changes by more than 1e-12 of its size or nominal value."""
    order = feedthrough_order(network)

    def read(k: int) -> None:  # what is not finite yet may become so
        network.outputs[k] = network.slaves[k].get(network.reads[k]) if network.reads[k] else []

    for k in order:
        read(k)
    for sweep in range(1, SWEEPS + 1):
        network.sweeps = sweep
        moved: list[tuple[str, str]] = []
        for k in order:
            values = network.gather(k)
            changed = _change(network, k, values)
            if changed is not None:
                moved.append((network.slaves[k].name, changed))
                network.put(k, values)
                read(k)
        if not moved:
            return
    told = f"the values connected to it do not settle in {SWEEPS} sweeps of initialization; check the gain"
    told += " of the loop of direct feedthrough that it is part of"
    slave, variable = moved[-1]
    raise SlaveError(slave, "error", network.time, told, variable)


def _change(network: Network, k: int, values: list[Value]) -> str | None:
    """Name the first input whose value is new by more than the tolerance."""
    old = network.inputs[k]
    if not old:
        return network.writes[k][0] if network.writes[k] else None
    variables = network.slaves[k].variables
    for name, before, now, wire in zip(network.writes[k], old, values, network.wires[k], strict=True):
        if before == now or (before != before and now != now):
            continue
        if not wire.real:
            return name
        size = max(nominal(variables[name]), abs(float(now)))
        # Written so that a NaN on one side counts as a change.
        if not abs(float(now) - float(before)) <= TOLERANCE * size:
            return name
    return None
