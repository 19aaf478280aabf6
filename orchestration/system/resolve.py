"""From connectors to variables: every connection end to end, every start value in its variable's own unit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.check import (
    check_kind,
    check_type,
    checked_value,
    own_unit,
    variable_of,
)
from warmlink.orchestration.system.declared import Binding, DeclaredComponent, DeclaredSystem
from warmlink.orchestration.system.description import ModelInfo, Variable
from warmlink.orchestration.system.flatten import Edge, Flat, Node, Path
from warmlink.orchestration.system.model import Connection, Connector, Value
from warmlink.orchestration.system.parameter_values import Parameter
from warmlink.orchestration.system.units import Conversion, Unit, conversion


@dataclass
class Resolver:
    """A flat system beside the descriptions of its FMUs, by the components' paths.

    Parameters
    ----------
    remarks
        Filled on the way: what the standard lets a reader pass over.
    """

    flat: Flat
    infos: dict[Path, ModelInfo]
    remarks: list[str] = field(default_factory=list)

    def connectors(self, path: Path) -> tuple[Connector, ...]:
        """Give a component's connectors, checked against its FMU.

        Raises
        ------
        InputError
            If one does not fit in name, kind, type or unit.
        """
        return tuple(self._connector(Node(path, name)) for name in self.flat.components[path].connectors)

    def connections(self) -> Iterator[Connection]:
        """Give all connections from an output to an input, through whatever systems lie between.

        Raises
        ------
        InputError
            If types or quantities do not fit, with both ends and the reason.
        """
        for edge in self.flat.into.values():
            if edge.target.path not in self.flat.components:
                continue
            way = self.flat.way_to(edge.target)
            if way[0].source.path in self.flat.components:
                yield self._connection(way)

    def values(self, path: Path = ()) -> dict[Path, dict[str, Value]]:
        """Give the start values of all components below a system; outer bindings and later ones win.

        Raises
        ------
        InputError
            If a value does not fit the variable it goes to.
        """
        system = self.flat.systems[path]
        found: dict[Path, dict[str, Value]] = {}
        for name, element in system.elements.items():
            inner = (*path, name)
            if isinstance(element, DeclaredSystem):
                found.update(self.values(inner))
            else:
                found[inner] = {}
                self._bind(element, inner, found)
        self._bind(system, path, found)
        return found

    def _connector(self, node: Node) -> Connector:
        declared = self.flat.components[node.path].connectors[node.connector]
        where = str(node)
        variable = variable_of(self.infos[node.path], declared.name, where)
        check_kind(variable, declared.kind, where)
        check_type(variable, declared.type, where)
        unit = own_unit(self.infos[node.path], variable, declared.unit)
        if unit is not None and declared.unit is not None:
            try:
                conversion(unit, declared.unit, variable.relative)
            except InputError as fault:
                raise InputError(
                    f"{where}: the FMU's {fault}; declare the connector in a unit of its own"
                ) from None
        assert variable.kind is not None  # variable_of has seen to it
        return Connector(declared.name, declared.kind, variable.kind, unit.name if unit else None)  # type: ignore[arg-type]

    def _variable(self, node: Node) -> tuple[Variable, Unit | None]:
        """Give a component's variable and the unit of its values."""
        info = self.infos[node.path]
        variable = variable_of(info, node.connector, str(node))
        declared = self.flat.components[node.path].connectors.get(node.connector)
        return variable, own_unit(info, variable, declared.unit if declared else None)

    def _connection(self, way: list[Edge]) -> Connection:
        source, target = way[0].source, way[-1].target
        giving, unit = self._variable(source)
        taking, target_unit = self._variable(target)
        between = f"{source} -> {target}"
        if giving.kind != taking.kind or (giving.kind == "Enumeration" and giving.items != taking.items):
            kinds = f"{giving.kind} does not convert to {taking.kind}"
            raise InputError(f"{between}: {kinds}; connect variables of one type")
        whole = [
            self._convert_along(way, unit, target_unit, difference, between)
            for difference in {giving.relative, taking.relative}
        ]
        if any(other != whole[0] for other in whole):
            raise InputError(
                f"{between}: one end is a difference and the other is not, and {_name(unit)} and "
                f"{_name(target_unit)} start from different zeros; a temperature difference is in K"
            )
        if giving.kind != "Real" and not whole[0].identity:
            raise InputError(
                f"{between}: a linear transformation needs Real variables, these are {giving.kind}"
            )
        return Connection(
            ".".join(source.path),
            source.connector,
            ".".join(target.path),
            target.connector,
            whole[0].factor,
            whole[0].offset,
        )

    def _convert_along(
        self, way: list[Edge], unit: Unit | None, target_unit: Unit | None, difference: bool, between: str
    ) -> Conversion:
        """Give what becomes of a value on its way: into each connector's unit, then transformed there."""
        total, first = Conversion(), way[0].source
        declared = self.flat.connector(first)
        total, unit = _hop(total, unit, declared.unit if declared else None, None, False, difference, between)
        for edge in way:
            declared = self.flat.connector(edge.target)
            total, unit = _hop(
                total,
                unit,
                declared.unit if declared and declared.unit else self._own_or_none(edge.target),
                edge.transformation,
                edge.suppress_unit_conversion,
                difference,
                between,
            )
        return _hop(total, unit, target_unit, None, False, difference, between)[0]

    def _own_or_none(self, node: Node) -> Unit | None:
        return self._variable(node)[1] if node.path in self.flat.components else None

    def _bind(
        self, owner: DeclaredComponent | DeclaredSystem, path: Path, found: dict[Path, dict[str, Value]]
    ) -> None:
        for binding in owner.bindings:
            for parameter, target, transformation, suppress in self._mapped(binding):
                nodes = list(self._named(owner, path, target))
                if not nodes and binding.mapping is not None:
                    raise InputError(f"{binding.where}: its mapping names {target}, which does not exist")
                if not nodes:
                    self.remarks.append(
                        f"{binding.where}: {target} is the name of no variable and has no effect"
                    )
                for node in nodes:
                    step = Edge(node, node, transformation, suppress)
                    self._deliver(step, parameter, Conversion(), parameter.unit, found, 0)

    def _mapped(self, binding: Binding) -> Iterator[tuple[Parameter, str, Conversion | None, bool]]:
        if binding.mapping is None:
            yield from ((p, p.name, None, False) for p in binding.parameters)
            return
        by_name = {p.name: p for p in binding.parameters}
        for entry in binding.mapping:
            parameter = by_name.get(entry.source)
            if parameter is None:
                self.remarks.append(f"{binding.where}: its mapping names {entry.source}, which has no value")
                continue
            yield parameter, entry.target, entry.transformation, entry.suppress_unit_conversion

    def _named(self, owner: DeclaredComponent | DeclaredSystem, path: Path, name: str) -> Iterator[Node]:
        """Give whatever bears a hierarchical name below an element (SSP 5.2.3: possibly several)."""
        if isinstance(owner, DeclaredComponent):
            if name in self.infos[path].variables:
                yield Node(path, name)
            return
        if name in owner.connectors:
            yield Node(path, name)
        for inner, element in owner.elements.items():
            if name.startswith(f"{inner}."):
                yield from self._named(element, (*path, inner), name[len(inner) + 1 :])

    def _deliver(
        self,
        edge: Edge,
        parameter: Parameter,
        so_far: Conversion,
        unit: Unit | None,
        found: dict[Path, dict[str, Value]],
        depth: int,
    ) -> None:
        """Carry a start value to a variable, or through a system's connector to all that it drives."""
        node, where = edge.target, str(edge.target)
        if depth > 100:
            raise InputError(f"{where}: the connectors of systems drive each other in a circle")
        if node.path in self.flat.components:
            self._set(edge, parameter, so_far, unit, found[node.path])
            return
        declared = self.flat.connector(node)
        if declared is None or (depth == 0 and declared.kind not in ("input", "parameter")):
            kind = declared.kind if declared else "absent"
            raise InputError(f"{where}: takes no start value, being {kind}; set an input or parameter")
        carried = _hop(
            so_far, unit, declared.unit, edge.transformation, edge.suppress_unit_conversion, False, where
        )
        onward = self.flat.out_of.get(node, [])
        if not onward and depth == 0:
            self.remarks.append(f"{where}: has a start value but drives nothing")
        for following in onward:
            self._deliver(following, parameter, *carried, found, depth + 1)

    def _set(
        self,
        edge: Edge,
        parameter: Parameter,
        so_far: Conversion,
        unit: Unit | None,
        values: dict[str, Value],
    ) -> None:
        where = str(edge.target)
        variable, own = self._variable(edge.target)
        value = parameter.value
        _check_types(parameter, variable, where)
        whole = so_far
        if variable.kind == "Real":
            declared = self.flat.connector(edge.target)
            inside = declared.unit if declared and declared.unit and edge.source != edge.target else own
            whole, unit = _hop(
                so_far,
                unit,
                inside,
                edge.transformation,
                edge.suppress_unit_conversion,
                variable.relative,
                where,
            )
            whole, _ = _hop(whole, unit, own, None, False, variable.relative, where)
            value = whole(float(value))
        elif edge.transformation is not None and not edge.transformation.identity:
            raise InputError(f"{where}: a linear transformation needs a Real, this is {variable.kind}")
        values[variable.name] = checked_value(variable, value, where)


def _check_types(parameter: Parameter, variable: Variable, where: str) -> None:
    if parameter.type != variable.kind:
        raise InputError(
            f"{where}: is given a value of type {parameter.type}, but is of type {variable.type}"
        )


def _hop(
    so_far: Conversion,
    unit: Unit | None,
    to: Unit | None,
    transformation: Conversion | None,
    suppress: bool,
    difference: bool,
    where: str,
) -> tuple[Conversion, Unit | None]:
    """Take a value into the next connector: first its unit, then the transformation (SSP 4.5.2)."""
    if unit is not None and to is not None and not suppress:
        try:
            step = conversion(unit, to, difference)
        except InputError as fault:
            raise InputError(f"{where}: {fault}; connect variables of one quantity") from None
        so_far = so_far.then(step.factor, step.offset)
    if transformation is not None:
        so_far = so_far.then(transformation.factor, transformation.offset)
    # A transformed value is in the unit of the connector it reaches, or in none that is known.
    return so_far, to or (unit if transformation is None else None)


def _name(unit: Unit | None) -> str:
    return unit.name if unit else "no unit"
