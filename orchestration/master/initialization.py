"""From start values to consistent values at the first communication point."""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.orchestration.master.algorithms.structure import feedthrough_order
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.system.model import Value

TOLERANCE = 1e-12
SWEEPS = 200


def initialize(
    network: Network, points: CommunicationPoints, values: Mapping[str, Mapping[str, Value]]
) -> None:
    """Set start values, settle the connected values, leave initialization mode.

    The values are in the variables' own units, by slave and variable. SlaveError where a slave refuses, a
    value is not finite, or a loop does not settle.
    """
    network.time = points.start_time
    for slave in network.slaves:
        given = values.get(slave.name)
        if given:
            slave.set(tuple(given), tuple(given.values()))
    for slave in network.slaves:
        slave.enter_initialization(points.start_time, points.stop_time)
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
    told = (
        f"the values connected to it do not settle in {SWEEPS} sweeps of initialization; "
        "check the gain of the loop of direct feedthrough that it is part of"
    )
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
