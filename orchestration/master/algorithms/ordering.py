"""In which order slaves are stepped one after the other."""

from __future__ import annotations

from collections.abc import Sequence

from warmlink.fmus.component.order import stepping_order
from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves.network import Network


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
    """Order the slaves so that each comes after those its outputs depend on at once."""
    return stepping_order(sources(network, feedthrough_only=True), sources(network, feedthrough_only=False))


def named_order(network: Network, names: Sequence[str]) -> tuple[int, ...]:
    """Give the indices of an order stated by names; InputError unless it names each slave once."""
    if sorted(names) != sorted(network.index):
        raise InputError(
            f"order of slaves: {', '.join(names)} is not an order of {', '.join(network.index)}; "
            "name each of them once"
        )
    return tuple(network.index[name] for name in names)
