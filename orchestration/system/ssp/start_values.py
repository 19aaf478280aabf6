"""Parameter bindings resolved: every start value in its variable's own unit (SSP section 5.2.3)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.check import alike, checked_value
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.ssp.carried import Carried
from warmlink.orchestration.system.ssp.declared import Binding, DeclaredComponent, DeclaredSystem
from warmlink.orchestration.system.ssp.flatten import Edge, Node, Path
from warmlink.orchestration.system.ssp.parameter_values import MappingEntry, Parameter
from warmlink.orchestration.system.ssp.resolve import Resolver


@dataclass
class StartValues:
    """The start values of all components, collected from the innermost bindings to the outermost.

    Parameters
    ----------
    resolver
        Knows variables, units and what a system's connector drives.
    found
        Values by component and variable.
    remarks
        What the standard lets a reader pass over.
    """

    resolver: Resolver
    found: dict[Path, dict[str, Value]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def collect(self, path: Path = ()) -> None:
        """Collect below one system; outer bindings and later ones win."""
        system = self.resolver.flat.systems[path]
        for name, element in system.elements.items():
            inner = (*path, name)
            if isinstance(element, DeclaredSystem):
                self.collect(inner)
            else:
                self.found[inner] = {}
                self._bind(element, inner)
        self._bind(system, path)

    def _bind(self, owner: DeclaredComponent | DeclaredSystem, path: Path) -> None:
        for binding in owner.bindings:
            for parameter, entry in self._mapped(binding):
                nodes = list(self._named(owner, path, entry.target))
                if not nodes and binding.mapping is not None:
                    raise InputError(
                        f"{binding.where}: its mapping names {entry.target}, which does not exist; correct it"
                    )
                if not nodes:
                    told = f"{entry.target} is the name of no variable and has no effect"
                    self.remarks.append(f"{binding.where}: {told}")
                for node in nodes:
                    self._give(
                        parameter, Edge(node, node, entry.transformation, entry.suppress_unit_conversion)
                    )

    def _mapped(self, binding: Binding) -> Iterator[tuple[Parameter, MappingEntry]]:
        """Give each value with the name it goes to; a mapping, where there is one, decides alone."""
        if binding.mapping is None:
            yield from ((p, MappingEntry(p.name, p.name)) for p in binding.parameters)
            return
        by_name = {p.name: p for p in binding.parameters}
        for entry in binding.mapping:
            if entry.source in by_name:
                yield by_name[entry.source], entry
            else:
                self.remarks.append(f"{binding.where}: its mapping names {entry.source}, which has no value")

    def _named(self, owner: DeclaredComponent | DeclaredSystem, path: Path, name: str) -> Iterator[Node]:
        """Give whatever bears a hierarchical name below an element; the standard allows several."""
        if isinstance(owner, DeclaredComponent):
            if name in self.resolver.infos[path].variables:
                yield Node(path, name)
            return
        if name in owner.connectors:
            yield Node(path, name)
        for inner, element in owner.elements.items():
            if name.startswith(f"{inner}."):
                yield from self._named(element, (*path, inner), name[len(inner) + 1 :])

    def _give(self, parameter: Parameter, entering: Edge) -> None:
        """Give a value to a variable, or through a system's connector to all that it drives."""
        flat, node = self.resolver.flat, entering.target
        if node.path in flat.components:
            self._set(parameter, [entering])
            return
        declared = flat.connector(node)
        kind = declared.kind if declared else "absent"
        if kind not in ("input", "parameter"):
            raise InputError(f"{node}: takes no start value, being {kind}; set an input or parameter")
        ways = list(self._ways([entering]))
        if not ways:
            self.remarks.append(f"{node}: has a start value but drives nothing")
        for way in ways:
            self._set(parameter, way)

    def _ways(self, way: list[Edge]) -> Iterator[list[Edge]]:
        """Give the ways onward from a system's connector to the variables of components."""
        flat, node = self.resolver.flat, way[-1].target
        if node.path in flat.components:
            yield way
            return
        for edge in flat.out_of.get(node, []):
            if any(edge is passed for passed in way):
                raise InputError(f"{edge}: the connectors of systems drive each other in a circle")
            yield from self._ways([*way, edge])

    def _set(self, parameter: Parameter, way: list[Edge]) -> None:
        node = way[-1].target
        where = str(node)
        variable, own = self.resolver.variable(node)
        if not alike(parameter.type, variable.kind):
            raise InputError(
                f"{where}: is given a value of type {parameter.type}, but is of type {variable.type}; "
                "give a value of that type"
            )
        value = parameter.value
        carried = Carried(
            where, "give the value in a unit of its variable", parameter.unit, variable.relative
        )
        if len(way) == 1:
            # A binding names the variable itself, whatever unit its connector shows.
            change = carried.into(own, way[0].transformation, way[0].suppress_unit_conversion).so_far
        else:
            change = self.resolver.carry(carried, way)
        if variable.kind == "Real":
            value = change(float(value))
        elif not change.identity:
            raise InputError(
                f"{where}: a linear transformation needs a Real, this is {variable.kind}; remove it"
            )
        self.found[node.path][variable.name] = checked_value(variable, value, where)
