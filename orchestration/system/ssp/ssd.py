"""Reading an SSD into the tree of systems and components that it declares (SSP section 5).

What the rest cannot make use of is refused here, by name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args
from urllib.parse import unquote, urlsplit

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system import archive
from warmlink.orchestration.system.model import ConnectorKind, DefaultExperiment
from warmlink.orchestration.system.ssp.declared import (
    Binding,
    DeclaredComponent,
    DeclaredConnection,
    DeclaredConnector,
    DeclaredSystem,
    Description,
)
from warmlink.orchestration.system.ssp.elements import (
    check_root,
    children,
    only_child,
    refuse_other_children,
    root_of_file,
)
from warmlink.orchestration.system.ssp.parameter_values import (
    Parameter,
    parameter_mapping,
    parameter_set,
    transformation,
)
from warmlink.orchestration.system.units import Unit, definitions_of_units
from warmlink.orchestration.system.xml import boolean, integer, local, optional_number, required
from warmlink.orchestration.text_files import is_file

FMU_TYPE = "application/x-fmu-sharedlibrary"
DEFINITION_TYPE = "application/x-ssp-definition"
PACKAGE_TYPE = "application/x-ssp-package"
# Each level may hold the next one several times over, so few levels can already be many components.
_DEEPEST = 8


def read_ssd(path: Path, workdir: Path, enclosing: tuple[Path, ...] = ()) -> Description:
    """Read an SSD file that lies in an unpacked SSP, with all that it refers to.

    Relative sources are looked up from its folder, and never outside; packages inside the package are
    unpacked into `workdir`. `enclosing` are the .ssd files whose systems hold this one.
    """
    if path in enclosing:
        raise InputError(f"{path.name}: holds itself as a component; take it out")
    if len(enclosing) > _DEEPEST:
        raise InputError(f"{path.name}: lies more than {_DEEPEST} descriptions deep; make the system flatter")
    return _Reader(path, workdir, enclosing).read()


class _Reader:
    """Where one SSD lies and which units it defines: what all of its parts are read with."""

    def __init__(self, path: Path, workdir: Path, enclosing: tuple[Path, ...]) -> None:
        self.path = path
        self.base = path.parent
        self.workdir = workdir
        self.enclosing = enclosing
        self.where = path.name
        self.units: dict[str, Unit] = {}

    def read(self) -> Description:
        root = root_of_file(self.path, "SystemStructureDescription", self.where)
        parts = ("System", "Enumerations", "Units", "DefaultExperiment", "Annotations", "MetaData")
        refuse_other_children(root, parts, self.where)
        self.units = definitions_of_units(only_child(root, "Units"), self.where)
        top = only_child(root, "System")
        if top is None:
            raise InputError(f"{self.where}: holds no System; there is nothing to simulate")
        experiment = _experiment(only_child(root, "DefaultExperiment"), self.where)
        name = root.get("name") or top.get("name") or self.path.stem
        return Description(name, self.system(top, ""), experiment, self.units)

    def system(self, element: Any, path: str) -> DeclaredSystem:
        where = path or self.where
        parts = ("Connectors", "ElementGeometry", "ParameterBindings", "Elements", "Connections")
        drawn = ("SystemGeometry", "GraphicalElements", "Annotations", "MetaData")
        refuse_other_children(element, parts + drawn, where)
        elements: dict[str, DeclaredComponent | DeclaredSystem] = {}
        for child in _items(element, "Elements"):
            name = required(child, "name", where)
            if not name or name in elements:
                raise InputError(
                    f"{where}: holds two elements named {name!r}, or one without name; rename one"
                )
            elements[name] = self.element(child, f"{path}.{name}" if path else name)
        return DeclaredSystem(
            name=element.get("name", ""),
            connectors=self.connectors(element, path),
            bindings=self.bindings(element, where),
            elements=elements,
            connections=tuple(self.connection(c, path) for c in _items(element, "Connections", "Connection")),
        )

    def element(self, element: Any, path: str) -> DeclaredComponent | DeclaredSystem:
        readers: dict[str, Callable[[Any, str], DeclaredComponent | DeclaredSystem]] = {
            "System": self.system,
            "Component": self.component,
        }
        kind = local(element)
        if kind not in readers:
            raise InputError(f"{path}: {kind} is not supported; connect the components directly")
        return readers[kind](element, path)

    def component(self, element: Any, where: str) -> DeclaredComponent | DeclaredSystem:
        parts = ("Connectors", "ElementGeometry", "ParameterBindings", "Annotations", "MetaData")
        refuse_other_children(element, parts, where)
        implementation = element.get("implementation", "any")
        if implementation not in ("any", "CoSimulation"):
            raise InputError(f"{where}: implementation {implementation} is not supported; use CoSimulation")
        kind = element.get("type", FMU_TYPE)
        if kind not in (FMU_TYPE, DEFINITION_TYPE, PACKAGE_TYPE):
            raise InputError(f"{where}: components of type {kind} are not supported; export an FMU")
        source = element.get("source")
        if source is None:
            raise InputError(f"{where}: names no source, so that there is nothing to run; give it an FMU")
        connectors, bindings = self.connectors(element, where), self.bindings(element, where)
        if kind == FMU_TYPE:
            return DeclaredComponent(element.get("name", ""), self.file(source, where), connectors, bindings)
        return self.other_system(element, kind, connectors, bindings, where)

    def other_system(
        self,
        element: Any,
        kind: str,
        connectors: dict[str, DeclaredConnector],
        bindings: tuple[Binding, ...],
        where: str,
    ) -> DeclaredSystem:
        """Read a system from another SSD or SSP; the bindings here come after its own (SSP 5.2.3)."""
        source = element.get("source", "")
        address, _, fragment = source.partition("#")
        if not address:
            raise InputError(f"{where}: source {source} refers to a part of its own document; write it out")
        path = self.file(address, where)
        if kind == PACKAGE_TYPE:
            path = archive.unpack(path, self.workdir) / (_relative(fragment, where) or "SystemStructure.ssd")
        elif fragment:
            raise InputError(f"{where}: source {source} refers to a part of a document; name the document")
        inner = read_ssd(path, self.workdir, (*self.enclosing, self.path)).system
        missing = sorted(set(connectors) - set(inner.connectors))
        if missing:
            raise InputError(f"{where}: {source} has no connector {missing[0]}; remove it or add it there")
        return replace(inner, name=element.get("name", ""), bindings=inner.bindings + bindings)

    def connectors(self, element: Any, path: str) -> dict[str, DeclaredConnector]:
        found: dict[str, DeclaredConnector] = {}
        for child in _items(element, "Connectors", "Connector"):
            name = required(child, "name", path or self.where)
            here = f"{path}.{name}" if path else name
            if name in found:
                raise InputError(f"{here}: is declared twice; connectors of one element differ in name")
            found[name] = self.connector(child, name, here)
        return found

    def connector(self, element: Any, name: str, where: str) -> DeclaredConnector:
        kind = required(element, "kind", where)
        known = next((k for k in get_args(ConnectorKind) if k == kind), None)
        if known is None:
            raise InputError(f"{where}: connectors of kind {kind} are not supported; use input or output")
        typed = [
            child
            for child in element
            if local(child) not in ("ConnectorGeometry", "Dimension", "Annotations", "MetaData")
        ]
        sizes = tuple(integer(required(d, "size", where), where) for d in children(element, "Dimension"))
        if len(typed) > 1:
            raise InputError(f"{where}: clocked connectors are not supported; connect others")
        if not typed:
            return DeclaredConnector(name, known, None, None, sizes)
        unit = typed[0].get("unit")
        return DeclaredConnector(name, known, local(typed[0]), self.unit(unit), sizes)

    def unit(self, name: str | None) -> Unit | None:
        return None if not name else self.units.get(name, Unit(name))

    def connection(self, element: Any, path: str) -> DeclaredConnection:
        where = path or self.where
        start, end = required(element, "startConnector", where), required(element, "endConnector", where)
        owners = element.get("startElement"), element.get("endElement")
        ends = ((path, owners[0], start), (path, owners[1], end))
        here = " -> ".join(".".join(part for part in names if part) for names in ends)
        for name in ("startIndices", "endIndices"):
            if element.get(name) is not None:
                raise InputError(f"{here}: {name} is not supported; connect scalars")
        suppress = boolean(element, "suppressUnitConversion", here, default=False)
        return DeclaredConnection(owners[0], start, owners[1], end, transformation(element, here), suppress)

    def bindings(self, element: Any, where: str) -> tuple[Binding, ...]:
        return tuple(self.binding(b, where) for b in _items(element, "ParameterBindings", "ParameterBinding"))

    def binding(self, element: Any, where: str) -> Binding:
        refuse_other_children(
            element, ("ParameterValues", "ParameterMapping", "Annotations", "MetaData"), where
        )
        values, where = self.content(
            element,
            only_child(element, "ParameterValues"),
            "application/x-ssp-parameter-set",
            "ParameterSet",
            where,
        )
        prefix = element.get("prefix", "")
        parameters = tuple(
            Parameter(prefix + p.name, p.type, p.value, p.unit) for p in parameter_set(values, where)
        )
        mapping = only_child(element, "ParameterMapping")
        if mapping is None:
            return Binding(parameters, None, where)
        entries, there = self.content(
            mapping, mapping, "application/x-ssp-parameter-mapping", "ParameterMapping", where
        )
        return Binding(parameters, parameter_mapping(entries, there), where)

    def content(self, holder: Any, inline: Any, mime: str, root: str, where: str) -> tuple[Any, str]:
        """Give the root of a document that stands in a file of its own or inside this one, and its name."""
        kind, source = holder.get("type", mime), holder.get("source")
        if kind != mime:
            raise InputError(f"{where}: parameters of type {kind} are not supported; use {mime}")
        if holder.get("sourceBase", "SSD") != "SSD":
            raise InputError(
                f"{where}: sourceBase {holder.get('sourceBase')} is not supported; move it to the SSP"
            )
        if source:
            path = self.file(source, where)
            return root_of_file(path, root, f"{where}: {source}"), f"{where}: {source}"
        held = only_child(inline, root)
        if held is None:
            raise InputError(f"{where}: a parameter binding has neither a source nor a {root} inside")
        check_root(held, root, where)
        return held, f"{where}: {root}"

    def file(self, source: str, where: str) -> Path:
        """Give the existing file that a relative URI means, inside the SSP."""
        try:
            parts = urlsplit(source)
        except ValueError:
            raise InputError(f"{where}: source {source!r} is not a URI") from None
        relative = None if parts.scheme or parts.netloc else _relative(parts.path, where)
        if not relative:
            raise InputError(
                f"{where}: source {source!r} is not a file inside the SSP; put it into resources"
            )
        path = self.base / relative
        if not is_file(path) and (plain := archive.safe_relative(source)):
            # Some tools write names as they are, a percent sign included, where a URI should stand.
            path = self.base / plain
        if not is_file(path):
            raise InputError(f"{where}: the SSP holds no {source}; add the file or correct the source")
        return path


def _relative(source: str, where: str) -> str | None:
    relative = archive.safe_relative(unquote(source))
    if relative is None:
        raise InputError(f"{where}: source {source!r} leads outside the SSP; put the file into resources")
    return relative or None


def _items(element: Any, holder: str, name: str | None = None) -> list[Any]:
    """Give the children of an optional holder, which may be of one name only."""
    held = only_child(element, holder)
    if held is None:
        return []
    return [child for child in held if local(child) == (name or local(child))]


def _experiment(element: Any, where: str) -> DefaultExperiment:
    if element is None:
        return DefaultExperiment()
    start = optional_number(element, "startTime", where) or 0.0
    stop = optional_number(element, "stopTime", where)
    if stop is not None and stop <= start:
        raise InputError(f"{where}: stopTime {stop:g} s is not after startTime {start:g} s; give a later one")
    algorithm = next((s for s in element.iter() if local(s) == "FixedStepAlgorithm"), None)
    step = None if algorithm is None else optional_number(algorithm, "baseStepSize", where)
    if step is not None and step <= 0:
        raise InputError(f"{where}: baseStepSize {step:g} s is not positive; give a step above 0 s")
    return DefaultExperiment(start, stop, step)
