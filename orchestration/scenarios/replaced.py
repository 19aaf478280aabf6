"""A scenario whose system has other people's FMUs in place of some of its parts."""

from __future__ import annotations

from dataclasses import replace

from warmlink.fmus.component import Output
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.replacement import Asked, Replacements
from warmlink.orchestration.system.units import Unit


def with_replaced(scenario: Scenario, replacements: Replacements) -> Scenario:
    """Put FMUs in place of parts of a scenario's system.

    Raises
    ------
    InputError
        There is no such part, a controller's place is meant, or an FMU does not fit.
    """
    setup = scenario.setup
    kinds, foreign = dict(setup.blueprint.components), dict(setup.foreign)
    if not replacements.fmus:
        return scenario
    for instance in replacements.fmus:
        known = catalogue.components().get(kinds.get(instance, ""))
        if known is None:
            ours = [name for name, kind in kinds.items() if kind in catalogue.components()]
            raise InputError(f"--replace {instance}: no part of {setup.name}; {instead(instance, ours)}")
        asked = _asked(scenario, instance, known.name)
        kind = f"{instance} of {replacements.fmus[instance].name}"
        foreign[kind] = replacements.fmu(instance, asked, known.name)
        kinds[instance] = kind
    name = f"{setup.name} with {', '.join(replacements.fmus[each].name for each in replacements.fmus)}"
    values = {each: given for each, given in setup.values.items() if each not in replacements.fmus}
    blueprint = replace(setup.blueprint, name=name, components=kinds)
    return replace(scenario, setup=replace(setup, blueprint=blueprint, foreign=foreign, values=values))


def _asked(scenario: Scenario, instance: str, kind: str) -> dict[str, Asked]:
    """What wires and score ask of an instance."""
    setup = scenario.setup
    roles = setup.roles
    scored = {*roles.score.variables, *roles.uncompensated.variables, *roles.plant}
    ends = dict.fromkeys([end for wire in setup.blueprint.wires for end in wire] + sorted(scored))
    declared = {scalar.name: scalar.variable for scalar in catalogue.components()[kind].scalars()}
    return {
        name: Asked(
            "output" if isinstance(declared[name], Output) else "input",
            Unit(declared[name].unit),
            end in scored,
        )
        for end in ends
        if end.rpartition(".")[0] == instance and (name := end.rpartition(".")[2]) in declared
    }
