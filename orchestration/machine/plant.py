"""What a law is designed for: motors and links of a machine, and what its controller sees of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from warmlink.controllers.design.plant import Plant
from warmlink.controllers.interface import SENSED
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import join
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_path.component import COMPONENT as HEAT_PATH
from warmlink.fmus.names import listed
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.system.assemble import owner_of
from warmlink.orchestration.system.model import StartValues


def plant_of(machine: Machine, declared: Mapping[str, Component], values: StartValues) -> Plant:
    """Motors and links of a machine, with what its first controller reads and is to correct.

    Parameters
    ----------
    machine : the machine
    declared : declaration of each instance that is a component of warmlink
    values : start values in SI units by instance and variable

    Raises
    ------
    InputError
        It has no motor or link of ours, a connection scales what it carries, or the score is no weighted sum
        of what the links grow by.
    """
    motors, links = machine.called("motor"), machine.called("link")
    if not motors or not links:
        raise InputError(
            f"{machine.name}: a design needs motors and links of warmlink's, and it has none; take "
            f"{argument('law', 'linear_observer')}, whose model is found from runs"
        )
    paths = (name for name, kind in machine.parts.items() if kind == HEAT_PATH.name)
    plant = [*motors, *links, *paths]
    if machine.scaled:
        raise InputError(
            f"{machine.name}: {machine.never_joined}, which no model of a design knows; take "
            f"{argument('law', 'linear_observer')}, whose model is found from runs"
        )
    among = [wire for wire in machine.wires if {owner_of(machine.parts, end) for end in wire} <= {*plant}]
    joined = join(machine.name, {name: declared[name] for name in plant}, among)
    given = {
        f"{name}.{variable}": float(value)
        for name in plant
        for variable, value in values.get(name, {}).items()
        if f"{name}.{variable}" in joined.p.index
    }
    (controller, *_) = machine.controllers
    read = {name: _read_at(f"{controller}.{name}", machine, plant) for name in SENSED}
    found = {name: variable for name, variable in read.items() if variable is not None}
    growth = machine.roles.score.without(machine.corrections).weights()
    if others := [name for name in growth if name not in joined.y.index]:
        raise InputError(
            f"{machine.name}: {listed(others)} is scored, which is no output of its motors and links; score "
            "a weighted sum of elongations"
        )
    return Plant(joined, given, tuple(motors), tuple(links), found, growth)


def _read_at(name: str, machine: Machine, plant: Collection[str]) -> str | None:
    """Variable of the plant that an input reads, through thermometers; None if it reads none."""
    while name in machine.fed:
        name = machine.fed[name]
        if owner_of(machine.parts, name) in plant:
            return name
        # A thermometer's reading is of the temperature of the same channel.
        name = name.replace(".reading[", ".temperature[")
    return None
