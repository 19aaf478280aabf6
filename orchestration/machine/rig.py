"""A machine as it is measured: its plant, and what its wires say of inputs and sensors.

A rig is derived from a machine's wires. The names in it are those of the SSP: instance, dot, variable.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path

from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.component import Component, Input, Parameter, Scalar
from warmlink.fmus.component.join import join
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.fmus.heat_term.component import is_term
from warmlink.fmus.names import instead
from warmlink.fmus.thermal_link.component import CELLS, thermal_link
from warmlink.orchestration import catalogue
from warmlink.orchestration.machine.added_heat import Paths
from warmlink.orchestration.machine.machine import COMPENSATOR, DRIVER, PLAYER, Machine
from warmlink.orchestration.machine.roles import WeightedSum
from warmlink.orchestration.machine.shipped import machine_named, machines
from warmlink.orchestration.system.assemble import owner_of
from warmlink.orchestration.system.model import FmuPart, System, Value

AT_SENSOR = {"base_temperature": 1, "tip_temperature": 3}
"""Elements of a link's `sensor_temperature`, counted from 1, that are outputs of their own as well."""

SCALE, OFFSET, PLACE = "logged.scale", "logged.offset", "logged.place"
"""Slots before a colon and a variable, as `logged.scale:motor.torque`: a factor on an input, what is added to
an input, and the displacement of a sensor. No FMU has them: they belong to the log."""

_REQUIRED = {
    "MotorHeatSource": "speed torque|current pad_temperature|pad_power ambient_temperature",
    "Heater": "on",
    "ThermalLink": "ambient_temperature",
}
"""Inputs of a component that every run should have, with a space between; after | what may take its place."""


@dataclass(frozen=True, eq=False)
class Rig:
    """A machine as it is measured: its plant, which is all of it but sampled controllers and instruments.

    Attributes
    ----------
    machine : parts and wires, and nominal values in SI units
    cells : finite volumes of a link
    foreign : what is known of parts that are in no catalogue, by instance; of these reduced links alone have
        equations
    looped : whether FMUs are co-simulated, even where every part is a component of warmlink
    cut : outputs in whose place the log stands: the inputs that they feed follow it
    system : the FMUs, with the heat paths that causes may add to them; None for a shipped machine
    base, paths, parts_of_paths : the FMUs without the heat paths, the heat paths, and the FMUs of these
    moved : input of a heat path by the input in front of which it was put
    source : the file that names the machine with its roles, if there is one
    sums : weighted sums of outputs that columns hold, by their text
    """

    machine: Machine
    cells: int = CELLS
    foreign: Mapping[str, Component] = field(default_factory=dict)
    looped: bool = False
    cut: frozenset[str] = frozenset()
    system: System | None = None
    base: System | None = None
    paths: Paths = field(default_factory=dict)
    parts_of_paths: Mapping[str, FmuPart] = field(default_factory=dict)
    moved: Mapping[str, str] = field(default_factory=dict)
    source: Path | None = None
    sums: Mapping[str, WeightedSum] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self.machine.name

    @property
    def in_loop(self) -> bool:
        """Whether FMUs are simulated in a loop: a part's equations are not known, or it was asked for."""
        unknown = (part for part in self.foreign.values() if not is_term(part))
        return self.looped or any(part.rates is None for part in unknown)

    @cached_property
    def components(self) -> Mapping[str, Component]:
        """Continuous components, heat paths and foreign parts by instance name."""
        known = {**catalogue.components(), "ThermalLink": thermal_link(self.cells)}
        found = {}
        for instance, kind in self.machine.parts.items():
            part = self.foreign.get(instance) or known.get(kind)
            if part is None:
                continue
            simulated = part.rates is not None or part is HEAT_PATH or instance in self.foreign
            if simulated or (self.in_loop and part.name not in (DRIVER, PLAYER)):
                found[instance] = _with_values(part, self.machine.nominal.get(instance, {}))
        return found

    @cached_property
    def component(self) -> Component:
        """The plant, joined; for a rig that is not in a loop."""
        return join(self.name, self.components, self._wires(inside=True))

    def _wires(self, inside: bool) -> list[tuple[str, str]]:
        """Wires to the plant, from itself or from outside."""
        return [
            (source, target)
            for source, target in self.machine.wires
            if self.part_of(target) in self.components
            and inside == (self.part_of(source) in self.components and source not in self.cut)
        ]

    @cached_property
    def variables(self) -> dict[str, Scalar]:
        """Every scalar variable by its full name, without the inputs that a component of the plant feeds."""
        fed = {target for _, target in self._wires(inside=True)}
        return {text: each.scalar for text, each in self.sums.items()} | {
            name: replace(scalar, name=name)
            for instance, part in self.components.items()
            for scalar in part.scalars()
            if (name := f"{instance}.{scalar.name}") not in fed
        }

    def weights(self, name: str) -> Mapping[str, float]:
        """Outputs that make up what was measured, each with its weight; of a plain output itself alone."""
        return self.sums[name].weights if name in self.sums else {name: 1.0}

    @cached_property
    def externals(self) -> list[str]:
        """Inputs that no component of the plant feeds, in order."""
        return [name for name, each in self.variables.items() if isinstance(each.variable, Input)]

    @cached_property
    def parameters(self) -> list[str]:
        """Parameters of all components, in order."""
        return [name for name, each in self.variables.items() if isinstance(each.variable, Parameter)]

    @cached_property
    def wandering(self) -> dict[str, tuple[str, ...]]:
        """Slots that what nobody logged changes: a drift of the `room` in K, and of `heat` in W.

        Of a foreign part an input counts as the room's if it is in K and has `ambient` in its name.
        """
        room = [name for name in self.parameters if name.endswith(".ambient_offset")]
        heat = [name for name in self.parameters if name.endswith(".standby_power")]
        foreign = ((name, part) for name in self.externals if (part := self.part_of(name)) in self.foreign)
        ambient = (name for name, part in foreign if "ambient" in name.removeprefix(f"{part}."))
        room += (f"{OFFSET}:{name}" for name in ambient if self.unit(name) == "K")
        return {signal: tuple(names) for signal, names in (("room", room), ("heat", heat)) if names}

    @cached_property
    def inputs_by_signal(self) -> Mapping[str, tuple[str, ...]]:
        """Inputs of the plant by the signal from outside that feeds them, one or several."""
        found = dict(self.machine.signals)
        for source, target in self._wires(inside=False):
            found[source] = (*found.get(source, ()), target)
        return found

    @cached_property
    def demanded(self) -> Mapping[str, tuple[str, ...]]:
        """Inputs of the plant by what a duty cycle demands, one for each signal that feeds several."""
        found: dict[str, dict[str, str]] = {}
        for target, demand in self.machine.driven.items():
            if target in self.externals:
                found.setdefault(demand, {}).setdefault(self.machine.fed[target], target)
        return {demand: tuple(first.values()) for demand, first in found.items()}

    def input_behind(self, end: str) -> str:
        """Input of the plant with the signal that feeds an end, of a controller for example; empty: none."""
        return next(iter(self.inputs_by_signal.get(self.machine.fed.get(end, ""), ())), "")

    def part_of(self, name: str) -> str:
        """Instance whose variable a full name is; empty if no instance has it."""
        return owner_of(self.machine.parts, name)

    def called(self, part: str) -> list[str]:
        """Instances of the plant that are what the shipped systems call `motor`, `link` or `heater`."""
        return [instance for instance in self.machine.called(part) if instance in self.components]

    def on_link(self, output: str) -> tuple[str, int] | None:
        """Link, and element of its `sensor_temperature`, that an output shows; None if it shows none."""
        if output in self.sums:
            return None
        instance = self.part_of(output)
        variable = output[len(instance) + 1 :]
        name, _, element = variable.partition("[")
        at = AT_SENSOR.get(variable, int(element[:-1]) if element and name == "sensor_temperature" else None)
        return None if at is None or instance not in self.called("link") else (instance, at)

    def measured_at(self, variables: Iterable[str]) -> Rig:
        """The same rig with the log in place of the outputs behind these inputs, for all that they feed."""
        wanted = set(variables)
        cut = {source for source, target in self._wires(inside=True) if target in wanted}
        return replace(self, cut=self.cut | cut) if cut else self

    @cached_property
    def required_inputs(self) -> tuple[tuple[str, ...], ...]:
        """Inputs that runs should have, each with those in its place.

        A part needs none if the log stands in place of all its outputs that are wired.
        """
        found: dict[tuple[str, ...], tuple[str, ...]] = {}
        for instance in self.components:
            given = {source for source, _ in self.machine.wires if self.part_of(source) == instance}
            needed = "" if given and given <= self.cut else _REQUIRED.get(self.machine.parts[instance], "")
            for names in needed.split():
                group = tuple(f"{instance}.{name}" for name in names.split("|"))
                if group[0] in self.externals:
                    found.setdefault(self.fed_with(group[0]), group)
        return tuple(found.values())

    @cached_property
    def columns(self) -> dict[str, str]:
        """Input or output by the name of its column in a bare CSV file."""
        sources = {target: source for source, target in self.machine.wires}
        readers = {*self.machine.controllers, COMPENSATOR}
        found = {sources[t].rpartition(".")[2]: t for t, *_ in self.required_inputs if t in sources}
        for reading, target in self.machine.wires:
            if self.part_of(target) in readers and ".reading[" in reading:
                found[target.rpartition(".")[2]] = sources[reading.replace(".reading[", ".temperature[")]
            elif self._seen_by(target):
                found[target.rpartition(".")[2]] = reading
        if self.machine.controllers:  # what is scored is measured, by whatever instrument
            found |= {name: name for name in self.machine.growth if name not in found.values()}
        return found

    @cached_property
    def readings(self) -> Mapping[str, str]:
        """Sensor channel that reads an output, as `sensors[3]`; the camera reads the elongation."""
        found = dict(self.machine.instruments)
        for output, target in self.machine.wires:
            instrument = self._seen_by(target)
            if self.machine.parts[self.part_of(target)] == "TemperatureSensors":
                instrument = target.replace(".temperature[", "[") if ".temperature[" in target else ""
            if instrument:
                found[output] = instrument
        for link in self.called("link"):
            for name, element in AT_SENSOR.items():
                one, other = f"{link}.{name}", f"{link}.sensor_temperature[{element}]"
                if seen := found.get(one) or found.get(other):
                    found = {one: seen, other: seen, **found}
        return found

    def _seen_by(self, end: str) -> str:
        """Camera that looks at what comes in at an end; empty if none does."""
        part = self.part_of(end)
        return part if self.machine.parts[part] == "DriftCamera" and end == f"{part}.elongation" else ""

    def unit(self, name: str) -> str:
        """SI unit of a variable."""
        return self.variables[name].variable.unit

    def scalar(self, name: str, where: str) -> Scalar:
        """Declaration of a variable; raises InputError where the rig has no such variable."""
        if name not in self.variables:
            held = [n for n in self.variables if self.part_of(n) == self.part_of(name)]
            raise InputError(
                f"{where}: {self.name} has no variable {name}; {instead(name, held or self.variables)}"
            )
        return self.variables[name]

    def column_of(self, variable: str) -> str:
        """Name of a variable's column in a bare CSV file; its own name if it has none."""
        return next((column for column, named in self.columns.items() if named == variable), variable)

    @cached_property
    def measurable(self) -> tuple[str, ...]:
        """Names of columns of outputs that are usually measured."""
        named = (name for name, variable in self.columns.items() if variable not in self.externals)
        return tuple(named) or tuple(self.readings)

    def fed_with(self, name: str, given: Collection[str] = ()) -> tuple[str, ...]:
        """Inputs that a signal for this input feeds, itself among them; not others that are `given` apart."""
        group = next((group for group in self.inputs_by_signal.values() if name in group), (name,))
        return tuple(each for each in group if each == name or each not in given)


@cache
def rig(name: str, cells: int = CELLS) -> Rig:
    """Rig of a shipped machine by name; raises InputError if there is none, or it has no single plant."""
    if name not in machines() or machine_named(name).program:
        known = [each for each in machines() if not machine_named(each).program]
        raise InputError(f"system: {name!r} is not one that can be diagnosed; {instead(name, known)}")
    return Rig(machine_named(name), cells)


def _with_values(part: Component, values: Mapping[str, Value]) -> Component:
    """A component whose inputs and parameters start from given values."""
    numbers = {name: float(value) for name, value in values.items() if not isinstance(value, str)}
    inputs = tuple(replace(each, start=numbers.pop(each.name, each.start)) for each in part.inputs)
    settable = {name for each in part.parameters for name in each.scalar_names}
    chosen = {name: value for name, value in numbers.items() if name in settable}
    return replace(part, inputs=inputs, parameters=with_scalars(part.parameters, chosen))
