"""Writing a system as an SSP that other masters read as well: SSP 1.0, plain prefixes, nothing to convert."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.assemble import check_system
from warmlink.orchestration.system.check import own_unit, variable_of
from warmlink.orchestration.system.description import ModelInfo, Variable, read_description
from warmlink.orchestration.system.model import (
    Component,
    Connection,
    Connector,
    DefaultExperiment,
    ParameterSet,
    System,
    Value,
)
from warmlink.orchestration.system.parameter_values import Parameter, parameter_set_element, write_whole
from warmlink.orchestration.system.ssp_xml import element, sub_element, to_bytes, unit_elements
from warmlink.orchestration.system.units import Unit, meaning

# The earliest date that a zip can hold: the same system gives the same bytes on any day.
_DATE = (1980, 1, 1, 0, 0, 0)
# Every component's set bears this name: Ecos applies the sets of one name, which its user gives.
PARAMETER_SET = ParameterSet().name


def write_ssp(system: System, path: Path) -> None:
    """Write a system with its FMUs into one SSP file, whole or not at all; equal systems give equal bytes.

    Each component is bound to a parameter set of its own under `resources`. A connection that is more
    than the identity is written as a LinearTransformation between the variables' own units.

    Parameters
    ----------
    system
        What to write.
    path
        The .ssp file.

    Raises
    ------
    InputError
        If the system does not fit its FMUs, or two FMUs define one unit differently.
    """
    check_system(system)
    names = _resource_names(system.components.values())
    entries = {"SystemStructure.ssd": to_bytes(_ssd(system, names))}
    for held in system.components.values():
        if held.parameters.values:
            entries[_ssv_name(held)] = to_bytes(_ssv(held, system.units))
        entries[names[held.fmu]] = held.fmu.read_bytes()
    write_whole(path, _zipped(entries))


def _zipped(entries: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in entries.items():
            info = zipfile.ZipInfo(name, _DATE)
            info.create_system = 3
            info.external_attr = 0o644 << 16
            # Stored: FMUs are compressed already, and the bytes then do not depend on a zlib version.
            archive.writestr(info, data, zipfile.ZIP_STORED)
    return stream.getvalue()


def _resource_names(components: Iterable[Component]) -> dict[Path, str]:
    """Give each FMU a name under resources: its own, or with the component's where that is taken."""
    names: dict[Path, str] = {}
    for held in components:
        if held.fmu not in names:
            name = f"resources/{held.fmu.name}"
            if name in names.values():
                name = f"resources/{held.name}-{held.fmu.name}"
            names[held.fmu] = name
    return names


def _ssv_name(held: Component) -> str:
    return f"resources/{held.name}.ssv"


def _ssd(system: System, names: dict[Path, str]) -> Any:
    root = element(
        "ssd", "SystemStructureDescription", version="1.0", name=system.name, generationTool="warmlink"
    )
    top = sub_element(root, "ssd", "System", name=system.name)
    elements = sub_element(top, "ssd", "Elements")
    enumerations: dict[str, dict[str, int]] = {}
    units: dict[str, Unit] = {}
    for held in system.components.values():
        _component(elements, held, names[held.fmu], enumerations, _Units(held, system.units, units))
    if system.connections:
        links = sub_element(top, "ssd", "Connections")
        for link in system.connections:
            _connection(links, link, system)
    _enumerations(root, enumerations)
    unit_elements(root, "ssd", units.values())
    _experiment(root, system.default_experiment)
    return root


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
    elements: Any, held: Component, source: str, enumerations: dict[str, dict[str, int]], units: _Units
) -> None:
    kind = "application/x-fmu-sharedlibrary"
    child = sub_element(elements, "ssd", "Component", name=held.name, type=kind, source=source)
    if held.connectors:
        connectors = sub_element(child, "ssd", "Connectors")
        for connector in held.connectors:
            _connector(connectors, connector, enumerations, units)
    if held.parameters.values:
        bindings = sub_element(child, "ssd", "ParameterBindings")
        sub_element(bindings, "ssd", "ParameterBinding", source=_ssv_name(held))


def _connector(
    connectors: Any, connector: Connector, enumerations: dict[str, dict[str, int]], units: _Units
) -> None:
    child = sub_element(connectors, "ssd", "Connector", name=connector.name, kind=connector.kind)
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


def _connection(links: Any, link: Connection, system: System) -> None:
    child = sub_element(
        links,
        "ssd",
        "Connection",
        startElement=link.source_component,
        startConnector=link.source_variable,
        endElement=link.target_component,
        endConnector=link.target_variable,
    )
    if (link.factor, link.offset) != (1.0, 0.0):
        child.set("suppressUnitConversion", "true")
        sub_element(child, "ssc", "LinearTransformation", factor=repr(link.factor), offset=repr(link.offset))


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
