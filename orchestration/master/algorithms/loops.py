"""Which slaves must be iterated together, and in which order everything is stepped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.master.algorithms.ordering import feedthrough_order
from warmlink.orchestration.master.algorithms.signals import continuous_inputs, is_sampled
from warmlink.orchestration.master.slaves.network import Network


@dataclass(frozen=True)
class Group:
    """Slaves that are stepped together.

    Attributes
    ----------
    members : tuple of int
        Iterated, in the order of a sweep; a single member without a loop needs no iteration.
    followers : tuple of int
        Part of the loop but without state restore: stepped once, when the members have converged.
    torn : tuple of (slave, position)
        Members' inputs that come from a member at the same place or later in the sweep: the unknowns.
    """

    members: tuple[int, ...]
    followers: tuple[int, ...] = ()
    torn: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Plan:
    """The order of a macro step.

    Attributes
    ----------
    groups : tuple of Group
        Continuous slaves, each group after those it takes continuous signals from.
    sampled : tuple of int
        Slaves that act at samples, by direct feedthrough, after the continuous ones.
    remarks : tuple of str
        What slaves without state restore prevent.
    """

    groups: tuple[Group, ...]
    sampled: tuple[int, ...]
    remarks: tuple[str, ...]


def plan(network: Network) -> Plan:
    """Find the loops of continuous signals and order them."""
    count = len(network.slaves)
    order = feedthrough_order(network)
    continuous = [k for k in order if not is_sampled(network.slaves[k])]
    reach = np.eye(count, dtype=bool)
    for k in continuous:
        for position in continuous_inputs(network, k):
            reach[network.wires[k][position].slave, k] = True
    for k in range(count):
        reach |= np.outer(reach[:, k], reach[k, :])
    together = reach & reach.T
    ahead = reach.sum(axis=0)
    groups, remarks, done = [], [], set[int]()
    for k in sorted(continuous, key=lambda k: (ahead[k], order.index(k))):
        if k in done:
            continue
        loop = [j for j in order if together[k, j]]
        done.update(loop)
        group = _group(network, loop)
        groups.append(group)
        if group.followers:
            remarks.append(_remark(network, group))
    sampled = tuple(k for k in order if is_sampled(network.slaves[k]))
    return Plan(tuple(groups), sampled, tuple(remarks))


def _group(network: Network, loop: list[int]) -> Group:
    alone = len(loop) == 1 and all(wire.slave != loop[0] for wire in network.wires[loop[0]])
    if alone:
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
