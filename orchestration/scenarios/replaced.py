"""Other people's FMUs in place of parts of a scenario's machine."""

from __future__ import annotations

from dataclasses import replace

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Output
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.replacement import Replacements
from warmlink.orchestration.system.units import Unit


def with_replaced(scenario: Scenario, replacements: Replacements) -> Scenario:
    """Put FMUs in place of parts of a scenario's system.

    Raises InputError if there is no such part, a controller's place is meant, or an FMU does not fit.
    """
    machine, fmus, shipped = scenario.machine, replacements.fmus, catalogue.components()
    if not fmus:
        return scenario
    kinds, foreign, roles = dict(machine.parts), dict(machine.foreign), machine.roles
    scored = {*roles.score.variables, *roles.uncompensated.variables, *roles.plant}
    ends = [*(end for wire in machine.wires for end in wire), *sorted(scored)]
    for instance, path in fmus.items():
        known = shipped.get(kinds.get(instance, ""))
        if known is None:
            ours = [name for name, kind in kinds.items() if kind in shipped]
            raise InputError(
                f"{argument('replaced', instance)}: no part of {machine.name}; {instead(instance, ours)}"
            )
        asked = {
            each.name: ("output" if isinstance(each.variable, Output) else "input", Unit(each.variable.unit))
            for each in known.scalars()
        }
        kinds[instance] = f"{instance} of {path.name}"
        foreign[kinds[instance]] = replacements.fmu(instance, known.name, asked, ends, scored)
    name = f"{machine.name} with {', '.join(path.name for path in fmus.values())}"
    values = {each: given for each, given in machine.nominal.items() if each not in fmus}
    changed = replace(machine, name=name, parts=kinds, foreign=foreign, nominal=values)
    return replace(scenario, machine=changed)
