"""The plant that a law is designed for: motors and links of a system, and how they differ from nominal."""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.controllers.design.plant import Plant, cell_plant
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.component import Parameter as Declared
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.machine.plant import plant_of
from warmlink.orchestration.scenarios.overrides import scalar, start_values
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System, Value


def cell_plant_in(system: System) -> Plant:
    """What differs from nominal in a system's one motor and one link, in SI units; InputError otherwise."""
    return cell_plant(*(_differing(each, _values_in(system, each)) for each in (MOTOR, LINK)))


def plant_in(scenario: Scenario) -> Plant:
    """Motors and links of a scenario's machine as a designer knows them; raises as `plant_of`."""
    return plant_of(scenario.machine, scenario.declared, scenario.as_believed.values())


def with_values(plant: Plant, given: Mapping[str, str | float]) -> Plant:
    """A plant with other parameters, `"2 W/K"` under `motor.joint_conductance`, if they fit."""
    components = {"motor": MOTOR, "link": LINK}
    for name in given:
        if not isinstance(scalar(name, components, argument("parameters")).variable, Declared):
            raise InputError(
                f"{argument('parameters')}: {name}: is an input, which a design does not depend on; "
                "leave it out"
            )
    values = start_values({**plant.given, **given}, components, argument("parameters"))
    return cell_plant(*(_differing(each, values.get(name, {})) for name, each in components.items()))


def _values_in(system: System, component: Component) -> Mapping[str, Value | None]:
    """Start values of a system's one FMU of a component; InputError where there is not exactly one."""
    described = [(held, read_description(held.fmu)) for held in system.components.values()]
    found = [(held, told) for held, told in described if told.model_name == component.name]
    if len(found) != 1:
        have = ", ".join(held.name for held, _ in found) or "none"
        raise InputError(
            f"{system.name}: a design needs one {component.name}, and the system has {have}; give a system "
            "with one motor and one link"
        )
    ((held, told),) = found
    return {**{name: each.start for name, each in told.variables.items()}, **held.values}


def _differing(component: Component, values: Mapping[str, Value | None]) -> dict[str, float]:
    """Parameters that are not as declared, in SI units."""
    starts = {each.name: each.start for each in component.scalars() if isinstance(each.variable, Declared)}
    given = {name: values.get(name) for name in starts}
    return {n: float(v) for n, v in given.items() if v is not None and float(v) != starts[n]}
