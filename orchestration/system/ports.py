"""What a system exchanges with a larger one that holds it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from warmlink.fmus.packaging.views import flag_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.ssp.net import Edge, Net, Node, edge_of, net_of

End = tuple[str, str]
"""Name of a component and of one of its variables."""


@dataclass(frozen=True)
class Ports:
    """What a system exchanges with a larger one that holds it.

    An input of the system takes the place of each output of the `drivers`, which are left out; outputs of the
    system pass on what is `shown`, as `("link", "elongation")`.
    """

    drivers: tuple[str, ...]
    shown: tuple[End, ...]


def opened(system: System, ports: Ports) -> tuple[System, Net]:
    """Give a system without its drivers, and its net with the connectors that take their place."""
    kept = {name: held for name, held in system.components.items() if name not in ports.drivers}
    cut = [c for c in system.connections if c.source_component not in kept]
    links = tuple(c for c in system.connections if c.source_component in kept)
    inner = replace(system, components=kept, connections=links)
    net = net_of(inner)
    flags = [(name, flag_of(variable)) for name, variable in ports.shown]
    there = [(name, flag) for name, flag in flags if flag in read_description(kept[name].fmu).variables]
    shown, top = (*ports.shown, *there), net.elements[()]
    called = _names((*(link.ends[0] for link in cut), *shown))
    for link in cut:
        edge = replace(edge_of(link), source=Node((), called[link.ends[0]]))
        taking = net.elements[edge.target.path].connectors[edge.target.connector]
        top.connectors.setdefault(edge.source.connector, replace(taking, kind="input"))
        top.connections.append(edge)
    for name, variable in shown:
        port = called[name, variable]
        top.connectors[port] = replace(net.elements[(name,)].connectors[variable], kind="output")
        top.connections.append(Edge(Node((name,), variable), Node((), port)))
    return inner, net


def _names(ends: Iterable[End]) -> dict[End, str]:
    """Name of the connector for each end: its variable's, with the component's where two would be equal."""
    found = list(dict.fromkeys(ends))
    count = Counter(variable for _, variable in found)
    return {(name, v): v if count[v] == 1 else f"{name}_{v}" for name, v in found}
