"""Controllers designed for a system: the plant's parameters from its files, the gains to a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from warmlink.controllers.design.plant import Network, Plant
from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import Values, by_scalar
from warmlink.fmus.component import Component
from warmlink.fmus.component import Parameter as Declared
from warmlink.fmus.component.join import join
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.overrides import scalar, start_values
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.ssp.parameter_values import Parameter, write_ssv
from warmlink.orchestration.system.units import parse_unit


def plant_of(system: System) -> Plant:
    """Parameters of a system's one motor and one link where they differ from nominal, in SI units.

    Raises
    ------
    InputError
        If the system has no motor or no link of ours, or several.
    """
    return Plant(motor=_differing(system, MOTOR), link=_differing(system, LINK))


def network_of(scenario: Scenario) -> Network:
    """Motors and links of a scenario's system, and what its controller sees of them.

    Raises
    ------
    InputError
        If the system has no motors and links of ours, others act among them, or the score is no weighted sum
        of what they grow by.
    """
    setup = scenario.setup
    declared = scenario.declared
    motors, links = setup.called("motor"), setup.called("link")
    if not motors or not links:
        raise InputError(f"{setup.name}: a design needs motors and links of warmlink's, and it has none")
    plant = [*motors, *links]
    wires = {target: source for source, target in setup.blueprint.wires}
    among = [(s, t) for t, s in wires.items() if {s.rpartition(".")[0], t.rpartition(".")[0]} <= {*plant}]
    joined = join(setup.name, {name: declared[name] for name in plant}, among)
    values = scenario.values()
    given = {
        f"{name}.{variable}": float(value)
        for name in plant
        for variable, value in values.get(name, {}).items()
        if f"{name}.{variable}" in joined.p.index
    }
    (controller, *_) = setup.controllers
    read = {name: _read_at(f"{controller}.{name}", wires, set(plant)) for name in SENSED}
    found = {name: variable for name, variable in read.items() if variable is not None}
    growth = setup.roles.score.without(setup.corrections).weights()
    return Network(joined, given, tuple(motors), tuple(links), found, growth)


def _read_at(name: str, wires: Mapping[str, str], plant: set[str]) -> str | None:
    """Variable of the plant that an input reads, through thermometers; None where it reads none."""
    while name in wires:
        name = wires[name]
        if name.rpartition(".")[0] in plant:
            return name
        # A thermometer's reading is of the temperature of the same channel.
        name = name.replace(".reading[", ".temperature[")
    return None


def with_values(plant: Plant, given: Mapping[str, str | float]) -> Plant:
    """A plant with other parameters, `"2 W/K"` under `motor.joint_conductance`.

    Raises
    ------
    InputError
        If motor or link has no such parameter, a unit does not fit, or a value is out of range.
    """
    components = {"motor": MOTOR, "link": LINK}
    for name in given:
        if not isinstance(scalar(name, components, "--set").variable, Declared):
            raise InputError(f"--set {name}: is an input, which a design does not depend on; leave it out")
    named = {f"motor.{name}": value for name, value in plant.motor.items()}
    named |= {f"link.{name}": value for name, value in plant.link.items()}
    values = start_values({**named, **given}, components, "--set")
    return Plant(*(_off_nominal(each, values.get(name, {})) for name, each in components.items()))


def _off_nominal(component: Component, values: Mapping[str, Value]) -> dict[str, float]:
    starts = {each.name: each.start for each in component.scalars()}
    return {name: float(value) for name, value in values.items() if float(value) != starts[name]}


def write_design(law: str, values: Values, path: Path) -> None:
    """Write designed values as the parameter set (SSV) of the law's FMU."""
    declared = {s.name: s.variable for s in catalogue.controller(law).scalars()}
    held = {}
    for name, value in by_scalar(values).items():
        unit = declared[name].unit
        held[name] = Parameter(name, "Real", value, None if unit == "1" else parse_unit(unit))
    try:
        write_ssv(held, path, f"{law}, designed")
    except OSError as fault:
        raise InputError(f"{path}: cannot be written ({fault.strerror}); choose another --out") from None


def _differing(system: System, component: Component) -> dict[str, float]:
    found = [
        held for held in system.components.values() if read_description(held.fmu).model_name == component.name
    ]
    if len(found) != 1:
        have = ", ".join(held.name for held in found) or "none"
        raise InputError(
            f"{system.name}: a design needs one {component.name}, and the system has {have}; give a system "
            "with one motor and one link"
        )
    variables = read_description(found[0].fmu).variables
    differing = {}
    for each in component.scalars():
        if not isinstance(each.variable, Declared):
            continue
        start = variables[each.name].start if each.name in variables else None
        value = found[0].values.get(each.name, start)
        if value is not None and float(value) != each.start:
            differing[each.name] = float(value)
    return differing
