"""From connectors to variables: what a component shows, and every connection from end to end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.check import alike, check_kind, check_type, own_unit, variable_of
from warmlink.orchestration.system.model import Connection, Connector
from warmlink.orchestration.system.model_info import ModelInfo, Variable
from warmlink.orchestration.system.ssp.carried import Carried
from warmlink.orchestration.system.ssp.declared import DeclaredConnector
from warmlink.orchestration.system.ssp.flatten import Edge, Flat, Node, Path
from warmlink.orchestration.system.units import Conversion, Unit


@dataclass(frozen=True)
class Resolver:
    """A flat system beside the descriptions of its FMUs, by the components' paths."""

    flat: Flat
    infos: dict[Path, ModelInfo]

    def connectors(self, path: Path) -> tuple[Connector, ...]:
        """Give a component's connectors, checked against its FMU in name, kind, type and unit."""
        return tuple(
            self._connector(node, declared)
            for name, declared in self.flat.components[path].connectors.items()
            for node in self._elements(Node(path, name), declared.sizes)
        )

    def connections(self) -> Iterator[Connection]:
        """Give all connections from an output to an input, through whatever systems lie between.

        InputError where types or quantities do not fit, with both ends and the reason.
        """
        for edge in self.flat.into.values():
            if edge.target.path in self.flat.components:
                way = self.flat.way_to(edge.target)
                if way[0].source.path in self.flat.components:
                    yield from map(self._connection, self._element_by_element(way))

    def variable(self, node: Node) -> tuple[Variable, Unit | None]:
        """Give a component's scalar variable and the unit of its values."""
        info = self.infos[node.path]
        variable = variable_of(info, node.connector, str(node))
        declared = self.flat.components[node.path].connectors.get(node.connector)
        return variable, own_unit(info, variable, declared.unit if declared else None)

    def carry(self, value: Carried, way: Sequence[Edge]) -> Conversion:
        """Give what becomes of a value along connected connectors, up to the variable at their end.

        The value is in the unit in which it enters the first connection; the last edge ends at a component.
        """
        for edge in way:
            value = value.into(
                self._shown_unit(edge.target), edge.transformation, edge.suppress_unit_conversion
            )
        return value.into(self.variable(way[-1].target)[1]).so_far

    def _elements(self, node: Node, sizes: Sequence[int] = ()) -> tuple[Node, ...]:
        """Give the elements of an array, or what is none by itself; `sizes` are those of its connector."""
        names = self.infos[node.path].arrays.get(node.connector, (node.connector,))
        if sizes and math.prod(sizes) != len(names):
            raise InputError(
                f"{node}: is declared with {math.prod(sizes)} elements, but has {len(names)} in its FMU; "
                "correct one"
            )
        return tuple(Node(node.path, name) for name in names)

    def _element_by_element(self, way: Sequence[Edge]) -> Iterator[Sequence[Edge]]:
        """Give a way between arrays as one for each element."""
        sources, targets = self._elements(way[0].source), self._elements(way[-1].target)
        if len(sources) != len(targets):
            raise InputError(
                f"{way[0].source} -> {way[-1].target}: {len(sources)} and {len(targets)} elements; "
                "connect arrays of one size"
            )
        for source, target in zip(sources, targets, strict=True):
            each = [*way]
            each[0] = replace(each[0], source=source)
            each[-1] = replace(each[-1], target=target)
            yield each

    def _connector(self, node: Node, declared: DeclaredConnector) -> Connector:
        where = str(node)
        variable, unit = self.variable(node)
        check_kind(variable, declared.kind, where)
        check_type(variable, declared.type, where)
        remedy = "declare the connector in a unit of its variable"
        Carried(where, remedy, unit, variable.relative).into(declared.unit)
        assert variable.kind is not None  # variable_of has seen to it
        return Connector(node.connector, declared.kind, variable.kind, unit.name if unit else None)

    def _shown_unit(self, node: Node) -> Unit | None:
        """Give the unit that a connector shows to those connected with it."""
        declared = self.flat.connector(node)
        if declared is not None and declared.unit is not None:
            return declared.unit
        return self.variable(node)[1] if node.path in self.flat.components else None

    def _connection(self, way: Sequence[Edge]) -> Connection:
        source, target = way[0].source, way[-1].target
        (giving, unit), (taking, target_unit) = self.variable(source), self.variable(target)
        between = f"{source} -> {target}"
        both = giving.kind == taking.kind == "Enumeration"
        if not alike(giving.kind, taking.kind) or (both and giving.items != taking.items):
            kinds = f"{giving.kind} does not convert to {taking.kind}"
            raise InputError(f"{between}: {kinds}; connect variables of one type")
        remedy = "connect variables of one quantity"
        found = [
            self.carry(Carried(between, remedy, unit, difference).into(self._shown_unit(source)), way)
            for difference in (giving.relative, taking.relative)
        ]
        if found[0] != found[1]:
            ends = ["a difference" if v.relative else "a temperature" for v in (giving, taking)]
            told = f"{ends[0]} in {_name(unit)} does not convert to {ends[1]} in {_name(target_unit)}"
            raise InputError(f"{between}: {told}; connect two differences or two temperatures")
        if giving.kind != "Real" and not found[0].identity:
            told = f"a linear transformation needs Real variables, these are {giving.kind}"
            raise InputError(f"{between}: {told}; remove it")
        names = ".".join(source.path), source.connector, ".".join(target.path), target.connector
        return Connection(*names, found[0].factor, found[0].offset)


def _name(unit: Unit | None) -> str:
    return unit.name if unit else "no unit"
