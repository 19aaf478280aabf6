"""The runs of a comparison: its controllers, duty cycles and mismatches, and whom each `--set` reaches."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.blueprint import NAME as ARM
from warmlink.orchestration.catalogue import Controller, shipped
from warmlink.orchestration.closed_loop.load import driven, load_scenario, names_on
from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios.mismatch import NOMINAL, Mismatch
from warmlink.orchestration.scenarios.mismatch import load as load_mismatch
from warmlink.orchestration.scenarios.overrides import StartValueSet, settable
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.studies.case import Case, case_of
from warmlink.orchestration.system.shipped import COMPENSATOR

DEFAULT_MISMATCHES = (
    *(NOMINAL, "thermal_high", "thermal_low", "insulated", "ventilated"),
    *("draw_1", "draw_2", "noisy_sensors", "camera_absent"),
)
SYSTEMS = {CELL.name: DEFAULT_MISMATCHES, ARM: (NOMINAL,)}
"""Systems that can be compared, each with its default mismatches."""


class Plan(NamedTuple):
    """What is compared: every duty cycle with every controller, under every mismatch."""

    scenarios: tuple[Scenario, ...]
    mismatches: tuple[Mismatch, ...]

    @property
    def laws(self) -> dict[str, Component]:
        """Component of each controller by its name."""
        return {each.controller.name: each.controller.component for each in self.scenarios}

    @property
    def cases(self) -> list[Case]:
        """The runs in the order of the rows, every start value checked.

        The error budget of the elongation depends on the plant alone, so `none` finds it for all. InputError
        if a scenario or mismatch names what does not exist, or a component refuses a value.
        """
        alone = NOMINAL not in {mismatch.name for mismatch in self.mismatches}
        return [
            case_of(
                mismatch.applied(scenario),
                (scenario.controller.name, scenario.name, mismatch.name),
                with_budget=scenario.controller.name == NO_CONTROLLER
                and (alone or mismatch.name == NOMINAL or mismatch.touches_plant),
            )
            for scenario in self.scenarios
            for mismatch in self.mismatches
        ]


def plan(
    controllers: Sequence[Controller],
    duties: Sequence[Scenario],
    mismatches: Sequence[Mismatch],
    sets: Sequence[StartValueSet] = (),
) -> Plan:
    """What to compare: each with each, `none` before all other controllers.

    Start values of `sets` are for the controllers that have them; a mismatch comes on top. InputError if two
    have one name, which a table could not tell apart, no controller has what is set, or one has no design for
    the system.
    """
    laws = [shipped(NO_CONTROLLER), *(law for law in controllers if law.name != NO_CONTROLLER)]
    for what, held in (("controllers", laws), ("duty cycles", duties), ("mismatches", mismatches)):
        several = Counter(each.name for each in held)
        if twice := sorted(name for name, count in several.items() if count > 1):
            raise InputError(f"{twice[0]}: two {what} of that name; rename one")
    given = assigned(sets, {law.name: law.component for law in laws})
    scenarios = [
        replace(duty, controller=law, parameters={**duty.parameters, **given[law.name]})
        for law in laws
        for duty in duties
    ]
    for each in scenarios:
        if each.design is None:
            raise InputError(f"{each.controller.name}: has no design for {each.setup.name}; leave it out")
    return Plan(tuple(scenarios), tuple(mismatches))


def plan_on(
    system: str = CELL.name,
    controllers: Sequence[str] | None = None,
    duty_cycles: Sequence[str] | None = None,
    mismatches: Sequence[str] | None = None,
    sets: Sequence[StartValueSet] = (),
    scenario: str | Path | None = None,
) -> Plan:
    """What to compare, by names and files; what is None is all that is usual for the system.

    The system is that of a scenario, with its parameters and sensors, where one is given. InputError if there
    is none of a name, or as `plan`.
    """
    cell = None if scenario is None else load_scenario(str(scenario))
    if cell is not None:
        system = ARM if cell.setup.name == ARM else CELL.name
    if system not in SYSTEMS:
        raise InputError(f"--system {system}: no such system to compare on; {instead(system, SYSTEMS)}")
    if controllers is None:
        controllers = designed_for(system)
    duty_cycles = names_on(system) if duty_cycles is None else duty_cycles
    mismatches = SYSTEMS[system] if mismatches is None else mismatches
    for option, names, example in (
        ("--duty-cycles", duty_cycles, "windshield_wiper,stop_and_go"),
        ("--mismatch", mismatches, "nominal,thermal_high"),
    ):
        if not names:
            raise InputError(f"{option}: names none; give some, as {option} {example}")
    duties = [load_scenario(name) for name in duty_cycles]
    return plan(
        [controller_named(name) for name in dict.fromkeys(controllers)],
        duties if cell is None else [driven(cell, duty) for duty in duties],
        [load_mismatch(name) for name in mismatches],
        sets,
    )


def designed_for(system: str) -> list[str]:
    """Controllers to compare where none are named: all, or those that have a design for the system."""
    if system != ARM:
        return list(catalogue.controllers())
    from warmlink.orchestration.arm.program import DESIGNED

    return list(DESIGNED)


def takers(given: StartValueSet, controllers: Mapping[str, Component]) -> list[str]:
    """Controllers that have every variable that a set gives the compensator; InputError if there is none."""
    names = _of_compensator(given)
    found = [name for name, law in controllers.items() if names <= settable(law).keys()]
    if found:
        return found
    # The law that has most of them is the one that was meant.
    known = max((settable(law).keys() for law in controllers.values()), key=lambda held: len(names & held))
    missing = min(names - known)
    every = sorted({each for law in controllers.values() for each in settable(law)})
    remedy = instead(missing, every, "or compare the controller that it is for")
    raise InputError(f"{given.origin}: no controller compared has {COMPENSATOR}.{missing}; {remedy}")


def assigned(
    sets: Sequence[StartValueSet], controllers: Mapping[str, Component]
) -> dict[str, dict[str, str | float]]:
    """Start values for each controller; later sets outdo earlier ones. Raises as `takers`."""
    taking = [(given.values, takers(given, controllers)) for given in sets]
    return {
        name: {
            key: value
            for values, having in taking
            for key, value in values.items()
            if name in having or key.rpartition(".")[0] != COMPENSATOR
        }
        for name in controllers
    }


def reached_controllers(given: StartValueSet, controllers: Mapping[str, Component]) -> str | None:
    """Sentence that names the controllers that a set reaches; None if it sets none of their parameters."""
    return f"{given.origin}: for {', '.join(takers(given, controllers))}" if _of_compensator(given) else None


def _of_compensator(given: StartValueSet) -> set[str]:
    split = (name.rpartition(".") for name in given.values)
    return {variable for instance, _, variable in split if instance == COMPENSATOR}
