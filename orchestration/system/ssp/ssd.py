"""Reading an SSD into the net of systems and components that it declares (SSP section 5).

What the rest cannot make use of is refused here, by name.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path as File
from typing import Any, get_args
from urllib.parse import parse_qs, unquote, urlsplit

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.system import archive, xml
from warmlink.orchestration.system.model import CONNECTOR_KINDS, Connector, DefaultExperiment, Implementation
from warmlink.orchestration.system.ssp.arrays import element_of, mapped_elements, sizes_of_array
from warmlink.orchestration.system.ssp.net import Edge, Element, Net, Node, Path
from warmlink.orchestration.system.ssp.parameter_values import (
    parameter_mapping,
    parameter_set,
    with_transformation,
)
from warmlink.orchestration.system.ssp.resolve import Binding
from warmlink.orchestration.system.units import Unit, definitions_of_units, named_unit
from warmlink.orchestration.text_files import is_file

FMU_TYPE = "application/x-fmu-sharedlibrary"
DEFINITION_TYPE = "application/x-ssp-definition"
PACKAGE_TYPE = "application/x-ssp-package"
# Each level may hold the next one several times over, so few levels can already be many components.
_DEEPEST = 8


@dataclass(frozen=True)
class Reader:
    """What is read of an SSD in an unpacked SSP, and of all that it refers to, never outside its folder.

    Packages inside the package are unpacked into `workdir`. Of the document that is being read it knows where
    that lies, which units it defines, and those that hold it, itself among them; `documents` are all so far.
    One that its user has `unpacked` may refer to files outside its folder.
    """

    workdir: File
    net: Net = field(default_factory=Net)
    bindings: list[Binding] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    path: File = File()
    units: dict[str, Unit] = field(default_factory=dict)
    enclosing: tuple[File, ...] = ()
    documents: set[File] = field(default_factory=set)
    unpacked: bool = False

    def read(self, path: File, at: Path = ()) -> tuple[str, DefaultExperiment]:
        """Read an SSD as the system `at` a path; give its name and the experiment that it proposes."""
        where = path.name
        if path in self.enclosing:
            raise InputError(f"{where}: holds itself as a component; take it out")
        if len(self.enclosing) > _DEEPEST:
            raise InputError(f"{where}: lies more than {_DEEPEST} descriptions deep; make the system flatter")
        self.documents.add(path)
        root = xml.root_of_file(path, "SystemStructureDescription", where, self.remarks)
        xml.refuse_other_children(root, ("System", "Enumerations", "Units", "DefaultExperiment"), where)
        top = root.find("{*}System")
        if top is None:
            raise InputError(f"{where}: holds no System; there is nothing to simulate")
        units = definitions_of_units(root, where)
        experiment = _experiment(root.find("{*}DefaultExperiment"), where)
        replace(self, path=path, units=units, enclosing=(*self.enclosing, path))._system(top, at)
        return root.get("name") or top.get("name") or path.stem, experiment

    def _where(self, at: Path) -> str:
        return ".".join(at) or self.path.name

    def _system(self, element: Any, at: Path) -> None:
        where = self._where(at)
        parts = ("Connectors", "ElementGeometry", "ParameterBindings", "Elements", "Connections")
        xml.refuse_other_children(element, (*parts, "SystemGeometry", "GraphicalElements"), where)
        connections = [self._connection(c, at) for c in element.iterfind("{*}Connections/{*}Connection")]
        self.net.add(at, Element(self._connectors(element, at), connections=connections))
        readers = {"System": self._system, "Component": self._component}
        for child in element.iterfind("{*}Elements/*"):
            name = xml.required(child, "name", where)
            inner = (*at, name)
            if not name or inner in self.net.elements:
                raise InputError(
                    f"{where}: holds two elements named {name!r}, or one without name; rename one"
                )
            if xml.local(child) not in readers:
                raise InputError(
                    f"{'.'.join(inner)}: {xml.local(child)} is not supported; connect the components directly"
                )
            readers[xml.local(child)](child, inner)
        self.bindings.extend(self._bindings(element, at))

    def _component(self, element: Any, at: Path) -> None:
        """Read a component, or a system from another SSD or SSP; bindings here come after its own."""
        where = self._where(at)
        xml.refuse_other_children(element, ("Connectors", "ElementGeometry", "ParameterBindings"), where)
        implementation: Any = element.get("implementation", "any")
        if implementation not in get_args(Implementation):
            known = listed(get_args(Implementation), "or")
            raise InputError(f"{where}: implementation {implementation} is not supported; use {known}")
        kind, source = element.get("type", FMU_TYPE), element.get("source")
        if kind not in (FMU_TYPE, DEFINITION_TYPE, PACKAGE_TYPE):
            raise InputError(f"{where}: components of type {kind} are not supported; export an FMU")
        if source is None:
            raise InputError(f"{where}: names no source, so that there is nothing to run; give it an FMU")
        connectors, bindings = self._connectors(element, at), self._bindings(element, at)
        if kind == FMU_TYPE:
            self.net.add(at, Element(connectors, self._file(source, where), implementation=implementation))
        else:
            self._other_system(source, kind, connectors, at)
        self.bindings.extend(bindings)

    def _other_system(self, source: str, kind: str, shown: dict[str, Connector], at: Path) -> None:
        where = self._where(at)
        address, _, fragment = source.partition("#")
        if not address:
            raise InputError(f"{where}: source {source} refers to a part of its own document; write it out")
        path, inner = self._file(address, where), self
        if kind == PACKAGE_TYPE:
            inside = _relative(fragment, where) or "SystemStructure.ssd"
            self.remarks.extend(archive.repeated_entries(path))
            path, inner = archive.unpack(path, self.workdir) / inside, replace(self, unpacked=False)
        elif fragment:
            raise InputError(f"{where}: source {source} refers to a part of a document; name the document")
        inner.read(path, at)
        missing = sorted(set(shown) - set(self.net.elements[at].connectors))
        if missing:
            raise InputError(f"{where}: {source} has no connector {missing[0]}; remove it or add it there")

    def _connectors(self, element: Any, at: Path) -> dict[str, Connector]:
        found: dict[str, Connector] = {}
        for child in element.iterfind("{*}Connectors/{*}Connector"):
            name = xml.required(child, "name", self._where(at))
            where = str(Node(at, name))
            if name in found:
                raise InputError(f"{where}: is declared twice; connectors of one element differ in name")
            kind = xml.required(child, "kind", where)
            if kind not in CONNECTOR_KINDS:
                raise InputError(f"{where}: connectors of kind {kind} are not supported; use input or output")
            untyped = ("ConnectorGeometry", "Dimension", "Annotations", "MetaData")
            typed = [each for each in child if xml.local(each) not in untyped]
            if len(typed) > 1:
                raise InputError(f"{where}: clocked connectors are not supported; connect others")
            sizes = self._sizes(child, where)
            named = typed[0].get("unit") if typed else None
            unit = named_unit(named, self.units, where, self.remarks)
            found[name] = Connector(kind, xml.local(typed[0]) if typed else None, unit, sizes)
        return found

    def _sizes(self, connector: Any, where: str) -> tuple[int, ...]:
        """Give the sizes of an array connector; none where one is left to the FMU."""
        texts = [each.get("size") for each in connector.iterfind("{*}Dimension")]
        return () if None in texts else sizes_of_array(texts, where)

    def _connection(self, element: Any, at: Path) -> Edge:
        ends = []
        for end in ("start", "end"):
            owner = element.get(f"{end}Element")
            connector = xml.required(element, f"{end}Connector", self._where(at))
            where = f"{self._where(at)}: {connector}: {end}Indices"
            indices = [xml.integer(text, where) for text in (element.get(f"{end}Indices") or "").split()]
            connector = element_of(connector, indices) if indices else connector
            ends.append(Node((*at, owner) if owner else at, connector))
        edge = Edge(ends[0], ends[1])
        for end in ("start", "end"):
            if element.get(f"{end}Element") == "":
                self.remarks.append(f"{edge}: its {end}Element is empty and is read as the system itself")
        return with_transformation(edge, element, str(edge))

    def _bindings(self, element: Any, at: Path) -> list[Binding]:
        held = element.iterfind("{*}ParameterBindings/{*}ParameterBinding")
        return [self._binding(each, at) for each in held]

    def _binding(self, element: Any, at: Path) -> Binding:
        where = self._where(at)
        xml.refuse_other_children(element, ("ParameterValues", "ParameterMapping"), where)
        values, where = self._content(element, "{*}ParameterValues/{*}ParameterSet", where)
        prefix = element.get("prefix", "")
        parameters = {
            prefix + name: each for name, each in parameter_set(values, where, self.remarks).items()
        }
        mapping = element.find("{*}ParameterMapping")
        entries = None
        if mapping is not None:
            told = parameter_mapping(*self._content(mapping, "{*}ParameterMapping", where))
            entries = mapped_elements(told, parameters)
        return Binding(at, parameters, entries, where)

    def _content(self, holder: Any, way: str, where: str) -> tuple[Any, str]:
        """Give the root of a document, in a file of its own or on a way inside this one, and its name."""
        root = way.rpartition("}")[2]
        mime = f"application/x-ssp-parameter-{root.removeprefix('Parameter').lower()}"
        kind, source = holder.get("type", mime), holder.get("source")
        if kind != mime:
            raise InputError(f"{where}: parameters of type {kind} are not supported; use {mime}")
        base = holder.get("sourceBase", "SSD")
        if base != "SSD":
            raise InputError(f"{where}: sourceBase {base} is not supported; move it to the SSP")
        if source:
            there = f"{where}: {source}"
            return xml.root_of_file(self._file(source, where), root, there, self.remarks), there
        held = holder.find(way)
        if held is None:
            raise InputError(f"{where}: a parameter binding has neither a source nor a {root} inside")
        xml.check_root(held, root, where, self.remarks)
        return held, f"{where}: {root}"

    def _file(self, source: str, where: str) -> File:
        """Give the existing file that a relative URI means, inside the SSP."""
        try:
            parts = urlsplit(source)
        except ValueError:
            raise InputError(f"{where}: source {source!r} is not a URI") from None
        named = parse_qs(parts.query).get("file", []) if parts.scheme == "proxyfmu" else []
        if named and parts.hostname in ("localhost", "127.0.0.1"):
            self.remarks.append(f"{where}: source {source} asks for a proxy; the FMU is run without one")
            parts = urlsplit(named[0])
        relative = None if parts.scheme or parts.netloc else self._inside(parts.path, where)
        if not relative:
            raise InputError(
                f"{where}: source {source!r} is not a file inside the SSP; put it into resources"
            )
        # Some tools write names as they are, a percent sign included, where a URI should stand.
        for name in (relative, archive.safe_relative(source)):
            if name and is_file(self.path.parent / name):
                return self.path.parent / name
        raise InputError(f"{where}: the SSP holds no {source}; add the file or correct the source")

    def _inside(self, source: str, where: str) -> str | None:
        """Give a relative path, which stays inside the SSP unless its user has unpacked that."""
        plain = unquote(source)
        outside = self.unpacked and not plain.startswith(("/", "\\")) and "\0" not in plain
        return plain if outside else _relative(source, where)


def parts_of(document: bytes, where: str) -> set[str]:
    """Paths in an SSP of the SSDs that an SSD refers to as its components; InputError if it is no XML."""
    sources = [each.get("source", "") for each in xml.parse_xml(document, where, []).iter("{*}Component")]
    return {archive.safe_relative(unquote(each.partition("#")[0])) or "" for each in sources}


def _relative(source: str, where: str) -> str | None:
    relative = archive.safe_relative(unquote(source))
    if relative is None:
        raise InputError(f"{where}: source {source!r} leads outside the SSP; put the file into resources")
    return relative or None


def _experiment(element: Any, where: str) -> DefaultExperiment:
    start = xml.optional(element, "startTime", xml.number, where) or 0.0
    stop = xml.optional(element, "stopTime", xml.number, where)
    if stop is not None and stop <= start:
        raise InputError(f"{where}: stopTime {stop:g} s is not after startTime {start:g} s; give a later one")
    algorithm = None if element is None else element.find(".//{*}FixedStepAlgorithm")
    step = xml.optional(algorithm, "baseStepSize", xml.number, where)
    if step is not None and step <= 0:
        raise InputError(f"{where}: baseStepSize {step:g} s is not positive; give a step above 0 s")
    return DefaultExperiment(start, stop, step)
