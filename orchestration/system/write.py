"""Writing a system as an SSP that other masters read as well: SSP 1.0, plain prefixes, nothing to convert."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.archive import write_archive
from warmlink.orchestration.system.assemble import check_system
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, Variable, read_description
from warmlink.orchestration.system.model import (
    Component,
    Connector,
    DefaultExperiment,
    ParameterSet,
    System,
    Value,
)
from warmlink.orchestration.system.ports import Ports, opened, with_connectors
from warmlink.orchestration.system.ssp.elements import element, sub_element, to_bytes, unit_elements
from warmlink.orchestration.system.ssp.nest import Edge, SystemConnector, Tree, flat, nested
from warmlink.orchestration.system.ssp.parameter_values import Parameter, parameter_set_element
from warmlink.orchestration.system.units import Unit, meaning

# Every component's set bears this name: Ecos applies the sets of one name, which its user gives.
PARAMETER_SET = ParameterSet().name
OMS = "org.openmodelica"


def write_ssp(system: System, path: Path, ports: Ports | None = None) -> None:
    """Write a system with its FMUs into one SSP file, whole or not at all; equal systems give equal bytes.

    Each component is bound to a parameter set of its own under `resources`. A connection that is more
    than the identity is written as a LinearTransformation between the variables' own units.

    Parameters
    ----------
    system
        What to write.
    path
        The .ssp file.
    ports
        What the system exchanges with a larger one; without, it runs by itself.

    Raises
    ------
    InputError
        If the system does not fit its FMUs, or two FMUs define one unit differently.
    """
    system = _checked(system)
    _write(*((system, flat(system)) if ports is None else opened(system, ports)), path)


def write_nested_ssp(system: System, path: Path) -> None:
    """Write a system as `write_ssp` does, but with a system inside it for each name before a dot.

    A component `axis1.link` becomes the component `link` of the system `axis1`, whose connectors pass on
    what crosses its bounds. Reading makes it flat again, under the same names.

    Raises
    ------
    InputError
        As `write_ssp`, and if a name before a dot is that of a component too.
    """
    system = _checked(system)
    _write(system, nested(system), path)


def _checked(system: System) -> System:
    system = with_connectors(system)
    check_system(system)
    return system


def _write(system: System, tree: Tree, path: Path) -> None:
    files = _Files(system.components.values())
    entries = {"SystemStructure.ssd": to_bytes(_ssd(system, tree, files))}
    for held in system.components.values():
        if held.parameters.values:
            entries[files.parameters[held.name]] = to_bytes(_ssv(held, system.units))
        entries[files.fmus[held.fmu]] = held.fmu.read_bytes()
    write_archive(path, entries)


class _Files:
    """What each FMU and each parameter set is called inside the SSP.

    Only letters, digits, dot, hyphen and underscore, because some readers do not decode a URI, and never
    two names that differ in capitals alone, because some file systems do not tell them apart.
    """

    def __init__(self, components: Iterable[Component]) -> None:
        self.fmus: dict[Path, str] = {}
        self.parameters: dict[str, str] = {}
        self._taken: set[str] = set()
        for held in components:
            if held.fmu not in self.fmus:
                self.fmus[held.fmu] = self._free(held.fmu.stem, ".fmu")
            self.parameters[held.name] = self._free(held.name, ".ssv")

    def _free(self, stem: str, suffix: str) -> str:
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", stem)
        names = (
            f"resources/{plain}{n}{suffix}"
            for n in itertools.chain([""], (f"-{i}" for i in itertools.count(2)))
        )
        name = next(name for name in names if name.casefold() not in self._taken)
        self._taken.add(name.casefold())
        return name


def _ssd(system: System, tree: Tree, files: _Files) -> Any:
    root = element(
        "ssd", "SystemStructureDescription", version="1.0", name=system.name, generationTool="warmlink"
    )
    document = _Document(system, files)
    document.add(root, system.name, tree)
    _enumerations(root, document.enumerations)
    unit_elements(root, "ssd", document.units.values())
    _experiment(root, system.default_experiment)
    return root


class _Document:
    """An SSD being written: which enumerations and units its elements have named so far."""

    def __init__(self, system: System, files: _Files) -> None:
        self.system = system
        self.files = files
        self.enumerations: dict[str, dict[str, int]] = {}
        self.units: dict[str, Unit] = {}

    def add(self, parent: Any, name: str, tree: Tree) -> None:
        """Add a system with all that is in it."""
        child = sub_element(parent, "ssd", "System", name=name)
        if tree.connectors:
            connectors = sub_element(child, "ssd", "Connectors")
            for shown in tree.connectors:
                self._shown(connectors, shown)
        elements = sub_element(child, "ssd", "Elements")
        for inner, held in tree.components.items():
            _component(elements, inner, held, self.files, self.enumerations, self._of(held))
        for inner, below in tree.systems.items():
            self.add(elements, inner, below)
        if tree.edges:
            links = sub_element(child, "ssd", "Connections")
            for edge in tree.edges:
                _connection(links, edge)
        _fixed_step_master(child, self.system.default_experiment.step_size)

    def _of(self, held: Component) -> _Units:
        return _Units(held, self.system.units, self.units)

    def _shown(self, connectors: Any, shown: SystemConnector) -> None:
        """Add a connector of a system: named and directed as the system has it, typed as its source is."""
        component, variable = shown.source
        held = self.system.components[component]
        source = next(connector for connector in held.connectors if connector.name == variable)
        child = sub_element(connectors, "ssd", "Connector", name=shown.name, kind=shown.kind)
        _typed(child, source, self.enumerations, self._of(held))


class _Units:
    """Where the units of one component are defined, and the definitions used so far in the document."""

    def __init__(self, held: Component, of_system: dict[str, Unit], used: dict[str, Unit]) -> None:
        self.held = held
        self.info: ModelInfo = read_description(held.fmu)
        self.of_system = of_system
        self.used = used

    def of(self, variable: Variable) -> Unit | None:
        """Give a variable's unit with its meaning; None where there is none, or it has no known meaning."""
        declared = next((c.unit for c in self.held.connectors if c.name == variable.name), None)
        named = self.of_system.get(declared, Unit(declared)) if declared else None
        unit = own_unit(self.info, variable, named)
        if unit is None:
            return None
        try:
            return meaning(unit)
        except InputError:
            # An SSD may only name units that it can define; a reader takes it from the FMU then.
            return None

    def use(self, variable: Variable) -> str | None:
        """Give the name of a variable's unit and note its definition for the document."""
        unit = self.of(variable)
        if unit is None:
            return None
        known = self.used.setdefault(unit.name, unit)
        if known != unit:
            where = f"{self.held.name}.{variable.name}"
            raise InputError(f"{where}: its FMU defines the unit {unit.name} unlike another FMU; rename one")
        return unit.name


def _component(
    elements: Any,
    name: str,
    held: Component,
    files: _Files,
    enumerations: dict[str, dict[str, int]],
    units: _Units,
) -> None:
    kind = "application/x-fmu-sharedlibrary"
    child = sub_element(elements, "ssd", "Component", name=name, type=kind, source=files.fmus[held.fmu])
    if held.connectors:
        connectors = sub_element(child, "ssd", "Connectors")
        for connector in held.connectors:
            _connector(connectors, connector, enumerations, units)
    if held.parameters.values:
        bindings = sub_element(child, "ssd", "ParameterBindings")
        sub_element(bindings, "ssd", "ParameterBinding", source=files.parameters[held.name])


def _connector(
    connectors: Any, connector: Connector, enumerations: dict[str, dict[str, int]], units: _Units
) -> None:
    child = sub_element(connectors, "ssd", "Connector", name=connector.name, kind=connector.kind)
    _typed(child, connector, enumerations, units)


def _typed(child: Any, connector: Connector, enumerations: dict[str, dict[str, int]], units: _Units) -> None:
    """Tell a connector's type, and its unit where it has one."""
    variable = variable_of(units.info, connector.name, f"{units.held.name}.{connector.name}")
    if connector.type == "Enumeration":
        name = f"{units.info.model_name}.{connector.name}"
        if variable.items:
            enumerations[name] = variable.items
            sub_element(child, "ssc", "Enumeration", name=name)
        return
    typed = sub_element(child, "ssc", connector.type)
    unit = units.use(variable)
    if unit is not None:
        typed.set("unit", unit)


def _connection(links: Any, edge: Edge) -> None:
    ends = {
        "startElement": edge.start_element,
        "startConnector": edge.start_connector,
        "endElement": edge.end_element,
        "endConnector": edge.end_connector,
    }
    named = {key: name for key, name in ends.items() if name is not None}
    child = sub_element(links, "ssd", "Connection", **named)
    if (edge.factor, edge.offset) != (1.0, 0.0):
        child.set("suppressUnitConversion", "true")
        sub_element(child, "ssc", "LinearTransformation", factor=repr(edge.factor), offset=repr(edge.offset))


def _fixed_step_master(system: Any, step: float | None) -> None:
    """Add the annotation by which OMSimulator knows a system of co-simulation, which it refuses without."""
    if step is not None:
        notes = sub_element(sub_element(system, "ssd", "Annotations"), "ssc", "Annotation", type=OMS)
        told = sub_element(sub_element(notes, "oms", "Annotations"), "oms", "SimulationInformation")
        settings = {"stepSize": step, "absoluteTolerance": 1e-4, "relativeTolerance": 1e-4}
        master = {key: repr(float(value)) for key, value in settings.items()}
        sub_element(told, "oms", "FixedStepMaster", description="oms-ma", **master)


def _enumerations(root: Any, enumerations: dict[str, dict[str, int]]) -> None:
    if not enumerations:
        return
    held = sub_element(root, "ssd", "Enumerations")
    for name, items in enumerations.items():
        child = sub_element(held, "ssc", "Enumeration", name=name)
        for item, number in items.items():
            sub_element(child, "ssc", "Item", name=item, value=str(number))


def _experiment(root: Any, experiment: DefaultExperiment) -> None:
    child = sub_element(root, "ssd", "DefaultExperiment", startTime=repr(float(experiment.start_time)))
    if experiment.stop_time is not None:
        child.set("stopTime", repr(float(experiment.stop_time)))
    if experiment.step_size is not None:
        # SSP has no word for a step size; this annotation is the one that libcosim reads.
        notes = sub_element(child, "ssd", "Annotations")
        note = sub_element(notes, "ssc", "Annotation", type="com.opensimulationplatform")
        algorithm = sub_element(note, "osp", "Algorithm")
        sub_element(algorithm, "osp", "FixedStepAlgorithm", baseStepSize=repr(float(experiment.step_size)))


def _ssv(held: Component, of_system: dict[str, Unit]) -> Any:
    units = _Units(held, of_system, {})
    values: dict[str, Value | Parameter] = {}
    for name, value in held.parameters.values.items():
        variable = variable_of(units.info, name, f"{held.name}.{name}")
        if variable.kind == "Real":
            values[name] = Parameter(name, "Real", float(value), units.of(variable))
        elif variable.kind == "Enumeration":
            values[name] = Parameter(name, "Enumeration", _item(variable, value))
        else:
            values[name] = value
    return parameter_set_element(PARAMETER_SET, values, {})


def _item(variable: Variable, value: Value) -> str:
    name = next((item for item, number in variable.items.items() if number == value), None)
    if name is None:
        raise InputError(f"{variable.name}: {value} is no item of its enumeration; give one of its items")
    return name
