"""The system that a scenario runs in: its parts and wires, the roles of its variables, its sensors.

It is shipped, or other people's: a system of their own, as an SSP, or an FMU in place of a shipped part.

```toml
[roles]
speed = ["joint1.speed", "joint2.speed"]       # inputs that the duty cycle drives; torque and so on likewise
score = "link1.elongation + link2.elongation - compensator.correction"
controller = "compensator"                     # the instance, or a list of them, that a controller replaces
```
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from warmlink.controllers.interface import SENSED
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component, Output
from warmlink.fmus.component.table import Table as Rows
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.tabled import table_in
from warmlink.fmus.packaging.views import flag_of
from warmlink.orchestration import catalogue
from warmlink.orchestration.console import remark_once
from warmlink.orchestration.scenarios.duties.duty import DUTY
from warmlink.orchestration.scenarios.entries import Names, Quantity, Text
from warmlink.orchestration.scenarios.expression import Expression
from warmlink.orchestration.scenarios.written import Table
from warmlink.orchestration.system.assemble import connected, read_system
from warmlink.orchestration.system.check import variable_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import StartValues, System, Value
from warmlink.orchestration.system.replacement import Replacements
from warmlink.orchestration.system.shipped import COMPENSATOR, WARMUP_CELL, Blueprint
from warmlink.orchestration.system.units import Conversion, Unit

if TYPE_CHECKING:
    from warmlink.orchestration.master.recording.result import Result
    from warmlink.orchestration.scenarios.scenario import Scenario

TEMPERATURES = tuple(each.removesuffix("_temperature") for each in SENSED)
THERMOMETERS, CHANNELS = "TemperatureSensors", 8


@dataclass(frozen=True)
class Roles:
    """Roles of a system's variables: their `score` is the error of the tool point in m.

    `uncompensated` is the same error without a controller; of the coupling errors of the `plant`'s variables
    the largest is reported.
    """

    score: Expression
    uncompensated: Expression
    plant: tuple[str, ...]


@dataclass(frozen=True)
class Sensors(Table):
    """Thermometers that controllers use: noise (1 sigma), and which; None: as the system has them."""

    noise: Annotated[float | None, Quantity("K", least=0, difference=True)] = None
    used: Annotated[tuple[str, ...] | None, Names("base", TEMPERATURES)] = None


AS_THEY_ARE = Sensors()

Designs = Callable[[str, Sensors], StartValues | None]
"""Function that returns the controllers' start values for a system by the law's name, or None."""


@dataclass(frozen=True)
class Setup:
    """A system that scenarios run in.

    Attributes
    ----------
    blueprint : parts and wires; a part without a component is a place for the controller
    values : start values that differ from those that the parts declare
    sensors : thermometers that the controllers use unless the scenario says otherwise
    designs : parameters of the laws for this system; None if the shipped laws were designed for it
    detail : additional figures of a run of this system, for `uncompensated` and `compensated`
    """

    blueprint: Blueprint
    roles: Roles
    values: StartValues = field(default_factory=dict)
    sensors: Sensors = AS_THEY_ARE
    designs: Designs | None = None
    detail: Callable[[Result], Mapping[str, Mapping[str, Any]]] | None = None

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.blueprint.name

    @property
    def controllers(self) -> tuple[str, ...]:
        """Instances that are replaced by the controller."""
        return tuple(instance for instance, kind in self.blueprint.components.items() if not kind)

    @property
    def corrections(self) -> tuple[str, ...]:
        """Names of the controllers' outputs that correct the error."""
        return tuple(f"{instance}.correction" for instance in self.controllers)

    @property
    def claims(self) -> tuple[str, ...]:
        """Names of the controllers' outputs that say that the error is within tolerance."""
        return tuple(f"{instance}.ready" for instance in self.controllers)

    def driven_by(self, tables: Mapping[str, Rows]) -> Setup:
        """The system whose instances play tables in place of segments; without tables `duty` has segments."""
        held = self.blueprint
        changed = {name: PLAYER for name in tables if held.components.get(name) in (DRIVER, PLAYER)}
        if not tables and held.components.get(DUTY) == PLAYER:
            changed = {DUTY: DRIVER}
        played = {
            name: each for name, each in {**held.tables, **tables}.items() if changed.get(name) != DRIVER
        }
        if not changed or (changed.items() <= held.components.items() and played == held.tables):
            return self
        blueprint = replace(held, components={**held.components, **changed}, tables=played)
        values = {name: of for name, of in self.values.items() if name not in changed}
        return replace(self, blueprint=blueprint, values=values)

    def noisy(self, noise: float) -> dict[str, dict[str, Value]]:
        """Start values of the thermometers that give their readings a noise in K (1 sigma)."""
        channels = {f"noise[{channel}]": noise for channel in range(1, CHANNELS + 1)}
        called = self.blueprint.called("sensors")
        return {each: {**channels, "seed": i} for i, each in enumerate(called, start=1)}


_GROWTH = "link.elongation"
_CORRECTED = Expression(f"{_GROWTH} - {COMPENSATOR}.correction")

CELL = Setup(WARMUP_CELL, Roles(_CORRECTED, Expression(_GROWTH, "uncompensated"), (_GROWTH,)))
"""The warm-up cell: one motor, one link."""


def merged(*parts: StartValues) -> dict[str, dict[str, Value]]:
    """Merge start values of several sources; later sources take precedence."""
    values: dict[str, dict[str, Value]] = {}
    for part in parts:
        for instance, chosen in part.items():
            values.setdefault(instance, {}).update(chosen)
    return values


DRIVER, PLAYER = "DutyCycle", "RecordedDuty"

Driven = Annotated[tuple[str, ...], Names("motor.speed", single=True)]
Scored = Text(f"link.elongation - {COMPENSATOR}.correction")


@dataclass(frozen=True, kw_only=True)
class RolesTable(Table):
    """Roles in a system: the inputs that the duty cycle drives, the score, and the controllers' instances."""

    score: Annotated[str, Scored]
    uncompensated: Annotated[str | None, Scored] = None
    controller: Annotated[tuple[str, ...], Names(COMPENSATOR, single=True)] = (COMPENSATOR,)
    speed: Driven = ()
    torque: Driven = ()
    ambient_temperature: Driven = ()
    pad_mode: Driven = ()
    pad_temperature: Driven = ()
    pad_power: Driven = ()


def own_setup(path: Path, roles: RolesTable | None, where: str) -> Setup:
    """System of an SSP with the roles of its parts; `where` is the name of the scenario.

    Raises InputError if the file cannot be read, or a role names a variable that the system does not have.
    """
    where = f"{where}: roles"
    if roles is None:
        raise InputError(f"{where} is missing; write [roles] and below it score = {Scored.example!r}")
    system = read_system(path)
    for told in system.remarks:
        remark_once(told)
    for name in roles.controller:
        if name not in system.components:
            known = instead(name, system.components)
            raise InputError(f"{where}.controller: {system.name} has no component {name}; {known}")
    blueprint = blueprint_of(system, roles.controller)
    components = blueprint.components
    driven = _driven(system, roles, where)
    if driven:
        components = {DUTY: DRIVER, **components}
    elif components.get(DUTY) not in (DRIVER, PLAYER):
        raise InputError(
            f'{where}: name the inputs that the duty cycle drives, as speed = ["motor.speed"]; {system.name} '
            f"has no {DRIVER} called {DUTY}"
        )
    wires, about = (*blueprint.wires, *driven), f"system of {path.name}"
    blueprint = replace(blueprint, about=about, components=components, wires=wires)
    values = {n: dict(held.values) for n, held in system.components.items() if n not in roles.controller}
    return Setup(blueprint, _roles(roles, system, where), values)


def blueprint_of(system: System, controllers: Collection[str] = ()) -> Blueprint:
    """Blueprint of a system, in which the instances that are `controllers` have no component."""
    components: dict[str, str] = {}
    foreign: dict[str, Path] = {}
    for name, held in system.components.items():
        model = read_description(held.fmu).model_name
        own = is_ours(held.fmu, catalogue.components().get(model))
        components[name] = "" if name in controllers else model if own else f"{name} of {system.name}"
        if components[name] and not own:
            foreign[components[name]] = held.fmu
    wires = tuple((each.source, each.target) for each in system.connections)
    plain = {each.target: each for each in connected(system.components, wires)}
    changed = (each for each in system.connections if plain[each.target] != each)
    scaled = {each.target: Conversion(each.factor, each.offset) for each in changed}
    proposed = system.default_experiment
    stop_time, step_size = proposed.stop_time or 3600.0, proposed.step_size or 1.0
    tables = {name: table_in(system.components[name].fmu) for name, k in components.items() if k == PLAYER}
    whole = Blueprint(
        system.name, "", components, wires, stop_time, step_size, foreign=foreign, scaled=scaled
    )
    return replace(whole, tables=tables)


def is_ours(fmu: Path, declared: Component | None) -> bool:
    """Whether an FMU was made from a component of this version: both have the same variables."""
    if declared is None:
        return False
    found = read_description(fmu).variables
    return not any(flag_of(scalar.name) in found for scalar in declared.scalars()) and all(
        scalar.name in found and found[scalar.name].value_reference == scalar.reference
        for scalar in declared.scalars()
    )


def _roles(roles: RolesTable, system: System, where: str) -> Roles:
    corrections = [f"{name}.correction" for name in roles.controller]
    score, bare = Expression(roles.score, f"{where}.score"), roles.uncompensated
    without = score.without(corrections) if bare is None else Expression(bare, f"{where}.uncompensated")
    for expression in (score, without):
        for name in expression.variables:
            if name not in corrections:
                _check_variable(system, name, expression.where)
    return Roles(score, without, without.variables)


def _driven(system: System, roles: RolesTable, where: str) -> list[tuple[str, str]]:
    """Both ends of each wire from the duty cycle."""
    found = []
    fed = {each.target for each in system.connections}
    for demand in DEMANDS:
        for name in getattr(roles, demand):
            _check_variable(system, name, f"{where}.{demand}")
            if name in fed:
                raise InputError(f"{where}.{demand}: {name} is fed in {system.name} already; leave it out")
            found.append((f"{DUTY}.{demand}", name))
    return found


def _check_variable(system: System, name: str, where: str) -> None:
    instance, _, variable = name.rpartition(".")
    if instance not in system.components:
        known = instead(instance or name, system.components)
        raise InputError(f"{where}: {name}: {system.name} has no such component; {known}")
    variable_of(read_description(system.components[instance].fmu), variable, f"{where}: {name}")


def with_replaced(scenario: Scenario, replacements: Replacements) -> Scenario:
    """Put FMUs in place of parts of a scenario's system.

    Raises InputError where there is no such part, a controller's place is meant, or an FMU does not fit.
    """
    setup, fmus, shipped = scenario.setup, replacements.fmus, catalogue.components()
    if not fmus:
        return scenario
    kinds, foreign, roles = dict(setup.blueprint.components), dict(setup.blueprint.foreign), setup.roles
    scored = {*roles.score.variables, *roles.uncompensated.variables, *roles.plant}
    ends = [*(end for wire in setup.blueprint.wires for end in wire), *sorted(scored)]
    for instance, path in fmus.items():
        known = shipped.get(kinds.get(instance, ""))
        if known is None:
            ours = [name for name, kind in kinds.items() if kind in shipped]
            raise InputError(
                f"{argument('replaced', instance)}: no part of {setup.name}; {instead(instance, ours)}"
            )
        asked = {
            each.name: ("output" if isinstance(each.variable, Output) else "input", Unit(each.variable.unit))
            for each in known.scalars()
        }
        kinds[instance] = f"{instance} of {path.name}"
        foreign[kinds[instance]] = replacements.fmu(instance, known.name, asked, ends, scored)
    name = f"{setup.name} with {', '.join(path.name for path in fmus.values())}"
    values = {each: given for each, given in setup.values.items() if each not in fmus}
    blueprint = replace(setup.blueprint, name=name, components=kinds, foreign=foreign)
    return replace(scenario, setup=replace(setup, blueprint=blueprint, values=values))
