"""In which order slaves are stepped one after the other."""

from __future__ import annotations

from collections.abc import Sequence

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.network import Network


def feedthrough_inputs(network: Network, k: int) -> frozenset[str]:
    """Give the inputs of a slave that any of its connected outputs depends on at once."""
    dependencies = network.slaves[k].dependencies
    return frozenset().union(*(dependencies.get(name, frozenset()) for name in network.reads[k]))


def sources(network: Network, *, feedthrough_only: bool) -> list[set[int]]:
    """Give for each slave the other slaves that it takes values from."""
    found: list[set[int]] = []
    for k in range(len(network.slaves)):
        direct = feedthrough_inputs(network, k)
        found.append(
            {
                wire.slave
                for name, wire in zip(network.writes[k], network.wires[k], strict=True)
                if wire.slave != k and (not feedthrough_only or name in direct)
            }
        )
    return found


def feedthrough_order(network: Network) -> tuple[int, ...]:
    """Order the slaves so that each comes after those its outputs depend on at once.

    Among the slaves that may come next, the one with the fewest other sources still ahead is taken, then
    the first in the system. In a cycle of direct feedthrough the one with the fewest open dependencies
    goes first, so the order is the same on every machine.
    """
    direct = sources(network, feedthrough_only=True)
    other = sources(network, feedthrough_only=False)
    remaining = list(range(len(network.slaves)))
    order: list[int] = []
    while remaining:
        ahead = set(remaining)
        best = min(remaining, key=lambda k: (len(direct[k] & ahead), len(other[k] & ahead), k))
        order.append(best)
        remaining.remove(best)
    return tuple(order)


def named_order(network: Network, names: Sequence[str]) -> tuple[int, ...]:
    """Give the indices of an order stated by names.

    Raises
    ------
    InputError
        Where a slave is missing, unknown or named twice.
    """
    if sorted(names) != sorted(network.index):
        raise InputError(
            f"order of slaves: {', '.join(names)} is not an order of {', '.join(network.index)}; "
            "name each of them once"
        )
    return tuple(network.index[name] for name in names)
