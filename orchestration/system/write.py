"""Writing a system as an SSP that other masters read as well: SSP 1.0 or 2.0, plain prefixes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import write_archive
from warmlink.fmus.names import instead
from warmlink.fmus.packaging import release
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.system.assemble import check_system
from warmlink.orchestration.system.check import own_unit
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.drawing import Box, boxes, places
from warmlink.orchestration.system.model import (
    CONNECTOR_KINDS,
    Connector,
    FmuPart,
    FmuVariable,
    SspVersion,
    System,
    Value,
)
from warmlink.orchestration.system.ports import End, Opened, Ports, opened
from warmlink.orchestration.system.ssp.arrays import array_of, arrays_in, joined_edges
from warmlink.orchestration.system.ssp.net import Node, net_of
from warmlink.orchestration.system.ssp.net import Path as Place
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, parameter_set_element
from warmlink.orchestration.system.ssp.resolve import Resolver
from warmlink.orchestration.system.units import Unit, meaning, unit_elements
from warmlink.orchestration.system.xml import element, sub_element, to_bytes

# Every component's set bears this name: Ecos applies the sets of one name, which its user gives.
PARAMETER_SET = "parameters"


def write_ssp(
    system: System,
    path: str | Path,
    ports: Ports | None = None,
    nested: bool = False,
    version: str | float = "1.0",
) -> None:
    """Write a system with its FMUs into one SSP file, whole or not at all; equal systems give equal bytes.

    Each component is bound to a parameter set of its own under `resources`. A connection that is more
    than the identity is written as a LinearTransformation between the variables' own units.

    Parameters
    ----------
    system : what to write
    path : the .ssp file
    ports : what the system exchanges with a larger one; without, it runs by itself
    nested : with a system inside it for each name before a dot, so that `axis1.link` becomes the component
        `link` of the system `axis1`, whose connectors pass on what crosses its bounds
    version : `2.0`, or 2, knows the types and arrays of FMI 3.0; older tools read `1.0` alone

    Raises
    ------
    InputError
        If the file cannot be written, or there is no such version; if the system does not fit its FMUs, two
        FMUs define one unit differently, a name before a dot is that of a component too, or the ports do not
        fit the system, or are asked for with `nested`.

    Examples
    --------
    >>> wl.write_ssp(wl.read_system("dist/WarmupCell.ssp"), "copy.ssp")
    """
    if ports is not None and nested:
        raise InputError("ports: a nested system has none; leave one out")
    system = _with_connectors(system, () if ports is None else ports.shown)
    check_system(system)
    shown = Opened.by_itself(system, net_of(system, nested)) if ports is None else opened(system, ports)
    document = _Document(shown, ssp_version_named(version, "version"))
    entries = {"SystemStructure.ssd": to_bytes(document.root())}
    for name, held in document.system.components.items():
        if held.values:
            entries[document.parameters[name]] = to_bytes(document.parameter_set(held))
        entries[document.fmus[held.fmu]] = held.fmu.read_bytes()
    target = path_given("path", path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with fresh_file(target) as scratch:
        write_archive(scratch, entries)


def ssp_version_named(name: str | float, of: str) -> SspVersion:
    """Give a version of SSP by its name, 1 or 2, as an argument gives it; InputError if there is none."""
    known: dict[str, SspVersion] = {"1": "1.0", "2": "2.0"}
    short = str(name).removesuffix(".0")
    if short not in known:
        raise InputError(f"{argument(of, name)}: no such version; {instead(name, known)}")
    return known[short]


def _with_connectors(system: System, shown: Sequence[End]) -> System:
    """Give the system with connectors everywhere: those who read the file connect nothing else."""
    fed = {link.ends[1] for link in system.connections}
    parts = {
        name: held if held.connectors else replace(held, connectors=_connectors(held, fed))
        for name, held in system.components.items()
    }
    used = [(f"{link.source} -> {link.target}", end) for link in system.connections for end in link.ends]
    for where, (name, connector) in [*used, *(("ports", end) for end in shown)]:
        if name in parts and connector not in parts[name].connectors:
            raise InputError(f"{where}: {name} has no connector {connector}; declare it")
    return replace(system, components=parts)


def _connectors(held: FmuPart, fed: set[End]) -> dict[str, Connector]:
    """Connect outputs, given parameters and what is fed: some tools feed 0 to every other input listed."""
    info = read_description(held.fmu)
    return {
        v.name: Connector(kind, v.kind, own_unit(info, v))
        for v in info.variables.values()
        if (kind := v.causality) in CONNECTOR_KINDS
        and v.kind is not None
        and not v.dimensions
        and (kind == "output" or ((held.name, v.name) in fed if kind == "input" else v.name in held.values))
    }


class _Document:
    """An SSD being written: names of its files, and the enumerations and units that it has named so far.

    Files are named by letters, digits, dot, hyphen and underscore alone, because some readers do not decode a
    URI, and no two differ in capitals alone, because some file systems do not tell these apart.
    """

    def __init__(self, shown: Opened, version: SspVersion) -> None:
        system, net, whole, self.driven = shown
        self.system, self.net, self.resolver = system, net, Resolver(whole)
        self.version = version
        self.arrays = arrays_in(net) if version == "2.0" else {}
        self.enumerations: dict[str, dict[str, int]] = {}
        self.units: dict[str, Unit] = {}
        self.fmus: dict[Path, str] = {}
        self.parameters: dict[str, str] = {}
        taken: set[str] = set()
        for held in system.components.values():
            if held.fmu not in self.fmus:
                self.fmus[held.fmu] = _free(held.fmu.stem, ".fmu", taken)
            self.parameters[held.name] = _free(held.name, ".ssv", taken)

    def root(self) -> Any:
        """Give the whole document."""
        made = {
            "generationTool": "warmlink",
            "generationDateAndTime": f"{release.generated():%Y-%m-%dT%H:%M:%SZ}",
        }
        root = element(
            "ssd", "SystemStructureDescription", version=self.version, name=self.system.name, **made
        )
        self._add_system(root, ())
        held = sub_element(root, "ssd", "Enumerations") if self.enumerations else None
        for name, items in self.enumerations.items():
            child = sub_element(held, "ssc", "Enumeration", name=name)
            for item, number in items.items():
                sub_element(child, "ssc", "Item", name=item, value=number)
        unit_elements(root, "ssd", self.units.values())
        proposed = self.system.default_experiment
        stop = None if proposed.stop_time is None else float(proposed.stop_time)
        times = {"startTime": float(proposed.start_time), "stopTime": stop}
        experiment = sub_element(root, "ssd", "DefaultExperiment", **times)
        if proposed.step_size is not None:  # for which SSP has no word; libcosim reads it here
            algorithm = sub_element(_note(experiment, "com.opensimulationplatform"), "osp", "Algorithm")
            sub_element(algorithm, "osp", "FixedStepAlgorithm", baseStepSize=float(proposed.step_size))
        return root

    def parameter_set(self, held: FmuPart) -> Any:
        """Give the document of a component's start values."""
        (path,) = (path for path in self.net.components if ".".join(path) == held.name)
        values: dict[str, Value | SsvValue] = {}
        for name, value in held.values.items():
            variable, unit = self._variable(Node(path, name))
            if variable.kind == "Real":
                values[name] = SsvValue(name, "Real", float(value), unit)
            elif variable.kind == "Binary":
                values[name] = SsvValue(name, "Binary", value)
            elif variable.kind == "Enumeration":
                item = next((item for item, number in variable.items.items() if number == value), None)
                if item is None:
                    raise InputError(f"{name}: {value} is no item of its enumeration; give one of its items")
                values[name] = SsvValue(name, "Enumeration", item)
            else:
                values[name] = value
        sizes = {node.connector: each for node, each in self.arrays.items() if node.path == path}
        return parameter_set_element(PARAMETER_SET, values, version=self.version, arrays=sizes)

    def _add_system(self, parent: Any, path: Place, box: Box | None = None) -> None:
        """Add a system with all that is in it, to be drawn in a box of the system around it."""
        net = self.net
        child = sub_element(parent, "ssd", "System", name=path[-1] if path else self.system.name)
        self._add_connectors(child, path, box)
        elements = sub_element(child, "ssd", "Elements")
        inside = sorted(net.inside[path], key=lambda inner: net.elements[inner].fmu is None)
        edges = net.elements[path].connections
        drawn = boxes(
            {inner: [c.kind for c in net.elements[inner].connectors.values()] for inner in inside},
            ((edge.source.path, edge.target.path) for edge in edges),
        )
        for inner in inside:
            add = self._add_system if net.elements[inner].fmu is None else self._add_component
            add(elements, inner, drawn[inner])
        links = sub_element(child, "ssd", "Connections") if edges else None
        for edge, indices in joined_edges(edges, self.arrays):
            change, ends = edge.transformation, {}
            for end, node, at in zip(("start", "end"), edge.ends, indices, strict=True):
                ends[f"{end}Element"] = None if node.path == path else node.path[-1]
                ends[f"{end}Connector"] = node.connector
                ends[f"{end}Indices"] = " ".join(map(str, at)) or None
            suppress = None if change is None else True
            drawn_link = sub_element(links, "ssd", "Connection", **ends, suppressUnitConversion=suppress)
            if change is not None:
                scale = {"factor": change.factor, "offset": change.offset}
                sub_element(drawn_link, "ssc", "LinearTransformation", **scale)
            if edge.values is not None:
                table = sub_element(drawn_link, "ssc", f"{edge.values.kind}MappingTransformation")
                for source, target in edge.values.entries:
                    sub_element(table, "ssc", "MapEntry", source=source, target=target)
        step = self.system.default_experiment.step_size
        if step is not None:  # by this OMSimulator knows a system of co-simulation, which it refuses without
            told = sub_element(_note(child, "org.openmodelica"), "oms", "Annotations")
            told = sub_element(told, "oms", "SimulationInformation")
            settings = {"stepSize": float(step), "absoluteTolerance": 1e-4, "relativeTolerance": 1e-4}
            sub_element(told, "oms", "FixedStepMaster", description="oms-ma", **settings)

    def _add_component(self, elements: Any, path: Place, box: Box | None) -> None:
        held = self.system.components[".".join(path)]
        source, kind = self.fmus[held.fmu], "application/x-fmu-sharedlibrary"
        child = sub_element(elements, "ssd", "Component", name=path[-1], type=kind, source=source)
        if held.implementation != "any":
            child.set("implementation", held.implementation)
        self._add_connectors(child, path, box)
        if held.values:
            bindings = sub_element(child, "ssd", "ParameterBindings")
            sub_element(bindings, "ssd", "ParameterBinding", source=self.parameters[held.name])

    def _add_connectors(self, parent: Any, path: Place, box: Box | None) -> None:
        """Add connectors, each with the type and the unit of a component's, and the box of their element."""
        connectors, arrays = self.net.elements[path].connectors, self.arrays
        shown = {array_of(Node(path, name), arrays): (name, each) for name, each in connectors.items()}
        held = sub_element(parent, "ssd", "Connectors") if shown else None
        kinds = [each.kind for _, each in shown.values()]
        for (whole, (name, each)), place in zip(shown.items(), places(kinds), strict=True):
            child = sub_element(held, "ssd", "Connector", name=whole, kind=each.kind)
            self._add_type(child, Node(path, name))
            for size in arrays.get(Node(path, whole), ()):
                sub_element(child, "ssc", "Dimension", size=size)
            if place is not None:
                sub_element(child, "ssd", "ConnectorGeometry", x=place[0], y=place[1])
        if box is not None:
            sub_element(parent, "ssd", "ElementGeometry", x1=box[0], y1=box[1], x2=box[2], y2=box[3])

    def _add_type(self, connector: Any, node: Node) -> None:
        """Add the type of a component's connector, or of the one whose values a system's connector has."""
        if not node.path:
            node = self.driven.get(node.connector, node)
        net = self.resolver.net
        info = net.info(node)
        while info is None:
            before = self.net.into.get(node)
            node = before.source if before else self.net.onward[node][0][-1].target
            info = net.info(node)
        variable, unit = self._variable(node)
        declared = net.declared(node)
        kind = declared.type if declared and declared.type else variable.kind
        if self.version == "2.0" and kind != "Enumeration":
            kind = variable.type
        if kind == "Enumeration":
            if variable.items:
                enumeration = f"{info.model_name}.{node.connector}"
                while self.enumerations.setdefault(enumeration, variable.items) != variable.items:
                    enumeration += "_"  # another FMU of that name has other items
                sub_element(connector, "ssc", "Enumeration", name=enumeration)
            return
        sub_element(connector, "ssc", str(kind), unit=None if unit is None else unit.name)
        if unit is not None and self.units.setdefault(unit.name, unit) != unit:
            raise InputError(f"{node}: its FMU defines the unit {unit.name} unlike another FMU; rename one")

    def _variable(self, node: Node) -> tuple[FmuVariable, Unit | None]:
        """Give a variable, and its unit with its meaning; None if there is none, or no known meaning."""
        variable, unit = self.resolver.variable(node)
        try:
            return variable, None if unit is None else meaning(unit)
        except InputError:
            # An SSD may only name units that it can define; a reader takes it from the FMU then.
            return variable, None


def _free(stem: str, suffix: str, taken: set[str]) -> str:
    """Name of a file inside the SSP that is not taken, and is now."""
    plain = re.sub(r"[^A-Za-z0-9._-]", "_", stem)
    name, number = f"resources/{plain}{suffix}", 2
    while name.casefold() in taken:
        name, number = f"resources/{plain}-{number}{suffix}", number + 1
    taken.add(name.casefold())
    return name


def _note(parent: Any, tool: str) -> Any:
    return sub_element(sub_element(parent, "ssd", "Annotations"), "ssc", "Annotation", type=tool)
