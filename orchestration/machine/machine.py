"""A machine: its parts, their wires, what its variables are for, and its nominal values.

One class for every machine, shipped or somebody's own; whatever is done to a machine starts from it:

    machine = machine_named("WarmupCell")        a shipped one, from its file in `library/`
    machine = machine_in(named)                  anybody's: an SSP, and the roles of its variables
    machine.joined(law)                          one component: for rollouts, FMUs of a whole system, pages
    machine.system(fmus, law)                    FMUs and connections: for an SSP, and for the master
    plant_of(machine, declared, values)          motors and links: for the design of a law
    Rig(machine)                                 equations, inputs and sensors: for a diagnosis
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import Wire, join
from warmlink.fmus.component.table import RecordedTable
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.tabled import with_table
from warmlink.fmus.packaging.views import with_flag_wires
from warmlink.fmus.recorded_duty.component import playing
from warmlink.orchestration import catalogue
from warmlink.orchestration.machine.roles import AS_THEY_ARE, NOTHING_SCORED, Roles, Sensors
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, StartValues, System, Value
from warmlink.orchestration.system.ports import Ports
from warmlink.orchestration.system.units import Conversion

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Result

DUTY, COMPENSATOR = "duty", "compensator"
"""Usual instances of what drives a machine, and of a controller, whose component differs from run to run."""

DRIVER, PLAYER, THERMOMETERS, CHANNELS = "DutyCycle", "RecordedDuty", "TemperatureSensors", 8

KINDS = {
    **{DUTY: DRIVER, "motor": "MotorHeatSource", "link": "ThermalLink", "heater": "Heater"},
    **{"sensors": THERMOMETERS, "camera": "DriftCamera", "poses": "PoseSequence", COMPENSATOR: ""},
}
"""Component behind each kind of part, by which people name it; empty: a controller."""

Designs = Callable[[str, Sensors], StartValues | None]
"""Function that returns the controllers' start values for a machine by the law's name, or None."""

Plots = Mapping[tuple[str, str], Mapping[str, str]]
"""Variables by the name of their line, by heading and unit."""

Program = Callable[[Mapping[str, Any], str, Path], Any]
"""Function that makes a scenario of the tables of a file, its name and its folder."""


@dataclass(frozen=True)
class Machine:
    """A machine, before its FMUs exist.

    Attributes
    ----------
    parts : name of the component behind each instance, `ThermalLink` behind `link`; empty: a controller
    wires : ends of each connection, as `("motor.heat_flow", "link.heat_flow")`
    roles : what is scored
    nominal : start values that differ from what its components declare, in the units of their FMUs
    sensors : thermometers that the controllers use unless a scenario says otherwise
    signals : inputs that one signal from outside the machine feeds, by the name of the signal
    instruments : sensor or camera outside the machine by the output that it reads, as `sensors[1]`
    shown : start values of inputs with which the shipped SSP does something by itself
    ports : what a larger system that holds this one exchanges with it
    foreign : FMUs that came with the machine, by what `parts` calls them
    scaled : what a wire does besides converting units, by the input that it feeds
    tables : what instances of RecordedDuty play
    designs : parameters of the laws for this machine; None if the shipped laws were designed for it
    program : reads the scenarios that are made for it; None if it is driven by duty cycles
    detail : additional figures of a run of this machine, for `uncompensated` and `compensated`
    laws, mismatches : names of what is compared on it unless somebody says otherwise; empty: all
    plots : variables by the name of their line, by heading and unit; empty: outputs by their unit
    sections : function of further sections of its report, as `package.module:function`
    showcase : scenario that its shipped SSP runs by default, if it is one
    """

    name: str
    about: str
    parts: Mapping[str, str]
    wires: tuple[Wire, ...] = ()
    roles: Roles = NOTHING_SCORED
    nominal: StartValues = field(default_factory=dict)
    sensors: Sensors = AS_THEY_ARE
    stop_time: float = 3600.0
    step_size: float = 1.0
    signals: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    instruments: Mapping[str, str] = field(default_factory=dict)
    shown: StartValues = field(default_factory=dict)
    ports: Ports | None = None
    foreign: Mapping[str, Path] = field(default_factory=dict)
    scaled: Mapping[str, Conversion] = field(default_factory=dict)
    tables: Mapping[str, RecordedTable] = field(default_factory=dict)
    designs: Designs | None = None
    program: Program | None = None
    detail: Callable[[Result], Mapping[str, Mapping[str, Any]]] | None = None
    laws: tuple[str, ...] = ()
    mismatches: tuple[str, ...] = ()
    plots: Plots = field(default_factory=dict)
    sections: str = ""
    showcase: str = ""

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that the machine needs, without the controllers."""
        return {kind for kind in self.parts.values() if kind} - self.foreign.keys()

    @property
    def controllers(self) -> tuple[str, ...]:
        """Instances that are places for the controller."""
        return tuple(instance for instance, kind in self.parts.items() if not kind)

    @property
    def corrections(self) -> tuple[str, ...]:
        """Names of the controllers' outputs that correct the error."""
        return tuple(f"{instance}.correction" for instance in self.controllers)

    @property
    def claims(self) -> tuple[str, ...]:
        """Names of the controllers' outputs that say that the error is within tolerance."""
        return tuple(f"{instance}.ready" for instance in self.controllers)

    @cached_property
    def fed(self) -> Mapping[str, str]:
        """The output behind each input that a wire feeds."""
        return {target: source for source, target in self.wires}

    @cached_property
    def driven(self) -> Mapping[str, str]:
        """Demand of a duty cycle, as `speed`, behind each input that one drives."""
        drivers = {part for part, kind in self.parts.items() if kind in (DRIVER, PLAYER)}
        split = {target: source.rpartition(".") for target, source in self.fed.items()}
        return {target: demand for target, (part, _, demand) in split.items() if part in drivers}

    @property
    def growth(self) -> Mapping[str, float]:
        """Weights of the outputs that add up to what a controller should take out; empty if nothing says it.

        Without roles it is the elongation of the only link.
        """
        if self.roles is not NOTHING_SCORED:
            with suppress(InputError):  # a norm, for example, is no sum
                return self.roles.uncompensated.weights()
            return {}
        links = self.called("link")
        return {f"{links[0]}.elongation": 1.0} if len(links) == 1 else {}

    @cached_property
    def reduced(self) -> Mapping[str, Component]:
        """Links that `warmlink reduce` made, among the FMUs that came with the machine."""
        found = {kind: catalogue.reduced_link_in(path) for kind, path in self.foreign.items()}
        return {kind: each for kind, each in found.items() if each is not None}

    @cached_property
    def terms(self) -> Mapping[str, Component]:
        """Terms, whose FMUs hold their equations, among the FMUs that came with the machine."""
        found = {kind: catalogue.heat_term_in(path) for kind, path in self.foreign.items()}
        return {kind: each for kind, each in found.items() if each is not None}

    @property
    def never_joined(self) -> str:
        """Why the machine cannot be one component; empty where it can."""
        if unknown := [kind for kind in self.foreign if kind not in self.terms]:
            return f"contains foreign FMUs ({', '.join(unknown)}), whose equations are not known"
        return f"a connection scales what it carries ({', '.join(self.scaled)})" if self.scaled else ""

    def declared(self, law: Component) -> dict[str, Component]:
        """Declaration of each instance that is a component of warmlink, with the controllers' law."""
        known = {**catalogue.components(), **self.reduced, **self.terms, law.name: law}
        kinds = self.parts_with(law.name)
        return {name: self._playing(name, known[kind]) for name, kind in kinds.items() if kind in known}

    def _playing(self, instance: str, component: Component) -> Component:
        """The declaration of an instance, with its table if it plays one."""
        return playing(component, self.tables[instance]) if instance in self.tables else component

    def called(self, kind: str) -> list[str]:
        """Instances of a kind of `KINDS`: for `motor` all motors."""
        more = {DUTY: (PLAYER,), "link": self.reduced}.get(kind, ())
        kinds = {KINDS.get(kind), *more}
        return [instance for instance, each in self.parts.items() if each in kinds]

    def addressed(self, name: str) -> list[str]:
        """Variables that a full name stands for: for `compensator.gain` those of all places of a controller.

        A machine whose own part is called `compensator` means that one.
        """
        instance, _, variable = name.rpartition(".")
        if instance != COMPENSATOR or instance in self.parts:
            return [name]
        return [f"{each}.{variable}" for each in self.controllers] or [name]

    def noisy(self, noise: float) -> dict[str, dict[str, Value]]:
        """Start values of the thermometers that give their readings a noise in K (1 sigma)."""
        channels = {f"noise[{channel}]": noise for channel in range(1, CHANNELS + 1)}
        return {each: {**channels, "seed": i} for i, each in enumerate(self.called("sensors"), start=1)}

    def parts_with(self, controller: str | None) -> dict[str, str]:
        """Component behind each instance, once the controller's component is known."""
        return {instance: kind or str(controller) for instance, kind in self.parts.items()}

    def without(self, *instances: str) -> Machine:
        """The same without some instances and the wires at them."""
        left = {name: kind for name, kind in self.parts.items() if name not in instances}
        wires = [wire for wire in self.wires if all(end.rpartition(".")[0] in left for end in wire)]
        scaled = {end: self.scaled[end] for _, end in wires if end in self.scaled}
        tables = {name: table for name, table in self.tables.items() if name in left}
        return replace(self, parts=left, wires=tuple(wires), scaled=scaled, tables=tables)

    def prefixed(self, prefix: str) -> Machine:
        """The same with a prefix and a dot before every instance of its parts, wires and tables."""
        parts = {f"{prefix}.{name}": kind for name, kind in self.parts.items()}
        wires = tuple((f"{prefix}.{source}", f"{prefix}.{target}") for source, target in self.wires)
        tables = {f"{prefix}.{name}": table for name, table in self.tables.items()}
        return replace(self, parts=parts, wires=wires, tables=tables)

    def driven_by(self, tables: Mapping[str, RecordedTable]) -> Machine:
        """The machine whose instances play tables, not segments; without tables `duty` has segments."""
        changed = {name: PLAYER for name in tables if self.parts.get(name) in (DRIVER, PLAYER)}
        if not tables and self.parts.get(DUTY) == PLAYER:
            changed = {DUTY: DRIVER}
        every = {**self.tables, **tables}
        played = {name: each for name, each in every.items() if changed.get(name) != DRIVER}
        if not changed or (changed.items() <= self.parts.items() and played == self.tables):
            return self
        nominal = {name: of for name, of in self.nominal.items() if name not in changed}
        return replace(self, parts={**self.parts, **changed}, tables=played, nominal=nominal)

    def with_nominal(self, values: StartValues) -> StartValues:
        """Start values by instance and variable with the nominal ones of the machine beside them."""
        return {**values, **{key: {**of, **values.get(key, {})} for key, of in self.nominal.items()}}

    def joined(self, controller: Component | None = None, values: StartValues | None = None) -> Component:
        """The machine as one component.

        The controller fills every place left for one; start values are by instance and variable, in SI
        units. InputError for foreign FMUs, a wire that scales, or a place without a controller.
        """
        if controller is None and self.controllers:
            raise InputError(f"{self.name}: {self.controllers[0]} is a controller's place; name a controller")
        if self.never_joined:
            raise InputError(f"{self.name}: {self.never_joined}; run it with a master instead")
        kinds = {**catalogue.components(), **self.terms, **({} if controller is None else {"": controller})}
        parts = {name: self._playing(name, kinds[kind]) for name, kind in self.parts.items()}
        joined = join(self.name, parts, self.wires, self.about)
        chosen = self.with_nominal(values or {}).items()
        every = ((f"{key}.{name}", v) for key, of in chosen for name, v in of.items())
        given = {name: float(v) for name, v in every if name not in self.fed}
        inputs = tuple(replace(each, start=given.pop(each.name, each.start)) for each in joined.inputs)
        return replace(
            joined,
            inputs=inputs,
            parameters=with_scalars(joined.parameters, given),
            default_stop_time=self.stop_time,
            default_step_size=self.step_size,
        )

    def system(
        self, fmus: Mapping[str, Path], controller: str | None = None, values: StartValues | None = None
    ) -> System:
        """FMUs by the component's name with the machine's wires, and start values in SI units.

        The component of the compensator is chosen with the controller; the values are by instance and
        variable. InputError if a value is meant for an instance that the machine does not have, or an end, a
        value or a unit does not fit the FMUs.
        """
        known = {**self.foreign, **fmus}
        files = {instance: known[kind] for instance, kind in self.parts_with(controller).items()}
        files |= {instance: with_table(files[instance], table) for instance, table in self.tables.items()}
        ends = {f"{name}.{each}" for name, fmu in files.items() for each in read_description(fmu).variables}
        wires = with_flag_wires(self.wires, ends)
        experiment = DefaultExperiment(0.0, self.stop_time, self.step_size)
        whole = assemble(self.name, files, wires, self.with_nominal(values or {}))
        links = tuple(
            replace(link, **asdict(self.scaled[link.target])) if link.target in self.scaled else link
            for link in whole.connections
        )
        return replace(whole, connections=links, default_experiment=experiment)


def merged(*parts: StartValues) -> dict[str, dict[str, Value]]:
    """Merge start values of several sources; later sources take precedence."""
    values: dict[str, dict[str, Value]] = {}
    for part in parts:
        for instance, chosen in part.items():
            values.setdefault(instance, {}).update(chosen)
    return values
