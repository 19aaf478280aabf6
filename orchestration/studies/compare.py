"""Controllers x duty cycles x mismatches: every combination run in closed loop, and one row for each."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.studies.case import Case, Outcome, case_of
from warmlink.orchestration.studies.cores.workers import Workers
from warmlink.orchestration.studies.mismatch import NOMINAL, Mismatch

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

    def worst(self, controller: str, duty_cycle: str) -> Row:
        """The row of the worst mismatch, the nominal one left out; a run that stopped is worst."""
        others = [m for m in self.mismatches if m != NOMINAL] or [NOMINAL]
        rows = [self.row(controller, duty_cycle, m) for m in others]
        return max(rows, key=lambda row: (row.outcome.stopped is not None, row.outcome.max_abs_um))

    def equal_to_best(self, row: Row) -> bool:
        """Whether no other controller does better in the same run by more than the error budget."""
        scores = [self.row(c, row.duty_cycle, row.mismatch).outcome.max_abs_um for c in self.controllers]
        known = [score for score in scores if score == score]
        return bool(known) and row.outcome.max_abs_um - min(known) <= (row.equal_within_um or 0.0)


def plan(
    controllers: Mapping[str, Component],
    duties: Sequence[Scenario],
    mismatches: Sequence[Mismatch],
    given: Mapping[str, Mapping[str, str | float]] | None = None,
) -> list[Case]:
    """The runs of a comparison, in the order of its rows, every start value checked.

    The error budget of the elongation depends on the plant alone, so `none` finds it for all.

    Parameters
    ----------
    controllers : component of each law by its name
    duties, mismatches : each of the one with each of the other
    given : other start values by the law's name; a mismatch comes on top

    Raises
    ------
    InputError
        If a scenario or mismatch names what does not exist, or a component refuses a value.
    """
    cases = []
    alone = NOMINAL not in {mismatch.name for mismatch in mismatches}
    for name, law in controllers.items():
        for duty in duties:
            parameters = {**duty.parameters, **(given or {}).get(name, {})}
            plain = replace(duty, controller=name, parameters=parameters)
            if plain.design is None:
                raise InputError(f"{name}: has no design for {duty.setup.name}; leave it out")
            for mismatch in mismatches:
                scenario = mismatch.applied(plain, law)
                needed = alone or mismatch.name == NOMINAL or mismatch.touches_plant
                budget = name == NO_CONTROLLER and needed
                cases.append(case_of(scenario, law, (name, duty.name, mismatch.name), with_budget=budget))
    return cases


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


def chosen_controllers(names: Sequence[str]) -> dict[str, Component]:
    """Controllers by name, with none before all others.

    Raises
    ------
    InputError
        If there is none of a name.
    """
    return {name: catalogue.controller(name) for name in dict.fromkeys((NO_CONTROLLER, *names))}


def distinct(names: Sequence[str], what: str) -> None:
    """Refuse two things of one name, which one table could not tell apart."""
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
