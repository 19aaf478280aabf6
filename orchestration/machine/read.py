"""Anybody's machine: an SSP, and a table that says what its variables are for.

```toml
[roles]
speed = ["joint1.speed", "joint2.speed"]       # inputs that the duty cycle drives; torque and so on likewise
score = "link1.elongation + link2.elongation - compensator.correction"
controller = "compensator"                     # the instance, or a list of them, that a controller replaces
```

Of several systems in one SSP, `system = "chain.ssp#VarB"` takes that of `VarB.ssd`.
The table stands in a scenario beside `system = "chain.ssp"`, or both stand in a file of their own, which
scenarios and experiments name as `system = "chain.toml"`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from warmlink.fmus.component import Component
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.tabled import table_in
from warmlink.fmus.packaging.views import flag_of
from warmlink.orchestration import catalogue
from warmlink.orchestration.console import remark_once
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.machine import COMPENSATOR, DRIVER, DUTY, PLAYER, Machine
from warmlink.orchestration.machine.roles import Roles
from warmlink.orchestration.machine.shipped import machine_named, machines
from warmlink.orchestration.system.assemble import connected, owner_of, path_and_variant, read_system
from warmlink.orchestration.system.check import variable_of
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.units import Conversion
from warmlink.orchestration.text_files import read_toml
from warmlink.orchestration.written.entries import Names, Text
from warmlink.orchestration.written.expression import Expression
from warmlink.orchestration.written.tables import Table, read_table

SYSTEMS = (".ssp", ".ssd")
"""Endings of files that hold a system."""

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


@dataclass(frozen=True)
class NamedMachine:
    """A machine as a file names it: a shipped one, or the path of an SSP with the roles of its variables.

    `where` is the name of the file, which stands before an error message; `source` is the path of the file
    that `followed` read.
    """

    system: str
    roles: RolesTable | None
    where: str
    folder: Path = Path()
    source: Path | None = None

    @property
    def path(self) -> Path | None:
        """Path of the SSP; None if the machine is shipped."""
        path, _ = path_and_variant(self.system)
        return self.folder / path if path.lower().endswith(SYSTEMS) else None

    @property
    def variant(self) -> str | None:
        """Which system in the SSP, as `VarB` of `chain.ssp#VarB`; None for the one that is run by default."""
        return path_and_variant(self.system)[1]

    def followed(self) -> NamedMachine:
        """What a file names whose path this is: one with the entries `system` and `roles`, as a scenario's.

        Raises InputError if there is no such file, or roles are given twice.
        """
        if not self.system.endswith(".toml"):
            return self
        path = self.folder / self.system
        if self.roles is not None:
            raise InputError(f"{self.where}: roles: {path.name} has those of its system; leave the table out")
        tables = read_toml(path)
        system, roles = str(tables.get("system", DEFAULT)), tables.get("roles")
        if system.endswith(".toml"):
            raise InputError(f"{path.name}: system: {system}: give an SSP, or the name of a shipped machine")
        read = None if roles is None else read_table(RolesTable, roles, f"{path.name}: roles")
        return NamedMachine(system, read, path.name, path.parent, path)


def machine_in(named: NamedMachine) -> Machine:
    """The machine that a file names; raises InputError if there is none, or its roles do not fit it."""
    found = named.followed()
    if found.path is not None:
        if found.roles is None:
            where = f"{found.where}: roles is missing"
            raise InputError(f"{where}; write [roles] and below it score = {Scored.example!r}")
        system = read_system(found.path, variant=found.variant)
        for told in system.remarks:
            remark_once(told)
        return with_roles(system, found.roles, f"{found.where}: roles", f"system of {found.path.name}")
    known = [each for each in machines() if machine_named(each).controllers]
    if found.system not in known:
        told = instead(found.system, known, "or give the path of an SSP")
        raise InputError(f"{found.where}: system: {told}")
    if found.roles is not None:
        told = f"{found.system} is shipped with its roles; leave the table out"
        raise InputError(f"{found.where}: roles: {told}")
    return machine_named(found.system)


def with_roles(system: System, roles: RolesTable, where: str, about: str = "") -> Machine:
    """The machine that a system with roles is; raises InputError if a role names what is not there."""
    for name in roles.controller:
        if name not in system.components:
            known = instead(name, system.components)
            raise InputError(f"{where}.controller: {system.name} has no component {name}; {known}")
    machine = machine_of(system, roles.controller)
    parts = machine.parts
    driven = _driven(system, roles, where)
    if driven:
        parts = {DUTY: DRIVER, **parts}
    elif parts.get(DUTY) not in (DRIVER, PLAYER):
        raise InputError(
            f'{where}: name the inputs that the duty cycle drives, as speed = ["motor.speed"]; {system.name} '
            f"has no {DRIVER} called {DUTY}"
        )
    return replace(
        machine,
        about=about,
        parts=parts,
        wires=(*machine.wires, *driven),
        roles=_roles(roles, system, where),
    )


def machine_of(system: System, controllers: Collection[str] = ()) -> Machine:
    """The machine that a system is, in which the instances that are `controllers` have no component."""
    parts: dict[str, str] = {}
    foreign: dict[str, Path] = {}
    for name, held in system.components.items():
        model = read_description(held.fmu).model_name
        own = is_ours(held.fmu, catalogue.components().get(model))
        parts[name] = "" if name in controllers else model if own else f"{name} of {system.name}"
        if parts[name] and not own:
            foreign[parts[name]] = held.fmu
    wires = tuple((each.source, each.target) for each in system.connections)
    plain = {each.target: each for each in connected(system.components, wires)}
    changed = (each for each in system.connections if plain[each.target] != each)
    proposed = system.default_experiment
    return Machine(
        system.name,
        "",
        parts,
        wires,
        nominal={name: dict(held.values) for name, held in system.components.items() if parts[name]},
        stop_time=proposed.stop_time or 3600.0,
        step_size=proposed.step_size or 1.0,
        foreign=foreign,
        scaled={each.target: Conversion(each.factor, each.offset) for each in changed},
        tables={n: table_in(system.components[n].fmu) for n, kind in parts.items() if kind == PLAYER},
    )


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
    owner = owner_of(system.components, name)
    if not owner:
        known = instead(name.rpartition(".")[0] or name, system.components)
        raise InputError(f"{where}: {name}: {system.name} has no such component; {known}")
    info = read_description(system.components[owner].fmu)
    variable_of(info, name[len(owner) + 1 :], f"{where}: {name}")
