"""What the structure of a network says: what is stepped before what, which signals vary, what forms loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.fmus.component.dependencies import stepping_order
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Slave


def feedthrough_order(network: Network) -> tuple[int, ...]:
    """Order the slaves so that each comes after those its outputs depend on at once."""
    sources: list[set[int]] = []
    direct_sources: list[set[int]] = []
    for k, slave in enumerate(network.slaves):
        direct = frozenset().union(*(slave.dependencies.get(name, frozenset()) for name in network.reads[k]))
        wires = [w for w in zip(network.writes[k], network.wires[k], strict=True) if w[1].slave != k]
        sources.append({wire.slave for _, wire in wires})
        direct_sources.append({wire.slave for name, wire in wires if name in direct})
    return stepping_order(direct_sources, sources)


def is_sampled(slave: Slave) -> bool:
    """Tell whether a slave acts at samples: no output is a continuous Real, or it has a `sample_time`.

    It sees its inputs at its samples alone, so they are neither interpolated nor iterated.
    """
    if "sample_time" in slave.variables:
        return True
    outputs = [v for v in slave.variables.values() if v.causality == "output"]
    return bool(outputs) and not any(v.kind == "Real" and v.variability == "continuous" for v in outputs)


def continuous_inputs(network: Network, k: int) -> tuple[int, ...]:
    """Give the positions among a slave's connected inputs of those that are continuous signals.

    Both ends must be continuous Reals, and the slave must not act at samples.
    """
    slave = network.slaves[k]
    if is_sampled(slave):
        return ()
    ends = [
        (network.source(wire), slave.variables[name])
        for name, wire in zip(network.writes[k], network.wires[k], strict=True)
    ]
    return tuple(
        position
        for position, both in enumerate(ends)
        if all(v.kind == "Real" and v.variability == "continuous" for v in both)
    )


def exchanged(network: Network) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]:
    """Give slave and position of outputs that feed slaves which integrate: the continuous, and the others.

    One that jumps within a step is seen only at its end, too late by part of the step.
    """
    found: tuple[dict[tuple[int, int], None], ...] = {}, {}
    for k, slave in enumerate(network.slaves):
        smooth = continuous_inputs(network, k)
        for position, wire in enumerate(network.wires[k]):
            if not is_sampled(slave):
                found[position not in smooth][wire.slave, wire.position] = None
    return tuple(found[0]), tuple(found[1])


@dataclass(frozen=True)
class Group:
    """Slaves that are stepped together.

    The members are iterated in the order of a sweep. The followers are part of the loop but cannot restore
    their state: they step once, when the members have converged. The torn inputs (slave, position) come from
    a member at the same place or later in the sweep: they are the unknowns.
    """

    members: tuple[int, ...]
    followers: tuple[int, ...] = ()
    torn: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class ExchangePlan:
    """The order of a macro step: groups by what feeds what, then by feedthrough those that act at samples.

    The remarks say what slaves without state restore prevent.
    """

    groups: tuple[Group, ...]
    sampled: tuple[int, ...]
    remarks: tuple[str, ...]


def plan(network: Network) -> ExchangePlan:
    """Find the loops of continuous signals and order them."""
    count = len(network.slaves)
    order = feedthrough_order(network)
    sampled = tuple(k for k in order if is_sampled(network.slaves[k]))
    reach = np.eye(count, dtype=bool)
    for k in range(count):
        for position in continuous_inputs(network, k):
            reach[network.wires[k][position].slave, k] = True
    for k in range(count):
        reach |= np.outer(reach[:, k], reach[k, :])
    together, ahead = reach & reach.T, reach.sum(axis=0)
    groups: list[Group] = []
    done = {*sampled}
    for k in sorted(order, key=lambda k: (ahead[k], order.index(k))):
        if k not in done:
            loop = [j for j in order if together[k, j]]
            done.update(loop)
            groups.append(_group(network, loop))
    remarks = (_remark(network, group) for group in groups if group.followers)
    return ExchangePlan(tuple(groups), sampled, tuple(remarks))


def _group(network: Network, loop: list[int]) -> Group:
    if len(loop) == 1 and all(wire.slave != loop[0] for wire in network.wires[loop[0]]):
        return Group(tuple(loop))
    able = tuple(k for k in loop if network.slaves[k].capabilities.get_set_state)
    torn = tuple(
        (k, position)
        for rank, k in enumerate(able)
        for position in continuous_inputs(network, k)
        if network.wires[k][position].slave in able[rank:]
    )
    return Group(able, tuple(k for k in loop if k not in able), torn)


def _remark(network: Network, group: Group) -> str:
    names = ", ".join(network.slaves[k].name for k in group.followers)
    rest = ", ".join(network.slaves[k].name for k in group.members)
    return (
        f"{names}: cannot restore its state, so it is stepped once, after {rest or 'nothing'}, and its "
        "outputs are held during the step; the coupling through it is of first order"
    )
