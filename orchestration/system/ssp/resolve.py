"""From connectors to variables: what components show, connections from end to end, start values.

A value that passes a connector is converted into its unit first, and then transformed (SSP 4.5.2). Of several
start values for one variable that of the outer binding counts, or the later one (SSP 5.2.3).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.system.check import alike, check_connector, checked_value, own_unit, variable_of
from warmlink.orchestration.system.model import Connection, Connector, FmuVariable, Value
from warmlink.orchestration.system.ssp.net import Edge, Net, Node, Path, ValueMap
from warmlink.orchestration.system.ssp.parameter_values import SsvValue
from warmlink.orchestration.system.units import IDENTITY, Conversion, QuantityError, Unit, conversion


@dataclass(frozen=True)
class Binding:
    """One parameter binding of an element: values by name, and the mapping of names if there is one."""

    path: Path
    parameters: dict[str, SsvValue]
    mapping: tuple[Edge, ...] | None
    where: str


@dataclass(frozen=True)
class _Carried:
    """A value under way: its unit by now, None where it is not known, and what has become of it so far.

    `where` and `remedy` are for an error, `remarks` for what is passed over; the zeros of scales do not apply
    to a `difference`.
    """

    remarks: list[str]
    where: str
    remedy: str
    unit: Unit | None
    difference: bool
    so_far: Conversion = IDENTITY

    def into(self, unit: Unit | None, edge: Edge | None = None) -> _Carried:
        """Take the value along an edge into a connector with a unit, None where it tells none."""
        so_far = self.so_far
        if self.unit is not None and unit is not None and not (edge and edge.suppress_unit_conversion):
            try:
                step = conversion(self.unit, unit, self.difference)
            except InputError as fault:
                remedy = f"; {self.remedy}" if isinstance(fault, QuantityError) else ""
                if not (self.unit.dash or unit.dash):
                    raise InputError(f"{self.where}: {fault}{remedy}") from None
                other = self.unit if unit.dash else unit
                self.remarks.append(f"{self.where}: the unit - is read as none, beside {other.name}")
                step, unit = IDENTITY, other
            so_far = so_far.then(step.factor, step.offset)
        if edge is None or edge.transformation is None:
            return replace(self, unit=unit or self.unit, so_far=so_far)
        # What is transformed is in the unit of the connector it reaches, or in none that is known.
        so_far = so_far.then(edge.transformation.factor, edge.transformation.offset)
        return replace(self, unit=unit, so_far=so_far)


@dataclass
class Resolver:
    """A net beside the variables of its FMUs.

    The bindings of inner elements come before those of the systems around them. It gathers `remarks` on what
    the standard lets a reader pass over.
    """

    net: Net
    bindings: Sequence[Binding] = ()
    remarks: list[str] = field(default_factory=list)

    def connectors(self, path: Path) -> dict[str, Connector]:
        """Give a component's connectors by name, checked against its FMU in name, kind, type and unit.

        One that is no variable of the FMU is left out where nothing is connected to it.
        """
        found, info = {}, self.net.info(Node(path, ""))
        assert info is not None
        for name, declared in self.net.elements[path].connectors.items():
            node = Node(path, name)
            if name not in info.variables and node not in self.net.connected:
                told = f"declared as a connector, but no variable of {info.path.name}; it is left out"
                self.remarks.append(f"{node}: {told}")
                continue
            variable, unit = self.variable(node)
            kind = check_connector(variable, declared.kind, declared.type, str(node))
            remedy = "declare the connector in a unit of its variable"
            _Carried(self.remarks, str(node), remedy, unit, variable.relative).into(declared.unit)
            found[name] = Connector(declared.kind, kind, unit)
        return found

    def connections(self) -> Iterator[Connection]:
        """Give all connections from an output to an input, through whatever systems lie between.

        InputError where types or quantities do not fit, with both ends and the reason.
        """
        for way in self.net.ways:
            if self.net.info(way[0].source) is not None:
                yield self._connection(way)

    def start_values(self, causality: str | None = None) -> dict[Path, dict[str, Value]]:
        """Give start values, of one causality or of all, by component in its variables' own units."""
        found: dict[Path, dict[str, Value]] = {path: {} for path in self.net.components}
        for binding in self.bindings:
            for parameter, entering in self._entering(binding):
                for way in self._onward(entering):
                    end = way[-1].target
                    if causality in (None, self.variable(end)[0].causality):
                        variable, value = self._started(parameter, way)
                        found[end.path][variable.name] = value
        return found

    def _entering(self, binding: Binding) -> Iterator[tuple[SsvValue, Edge]]:
        """Give each value with each connector that it enters; a mapping decides alone, where there is one."""
        edges: Iterable[Edge] = (Edge(name, name) for name in (Node((), each) for each in binding.parameters))
        for edge in edges if binding.mapping is None else binding.mapping:
            name, told = edge.target.connector, edge.source.connector
            if told not in binding.parameters:
                self.remarks.append(f"{binding.where}: its mapping names {told!r}, which has no value")
                continue
            nodes = list(self._named(binding.path, name))
            if not nodes:
                told = name if binding.mapping is None else f"{name}, to which its mapping leads,"
                self.remarks.append(f"{binding.where}: {told} is the name of no variable and has no effect")
            if nodes and binding.parameters[told].contradiction:
                raise InputError(binding.parameters[told].contradiction)
            for node in nodes:
                yield binding.parameters[told], replace(edge, source=node, target=node)

    def _named(self, path: Path, name: str) -> Iterator[Node]:
        """Give whatever bears a hierarchical name below an element; the standard allows several."""
        element = self.net.elements[path]
        if name in (element.connectors if element.info is None else element.info.variables):
            yield Node(path, name)
        if element.info is None:
            for inner in self.net.inside[path]:
                if name.startswith(f"{inner[-1]}."):
                    yield from self._named(inner, name[len(inner[-1]) + 1 :])

    def _onward(self, entering: Edge) -> list[list[Edge]]:
        """Give the ways of a start value to a variable, or through a system's connector to all it drives."""
        node = entering.target
        if self.net.info(node) is not None:
            return [[entering]]
        declared = self.net.declared(node)
        kind = declared.kind if declared else "absent"
        if kind not in ("input", "parameter"):
            raise InputError(f"{node}: takes no start value, being {kind}; set an input or parameter")
        ways = [[entering, *way] for way in self.net.onward.get(node, ())]
        if not ways:
            self.remarks.append(f"{node}: has a start value but drives nothing")
        return ways

    def _started(self, parameter: SsvValue, way: Sequence[Edge]) -> tuple[FmuVariable, Value]:
        """Give the variable at the end of a way, and the start value that it gets."""
        node = way[-1].target
        variable, own = self.variable(node)
        if not alike(parameter.type, variable.kind):
            raise InputError(
                f"{node}: is given a value of type {parameter.type}, but is of type {variable.type}; "
                "give a value of that type"
            )
        remedy = "give the value in a unit of its variable"
        carried = _Carried(self.remarks, str(node), remedy, parameter.unit, variable.relative)
        # A binding that names the variable itself does so whatever unit its connector shows.
        change = carried.into(own, way[0]).so_far if len(way) == 1 else self._carry(carried, way)
        value = parameter.value
        if parameter.elements > 1 and variable.elements not in (1, parameter.elements):
            counts = f"{parameter.elements} values for {variable.elements} elements"
            raise InputError(f"{node}: is given {counts}; give one for each")
        for values in (edge.values for edge in way if edge.values):
            if values.kind == "Integer" and isinstance(value, str):
                value = variable.items.get(value, value)
            value = values.applied(value)
        if variable.kind == "Real":
            value = change(float(value))
        elif not change.identity:
            raise InputError(
                f"{node}: a linear transformation needs a Real, this is {variable.kind}; remove it"
            )
        return variable, checked_value(variable, value, str(node))

    def variable(self, node: Node) -> tuple[FmuVariable, Unit | None]:
        """Give a component's scalar variable and the unit of its values."""
        info, declared = self.net.info(node), self.net.declared(node)
        assert info is not None
        variable = variable_of(info, node.connector, str(node))
        return variable, own_unit(info, variable, declared.unit if declared else None)

    def _shown_unit(self, node: Node) -> Unit | None:
        """Give the unit that a connector shows to those connected with it."""
        declared = self.net.declared(node)
        if declared is not None and declared.unit is not None:
            return declared.unit
        return None if self.net.info(node) is None else self.variable(node)[1]

    def _carry(self, value: _Carried, way: Sequence[Edge]) -> Conversion:
        """Give what becomes of a value along connected connectors, up to the variable at their end."""
        for edge in way:
            value = value.into(self._shown_unit(edge.target), edge)
        return value.into(self.variable(way[-1].target)[1]).so_far

    def _connection(self, way: Sequence[Edge]) -> Connection:
        source, target = way[0].source, way[-1].target
        (giving, unit), (taking, target_unit) = self.variable(source), self.variable(target)
        between = f"{source} -> {target}"
        values = _mapped(giving, taking, [edge.values for edge in way if edge.values], between)
        both = giving.kind == taking.kind == "Enumeration" and not values
        if not alike(giving.kind, taking.kind) or (both and giving.items != taking.items):
            kinds = f"{giving.kind} does not convert to {taking.kind}"
            raise InputError(f"{between}: {kinds}; connect variables of one type")
        remedy = "connect variables of one quantity"
        found = [
            self._carry(
                _Carried(self.remarks, between, remedy, unit, difference).into(self._shown_unit(source)), way
            )
            for difference in (giving.relative, taking.relative)
        ]
        if found[0] != found[1]:
            ends = [
                f"a {'difference' if each.relative else 'temperature'} in {own.name if own else 'no unit'}"
                for each, own in ((giving, unit), (taking, target_unit))
            ]
            told = " does not convert to ".join(ends)
            raise InputError(f"{between}: {told}; connect two differences or two temperatures")
        if giving.kind != "Real" and not found[0].identity:
            told = f"a linear transformation needs Real variables, these are {giving.kind}"
            raise InputError(f"{between}: {told}; remove it")
        names = ".".join(source.path), source.connector, ".".join(target.path), target.connector
        return Connection(*names, found[0].factor, found[0].offset, values)


def _mapped(
    giving: FmuVariable, taking: FmuVariable, maps: Sequence[ValueMap], where: str
) -> tuple[tuple[Value, Value], ...]:
    """Give what becomes of values under tables one after another; those that stay as they are left out.

    InputError if a table is of another type than the variables, or names no item of theirs.
    """
    integers = ("Integer", "Enumeration")
    found: list[dict[Value, Value]] = []
    for each in maps:
        fits = {"Boolean": ("Boolean",), "Integer": integers, "Enumeration": ("Enumeration",)}[each.kind]
        if not {giving.kind, taking.kind} <= set(fits):
            told = f"a table of {each.kind} values does not map {giving.kind} to {taking.kind}"
            raise InputError(f"{where}: {told}; remove it or choose another")
        entries = dict(each.entries)
        if each.kind == "Enumeration":
            for name in entries.values():
                if name not in taking.items:
                    raise InputError(
                        f"{where}: {name!r} is no item there; {instead(str(name), taking.items)}"
                    )
            entries = {
                giving.items[str(source)]: taking.items[str(target)]
                for source, target in entries.items()
                if source in giving.items
            }
        found.append(entries)
    sources = dict.fromkeys(source for entries in found for source in entries)
    results = {
        source: reduce(lambda value, table: table.get(value, value), found, source) for source in sources
    }
    return tuple((source, target) for source, target in results.items() if source != target)
