"""Writing a system as an SSP that other masters read as well: SSP 1.0, plain prefixes, nothing to convert."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging import release
from warmlink.orchestration.system.assemble import check_system
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import Variable, read_description
from warmlink.orchestration.system.model import Component, Connector, DefaultExperiment, System, Value
from warmlink.orchestration.system.ssp.parameter_values import Parameter, parameter_set_element
from warmlink.orchestration.system.tree import (
    Box,
    Ports,
    SystemConnector,
    Tree,
    boxes,
    longer_side,
    opened,
    places,
    tree_of,
    with_connectors,
)
from warmlink.orchestration.system.units import Unit, meaning, unit_elements
from warmlink.orchestration.system.xml import element, sub_element, to_bytes

# Every component's set bears this name: Ecos applies the sets of one name, which its user gives.
PARAMETER_SET = "parameters"
OMS = "org.openmodelica"

_Shown = tuple[str, str, Component, Connector]
"""A connector's name and kind, and the component's connector whose type and unit it has."""


def write_ssp(system: System, path: str | Path, ports: Ports | None = None) -> None:
    """Write a system with its FMUs into one SSP file, whole or not at all; equal systems give equal bytes.

    Each component is bound to a parameter set of its own under `resources`. A connection that is more
    than the identity is written as a LinearTransformation between the variables' own units.

    Parameters
    ----------
    system : what to write
    path : the .ssp file
    ports : what the system exchanges with a larger one; without, it runs by itself

    Raises
    ------
    InputError
        If the system does not fit its FMUs, or two FMUs define one unit differently.
    """
    system = _checked(system)
    _write(*((system, tree_of(system)) if ports is None else opened(system, ports)), Path(path))


def write_nested_ssp(system: System, path: Path) -> None:
    """Write a system as `write_ssp` does, but with a system inside it for each name before a dot.

    A component `axis1.link` becomes the component `link` of the system `axis1`, whose connectors pass on what
    crosses its bounds; InputError if a name before a dot is that of a component too. Reading makes it flat
    again.
    """
    system = _checked(system)
    _write(system, tree_of(system, nested=True), path)


def _checked(system: System) -> System:
    system = with_connectors(system)
    check_system(system)
    return system


def _write(system: System, tree: Tree, path: Path) -> None:
    files = _Files(system.components.values())
    entries = {"SystemStructure.ssd": to_bytes(_Document(system, files).root(tree))}
    for held in system.components.values():
        if held.values:
            entries[files.parameters[held.name]] = to_bytes(_ssv(held, system))
        entries[files.fmus[held.fmu]] = held.fmu.read_bytes()
    write_archive(path, entries)


class _Files:
    """What each FMU and each parameter set is called inside the SSP.

    Only letters, digits, dot, hyphen and underscore, because some readers do not decode a URI, and never
    two names that differ in capitals alone, because some file systems do not tell them apart.
    """

    def __init__(self, components: Iterable[Component]) -> None:
        self._taken: set[str] = set()
        self.fmus: dict[Path, str] = {}
        self.parameters: dict[str, str] = {}
        for held in components:
            if held.fmu not in self.fmus:
                self.fmus[held.fmu] = self._free(held.fmu.stem, ".fmu")
            self.parameters[held.name] = self._free(held.name, ".ssv")

    def _free(self, stem: str, suffix: str) -> str:
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", stem)
        name, number = f"resources/{plain}{suffix}", 2
        while name.casefold() in self._taken:
            name, number = f"resources/{plain}-{number}{suffix}", number + 1
        self._taken.add(name.casefold())
        return name


class _Document:
    """An SSD being written: which enumerations and units its elements have named so far."""

    def __init__(self, system: System, files: _Files) -> None:
        self.system = system
        self.files = files
        self.enumerations: dict[str, dict[str, int]] = {}
        self.units: dict[str, Unit] = {}

    def root(self, tree: Tree) -> Any:
        """Give the whole document."""
        root = element(
            "ssd",
            "SystemStructureDescription",
            version="1.0",
            name=self.system.name,
            generationTool="warmlink",
            generationDateAndTime=f"{release.generated():%Y-%m-%dT%H:%M:%SZ}",
        )
        self.add(root, self.system.name, tree)
        held = sub_element(root, "ssd", "Enumerations") if self.enumerations else None
        for name, items in self.enumerations.items():
            child = sub_element(held, "ssc", "Enumeration", name=name)
            for item, number in items.items():
                sub_element(child, "ssc", "Item", name=item, value=number)
        unit_elements(root, "ssd", self.units.values())
        _experiment(root, self.system.default_experiment)
        return root

    def add(self, parent: Any, name: str, tree: Tree, box: Box | None = None) -> None:
        """Add a system with all that is in it, to be drawn in a box of the system around it."""
        child = sub_element(parent, "ssd", "System", name=name)
        self._connectors(child, [self._shown(shown) for shown in tree.connectors], box)
        elements = sub_element(child, "ssd", "Elements")
        inside: dict[str, Component | Tree] = {**tree.components, **tree.systems}
        drawn = boxes(
            {inner: longer_side(c.kind for c in held.connectors) for inner, held in inside.items()},
            ((".".join(e.source.path), ".".join(e.target.path)) for e in tree.edges),
        )
        for inner, held in tree.components.items():
            self._component(elements, inner, held, drawn[inner])
        for inner, below in tree.systems.items():
            self.add(elements, inner, below, drawn[inner])
        links = sub_element(child, "ssd", "Connections") if tree.edges else None
        for edge in tree.edges:
            change = edge.transformation
            ends = {
                f"{end}{what}": name
                for end, node in zip(("start", "end"), edge.ends, strict=True)
                for what, name in (("Element", ".".join(node.path) or None), ("Connector", node.connector))
            }
            suppress = None if change is None else True
            drawn_link = sub_element(links, "ssd", "Connection", **ends, suppressUnitConversion=suppress)
            if change is not None:
                sub_element(
                    drawn_link, "ssc", "LinearTransformation", factor=change.factor, offset=change.offset
                )
        _fixed_step_master(child, self.system.default_experiment.step_size)

    def _shown(self, shown: SystemConnector) -> _Shown:
        component, variable = shown.source
        held = self.system.components[component]
        return shown.name, shown.kind, held, next(c for c in held.connectors if c.name == variable)

    def _component(self, elements: Any, name: str, held: Component, box: Box) -> None:
        source, kind = self.files.fmus[held.fmu], "application/x-fmu-sharedlibrary"
        child = sub_element(elements, "ssd", "Component", name=name, type=kind, source=source)
        self._connectors(child, [(each.name, each.kind, held, each) for each in held.connectors], box)
        if held.values:
            bindings = sub_element(child, "ssd", "ParameterBindings")
            sub_element(bindings, "ssd", "ParameterBinding", source=self.files.parameters[held.name])

    def _connectors(self, parent: Any, shown: Sequence[_Shown], box: Box | None) -> None:
        """Add connectors, each with the type and the unit of a component's, and the box of their element."""
        held = sub_element(parent, "ssd", "Connectors") if shown else None
        for (name, kind, component, source), place in zip(shown, places([s[1] for s in shown]), strict=True):
            child = sub_element(held, "ssd", "Connector", name=name, kind=kind)
            self._type(child, component, source)
            if place is not None:
                sub_element(child, "ssd", "ConnectorGeometry", x=place[0], y=place[1])
        if box is not None:
            sub_element(parent, "ssd", "ElementGeometry", x1=box[0], y1=box[1], x2=box[2], y2=box[3])

    def _type(self, connector: Any, held: Component, source: Connector) -> None:
        info, where = read_description(held.fmu), f"{held.name}.{source.name}"
        variable = variable_of(info, source.name, where)
        if source.type == "Enumeration":
            if variable.items:
                enumeration = f"{info.model_name}.{source.name}"
                self.enumerations[enumeration] = variable.items
                sub_element(connector, "ssc", "Enumeration", name=enumeration)
            return
        unit = _unit(self.system, held, variable)
        sub_element(connector, "ssc", source.type, unit=None if unit is None else unit.name)
        if unit is not None and self.units.setdefault(unit.name, unit) != unit:
            raise InputError(f"{where}: its FMU defines the unit {unit.name} unlike another FMU; rename one")


def _unit(system: System, held: Component, variable: Variable) -> Unit | None:
    """Give a variable's unit with its meaning; None where there is none, or it has no known meaning."""
    declared = next((c.unit for c in held.connectors if c.name == variable.name), None)
    named = system.units.get(declared, Unit(declared)) if declared else None
    unit = own_unit(read_description(held.fmu), variable, named)
    try:
        return None if unit is None else meaning(unit)
    except InputError:
        # An SSD may only name units that it can define; a reader takes it from the FMU then.
        return None


def _fixed_step_master(system: Any, step: float | None) -> None:
    """Add the annotation by which OMSimulator knows a system of co-simulation, which it refuses without."""
    if step is not None:
        notes = sub_element(sub_element(system, "ssd", "Annotations"), "ssc", "Annotation", type=OMS)
        told = sub_element(sub_element(notes, "oms", "Annotations"), "oms", "SimulationInformation")
        settings = {"stepSize": float(step), "absoluteTolerance": 1e-4, "relativeTolerance": 1e-4}
        sub_element(told, "oms", "FixedStepMaster", description="oms-ma", **settings)


def _experiment(root: Any, experiment: DefaultExperiment) -> None:
    start, stop, step = experiment.start_time, experiment.stop_time, experiment.step_size
    times = {"startTime": float(start), "stopTime": None if stop is None else float(stop)}
    child = sub_element(root, "ssd", "DefaultExperiment", **times)
    if step is not None:
        # SSP has no word for a step size; this annotation is the one that libcosim reads.
        notes = sub_element(child, "ssd", "Annotations")
        note = sub_element(notes, "ssc", "Annotation", type="com.opensimulationplatform")
        algorithm = sub_element(note, "osp", "Algorithm")
        sub_element(algorithm, "osp", "FixedStepAlgorithm", baseStepSize=float(step))


def _ssv(held: Component, system: System) -> Any:
    info = read_description(held.fmu)
    values: dict[str, Value | Parameter] = {}
    for name, value in held.values.items():
        variable = variable_of(info, name, f"{held.name}.{name}")
        if variable.kind == "Real":
            values[name] = Parameter(name, "Real", float(value), _unit(system, held, variable))
        elif variable.kind == "Enumeration":
            item = next((item for item, number in variable.items.items() if number == value), None)
            if item is None:
                raise InputError(f"{name}: {value} is no item of its enumeration; give one of its items")
            values[name] = Parameter(name, "Enumeration", item)
        else:
            values[name] = value
    return parameter_set_element(PARAMETER_SET, values)
