"""Controllers x duty cycles x mismatches: every combination run in closed loop, and one row for each."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.library import NAME as ARM
from warmlink.orchestration.catalogue import Controller, shipped
from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios.load import load_scenario, names_on
from warmlink.orchestration.scenarios.mismatch import NOMINAL, Mismatch
from warmlink.orchestration.scenarios.mismatch import load as load_mismatch
from warmlink.orchestration.scenarios.overrides import StartValueSet
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.studies.case import Case, Outcome, case_of
from warmlink.orchestration.studies.cores.workers import Workers
from warmlink.orchestration.studies.given import assigned

COLUMNS = (
    "controller",
    "duty_cycle",
    "mismatch",
    "max_abs_um",
    "p95_abs_um",
    "time_to_tolerance_s",
    "removed_percent",
    "equal_within_um",
)
"""Columns of `compare.csv`."""

DEFAULT_MISMATCHES = (
    NOMINAL,
    "thermal_high",
    "thermal_low",
    "insulated",
    "ventilated",
    "draw_1",
    "draw_2",
    "noisy_sensors",
    "camera_absent",
)
SYSTEMS = {CELL.name: DEFAULT_MISMATCHES, ARM: (NOMINAL,)}
"""Systems whose scenarios are compared unasked, each with the mismatches taken then."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Row:
    """One run, held against none in the same duty cycle and mismatch.

    Attributes
    ----------
    outcome : its figures
    uncompensated_um : largest error without a controller
    removed_percent : share of the largest error that was removed; None where there was none, or no run
    equal_within_um : error budget: scores that differ by less are equal; None where it is not known
    tolerance_um : largest error that production bears
    """

    controller: str
    duty_cycle: str
    mismatch: str
    outcome: Outcome
    uncompensated_um: float
    removed_percent: float | None
    equal_within_um: float | None
    tolerance_um: float

    @property
    def minutes_won(self) -> float:
        """Productive minutes won against warming up first; NaN in a run that stopped."""
        return self.outcome.within_tolerance_min - self.outcome.warm_up_first_min

    @property
    def beyond_tolerance(self) -> bool:
        """Whether the largest error is beyond tolerance, or not known."""
        return not self.outcome.max_abs_um <= self.tolerance_um

    @property
    def worse_than_none(self) -> bool:
        """Whether the law does harm, by more than the error budget."""
        return self.outcome.max_abs_um - self.uncompensated_um > (self.equal_within_um or 0.0)

    @property
    def defeated(self) -> bool:
        """Whether the duty cycle defeats the law: it does harm, or its error is beyond tolerance."""
        return self.beyond_tolerance or self.worse_than_none


@dataclass(frozen=True)
class Comparison:
    """All rows, by controller, duty cycle and mismatch in the order asked for."""

    controllers: tuple[str, ...]
    duty_cycles: tuple[str, ...]
    mismatches: tuple[str, ...]
    rows: Mapping[tuple[str, str, str], Row]

    def row(self, controller: str, duty_cycle: str, mismatch: str = NOMINAL) -> Row:
        """One row."""
        return self.rows[controller, duty_cycle, mismatch]

    def worst(self, controller: str, duty_cycles: Sequence[str], mismatches: Sequence[str]) -> Row:
        """The worst of some rows of a controller; a run that stopped is worst."""
        rows = [self.row(controller, duty, mismatch) for duty in duty_cycles for mismatch in mismatches]
        return max(rows, key=lambda row: (row.outcome.stopped is not None, row.outcome.max_abs_um))

    def records(self) -> list[dict[str, Any]]:
        """Every row with its figures by name, as JSON has them."""
        return [
            {
                "controller": row.controller,
                "duty_cycle": row.duty_cycle,
                "mismatch": row.mismatch,
                **row.outcome.to_dict(),
                "removed_percent": row.removed_percent,
                "equal_within_um": row.equal_within_um,
                "productive_minutes_won": row.minutes_won if row.minutes_won == row.minutes_won else None,
                "equal_to_best": self.equal_to_best(row),
                "defeated": row.controller != NO_CONTROLLER and row.defeated,
            }
            for row in self.rows.values()
        ]

    def equal_to_best(self, row: Row) -> bool:
        """Whether no other controller does better in the same run by more than the error budget."""
        scores = [self.row(c, row.duty_cycle, row.mismatch).outcome.max_abs_um for c in self.controllers]
        known = [score for score in scores if score == score]
        return bool(known) and row.outcome.max_abs_um - min(known) <= (row.equal_within_um or 0.0)


@dataclass(frozen=True)
class Plan:
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

        The error budget of the elongation depends on the plant alone, so `none` finds it for all.

        Raises
        ------
        InputError
            If a scenario or mismatch names what does not exist, or a component refuses a value.
        """
        cases = []
        alone = NOMINAL not in {mismatch.name for mismatch in self.mismatches}
        for scenario in self.scenarios:
            name = scenario.controller.name
            for mismatch in self.mismatches:
                needed = alone or mismatch.name == NOMINAL or mismatch.touches_plant
                label = (name, scenario.name, mismatch.name)
                budget = name == NO_CONTROLLER and needed
                cases.append(case_of(mismatch.applied(scenario), label, with_budget=budget))
        return cases


def plan(
    controllers: Sequence[Controller],
    duties: Sequence[Scenario],
    mismatches: Sequence[Mismatch],
    sets: Sequence[StartValueSet] = (),
) -> Plan:
    """What to compare, `none` before all other controllers.

    Parameters
    ----------
    controllers, duties, mismatches : each with each
    sets : other start values, for the controllers that have them; a mismatch comes on top

    Raises
    ------
    InputError
        If two have one name, which a table could not tell apart, no controller has what is set, or one has no
        design for the system.
    """
    laws = [shipped(NO_CONTROLLER), *(law for law in controllers if law.name != NO_CONTROLLER)]
    _distinct(laws, "controllers")
    _distinct(duties, "duty cycles")
    _distinct(mismatches, "mismatches")
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
) -> Plan:
    """What to compare, by names and files; what is None is all that is usual for the system.

    Raises
    ------
    InputError
        If there is none of a name, or as `plan`.
    """
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
    return plan(
        [controller_named(name) for name in dict.fromkeys(controllers)],
        [load_scenario(name) for name in duty_cycles],
        [load_mismatch(name) for name in mismatches],
        sets,
    )


def designed_for(system: str) -> list[str]:
    """Controllers to compare where none are named: all, or those that have a design for the system."""
    if system != ARM:
        return list(catalogue.controllers())
    from warmlink.orchestration.arm.setup import DESIGNED

    return list(DESIGNED)


def run_comparison(cases: Sequence[Case], workers: Workers, progress: Progress) -> Comparison:
    """Run a plan; rows and figures are the same whatever the number of workers."""
    outcomes: dict[tuple[str, ...], Outcome] = {}
    done, total = 0.0, sum(case.hours for case in cases)
    for place, outcome in workers.run(cases):
        outcomes[cases[place].label] = outcome
        done += cases[place].hours
        progress(done / total)
    controllers, duties, mismatches = (
        tuple(dict.fromkeys(case.label[i] for case in cases)) for i in range(3)
    )
    rows = {}
    for case in cases:
        name, duty, mismatch = case.label
        without = outcomes[NO_CONTROLLER, duty, mismatch]
        budget = without
        if budget.coupling_um is None and (NO_CONTROLLER, duty, NOMINAL) in outcomes:
            budget = outcomes[NO_CONTROLLER, duty, NOMINAL]
        rows[name, duty, mismatch] = _row(case, outcomes[case.label], without, budget)
    return Comparison(controllers, duties, mismatches, rows)


def write_csv(comparison: Comparison, path: Path) -> None:
    """Write `compare.csv`, a row a run; what is not known is left empty."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in comparison.rows.values():
            figures = row.outcome.to_dict()
            writer.writerow(
                [
                    row.controller,
                    row.duty_cycle,
                    row.mismatch,
                    *(_cell(figures[name]) for name in COLUMNS[3:6]),
                    _cell(row.removed_percent),
                    _cell(row.equal_within_um),
                ]
            )


def _distinct(held: Sequence[Controller | Scenario | Mismatch], what: str) -> None:
    names = [each.name for each in held]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{twice[0]}: two {what} of that name; rename one")


def _row(case: Case, outcome: Outcome, without: Outcome, budget: Outcome) -> Row:
    removed = None
    if outcome.stopped is None and without.stopped is None and without.max_abs_um > 0:
        removed = 100 * (1 - outcome.max_abs_um / without.max_abs_um)
    equal = None if budget.coupling_um is None else budget.coupling_um + budget.discretisation_um
    name, duty, mismatch = case.label
    return Row(name, duty, mismatch, outcome, without.max_abs_um, removed, equal, 1e6 * case.tolerance)


def _cell(value: float | None) -> str:
    return "" if value is None else repr(round(value, 6))
