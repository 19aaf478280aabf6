"""What a system exchanges with a larger one that holds it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
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

    def check(self, system: System) -> None:
        """Raise InputError where one of them is not there, or what stays drives a driver."""
        for name in self.drivers:
            if name not in system.components:
                known = instead(name, system.components)
                raise InputError(f"ports: there is no component {name} to be left out; {known}")
        kept = [name for name in system.components if name not in self.drivers]
        for name, _ in self.shown:
            if name not in kept:
                raise InputError(f"ports: no component {name} is left to be shown; {instead(name, kept)}")
        for link in system.connections:
            if link.source_component in kept and link.target_component not in kept:
                told = f"ports: {link.source} drives {link.target}, which is left out"
                raise InputError(f"{told}; leave out both or neither")


class Opened(NamedTuple):
    """A system without its drivers and its net; the whole net, and which connector stands for what in it."""

    system: System
    net: Net
    whole: Net
    driven: Mapping[str, Node]

    @classmethod
    def by_itself(cls, system: System, net: Net) -> Opened:
        """A system that runs by itself."""
        return cls(system, net, net, {})


def opened(system: System, ports: Ports) -> Opened:
    """Give a system without its drivers, and its net with the connectors that take their place.

    These have the drivers' units: what is done to a value on its way is done to one in that unit.
    InputError as of `Ports.check`.
    """
    ports.check(system)
    kept = {name: held for name, held in system.components.items() if name not in ports.drivers}
    within = [c for c in system.connections if c.target_component in kept]
    cut = [c for c in within if c.source_component not in kept]
    links = tuple(c for c in within if c.source_component in kept)
    inner = replace(system, components=kept, connections=links)
    net = net_of(inner)
    flags = [(name, flag_of(variable)) for name, variable in ports.shown]
    there = [(name, flag) for name, flag in flags if flag in read_description(kept[name].fmu).variables]
    shown, top = (*ports.shown, *there), net.elements[()]
    called = _names((*(link.ends[0] for link in cut), *shown))
    for link in cut:
        edge = replace(edge_of(link), source=Node((), called[link.ends[0]]))
        giving = system.components[link.source_component].connectors[link.source_variable]
        top.connectors[edge.source.connector] = replace(giving, kind="input")
        top.connections.append(edge)
    for name, variable in shown:
        port = called[name, variable]
        top.connectors[port] = replace(net.elements[(name,)].connectors[variable], kind="output")
        top.connections.append(Edge(Node((name,), variable), Node((), port)))
    driven = {called[link.ends[0]]: edge_of(link).source for link in cut}
    return Opened(inner, net, net_of(system), driven)


def _names(ends: Iterable[End]) -> dict[End, str]:
    """Name of the connector for each end: its variable's, with the component's where two would be equal."""
    found = list(dict.fromkeys(ends))
    count = Counter(variable for _, variable in found)
    called = {end: end[1] for end in found if count[end[1]] == 1}
    for name, variable in found:
        port = f"{name}_{variable}"
        while (name, variable) not in called and port in called.values():
            port += "_"
        called.setdefault((name, variable), port)
    return called
