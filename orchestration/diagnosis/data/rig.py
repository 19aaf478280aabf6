"""The system that measurements come from: its plant, and what its wires say of inputs and sensors.

A rig is derived from a shipped system. The names in it are those of the SSP: instance, dot, variable.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

from warmlink.fmus.component import Component, Scalar
from warmlink.fmus.component.join import join
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.thermal_link.component import CELLS, thermal_link
from warmlink.orchestration import catalogue
from warmlink.orchestration.system.shipped import COMPENSATOR, SHIPPED, Blueprint

ELONGATION = "link.elongation"

AT_SENSOR = {"link.base_temperature": 1, "link.tip_temperature": 3}
"""Elements of `link.sensor_temperature` that are outputs of their own as well."""

_DEMANDS = {
    "MotorHeatSource": (
        ("speed",),
        ("torque", "current"),
        ("pad_temperature", "pad_power"),
        ("ambient_temperature",),
    ),
    "Heater": (("on",),),
    "ThermalLink": (("ambient_temperature",),),
}
"""Inputs of a component that every run should have, each with those that may stand in its place."""


@dataclass(frozen=True)
class Rig:
    """A system whose plant, its continuous components, is integrated as a whole.

    Attributes
    ----------
    blueprint : the shipped system
    cells : finite volumes of a link
    """

    blueprint: Blueprint
    cells: int = CELLS

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.blueprint.name

    @cached_property
    def components(self) -> Mapping[str, Component]:
        """Continuous components by instance name."""
        kinds = catalogue.components()
        return {
            instance: thermal_link(self.cells) if kind == "ThermalLink" else kinds[kind]
            for instance, kind in self.blueprint.components.items()
            if kind and kinds[kind].rates is not None
        }

    @cached_property
    def component(self) -> Component:
        """The plant, joined."""
        inside = [w for w in self.blueprint.wires if all(_instance(end) in self.components for end in w)]
        return join(self.name, self.components, inside)

    @cached_property
    def variables(self) -> dict[str, Scalar]:
        """Every scalar variable by its full name, without the inputs that a component of the plant feeds."""
        return {scalar.name: scalar for scalar in self.component.scalars()}

    @property
    def externals(self) -> list[str]:
        """Inputs that no component of the plant feeds, in order."""
        return self.component.u.names

    @property
    def parameters(self) -> list[str]:
        """Parameters of all components, in order."""
        return self.component.p.names

    @cached_property
    def shared(self) -> Mapping[str, tuple[str, ...]]:
        """Inputs of the plant by the signal from outside that feeds them."""
        found = dict(self.blueprint.signals)
        for source, target in self.blueprint.wires:
            if _instance(source) not in self.components and _instance(target) in self.components:
                found[source] = (*found.get(source, ()), target)
        return found

    @cached_property
    def driven_by(self) -> tuple[tuple[str, ...], ...]:
        """Inputs that every run should have, each with those that may stand in its place."""
        found: list[tuple[str, ...]] = []
        for instance in self.components:
            for names in _DEMANDS.get(self.blueprint.components[instance], ()):
                group = tuple(f"{instance}.{name}" for name in names)
                if not any(group[0] in self.fed_with(known[0]) for known in found):
                    found.append(group)
        return tuple(found)

    @cached_property
    def columns(self) -> dict[str, str]:
        """Input or output by the name of its column in a bare CSV file."""
        sources = {target: source for source, target in self.blueprint.wires}
        found = {_variable(sources[t]): t for t, *_ in self.driven_by if t in sources}
        for reading, target in self.blueprint.wires:
            if _instance(target) == COMPENSATOR and ".reading[" in reading:
                found[_variable(target)] = sources[reading.replace(".reading[", ".temperature[")]
            elif self._is_camera(target):
                found[_variable(target)] = reading
        return found

    @cached_property
    def readings(self) -> Mapping[str, str]:
        """Sensor channel that reads an output, as `sensors[3]`; the camera reads the elongation."""
        found = dict(self._wired_readings())
        for output, element in AT_SENSOR.items():
            also = f"link.sensor_temperature[{element}]"
            for one, other in ((output, also), (also, output)):
                if one in found:
                    found.setdefault(other, found[one])
        return found

    def _wired_readings(self) -> Iterator[tuple[str, str]]:
        yield from self.blueprint.instruments.items()
        for output, target in self.blueprint.wires:
            if ".temperature[" in target:
                yield output, target.replace(".temperature[", "[")
            elif self._is_camera(target):
                yield output, _instance(target)

    def _is_camera(self, end: str) -> bool:
        """Whether an end is what a camera looks at."""
        return self.blueprint.components[_instance(end)] == "DriftCamera" and _variable(end) == "elongation"

    def unit(self, name: str) -> str:
        """SI unit of a variable."""
        return self.variables[name].variable.unit

    def scalar(self, name: str, where: str) -> Scalar:
        """Declaration of a variable.

        Raises
        ------
        InputError
            The rig has no such variable.
        """
        if name not in self.variables:
            held = [n for n in self.variables if _instance(n) == _instance(name)]
            raise InputError(
                f"{where}: {self.name} has no variable {name}; {instead(name, held or self.variables)}"
            )
        return self.variables[name]

    def column_of(self, variable: str) -> str:
        """Name of a variable's column in a bare CSV file; its own where there is none."""
        return next((column for column, named in self.columns.items() if named == variable), variable)

    def fed_with(self, name: str) -> tuple[str, ...]:
        """Inputs that a signal for this input feeds, itself among them."""
        return next((group for group in self.shared.values() if name in group), (name,))


@cache
def rig(name: str, cells: int = CELLS) -> Rig:
    """Rig of a shipped system by name.

    Raises
    ------
    InputError
        There is no such system.
    """
    if name not in SHIPPED:
        raise InputError(f"system: {name!r} is not one that can be diagnosed; {instead(name, SHIPPED)}")
    return Rig(SHIPPED[name], cells)


def _instance(end: str) -> str:
    return end.partition(".")[0]


def _variable(end: str) -> str:
    return end.partition(".")[2]
