"""Controllers x duty cycles x mismatches: every combination, run in closed loop, and one row for each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, several
from warmlink.fmus.safe_text import write_frame
from warmlink.orchestration import catalogue
from warmlink.orchestration.catalogue import Controller, controller_named, refuse_one_name, shipped
from warmlink.orchestration.closed_loop.load import driven, load_scenario, names_on
from warmlink.orchestration.closed_loop.metrics import CONDUCT
from warmlink.orchestration.console import Answer
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL, machine_named, machines
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.mismatch import NOMINAL, Mismatch
from warmlink.orchestration.scenarios.mismatch import load as load_mismatch
from warmlink.orchestration.scenarios.overrides import StartValueSet, assigned
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario, believing
from warmlink.orchestration.studies.case import Case, Outcome, case_of
from warmlink.orchestration.studies.session import RunOptions, open_study
from warmlink.orchestration.studies.workers import Workers

if TYPE_CHECKING:
    import pandas

DEFAULT_MISMATCHES = (
    *(NOMINAL, "thermal_high", "thermal_low", "insulated", "ventilated"),
    *("draw_1", "draw_2", "noisy_sensors", "camera_absent"),
)
"""Mismatches under which controllers are compared on a machine that names none."""
COLUMNS = (
    *("controller", "duty_cycle", "mismatch", "max_abs_um", "p95_abs_um"),
    *("time_to_tolerance_s", "removed_percent", "equal_within_um", *CONDUCT),
)
"""Columns of `compare.csv`."""


class Plan(NamedTuple):
    """What is compared: every duty cycle with every controller, under every mismatch."""

    scenarios: tuple[Scenario, ...]
    mismatches: tuple[Mismatch, ...]

    @property
    def runs(self) -> list[Scenario]:
        """Every scenario under every mismatch."""
        return [scenario.mismatched(mismatch) for scenario in self.scenarios for mismatch in self.mismatches]

    @property
    def laws(self) -> dict[str, Component]:
        """Component of each controller by its name."""
        return {each.controller.name: each.controller.component for each in self.scenarios}

    @property
    def cases(self) -> list[Case]:
        """The runs in the order of the rows; InputError if a component refuses a start value.

        The error budget of the elongation depends on the plant alone, so `none` finds it for all.
        """
        alone = NOMINAL not in {mismatch.name for mismatch in self.mismatches}
        return [
            case_of(
                scenario.mismatched(mismatch),
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
    """Each with each, `none` before all other controllers.

    Start values of `sets` are for the controllers that have them, later ones outdo earlier ones, and a
    mismatch comes on top. InputError if two have one name, no controller has what is set, or one has no
    design for the system.
    """
    laws = [shipped(NO_CONTROLLER), *(law for law in controllers if law.name != NO_CONTROLLER)]
    several_of = ("controllers", laws), ("duty cycles", duties), ("mismatches", mismatches)
    for what, held in (*several_of, ("components", [law.component for law in laws])):
        refuse_one_name(what, (each.name for each in held))
    given = assigned(sets, {law.name: law.component for law in laws})
    scenarios = [believing(replace(duty, controller=law), given[law.name]) for law in laws for duty in duties]
    for each in scenarios:
        if each.design is None:
            raise InputError(f"{each.controller.name}: has no design for {each.machine.name}; leave it out")
    return Plan(tuple(scenarios), tuple(mismatches))


def plan_on(
    system: str = WARMUP_CELL.name,
    controllers: Sequence[str] | str | None = None,
    duty_cycles: Sequence[str | Path] | str | Path | None = None,
    mismatches: Sequence[str | Path] | str | Path | None = None,
    sets: Sequence[StartValueSet] = (),
    scenario: str | Path | None = None,
    more: Sequence[str] = (),
) -> Plan:
    """What to compare, by names and files; None selects the machine's defaults.

    The machine is that of a scenario, with its parameters and sensors, where one is given, and its own duty
    cycle is the usual one; `more` are controllers beside the others. InputError if there is none of a name,
    or as `plan`.
    """
    cell = None if scenario is None else load_scenario(str(scenario))
    machine = _compared_on(system) if cell is None else cell.machine
    if system not in (WARMUP_CELL.name, machine.name):
        told = f"{argument('scenario', Path(str(scenario)))} has a system of its own, {machine.name}"
        raise InputError(f"{argument('system', system)}: {told}; leave one of the two out")
    if controllers is None:
        controllers = machine.laws or list(catalogue.controllers())
    if duty_cycles is None:
        duty_cycles = names_on(system) if scenario is None else [str(scenario)]
    if mismatches is None:
        mismatches = machine.mismatches or DEFAULT_MISMATCHES
    for name, names in (("duty_cycles", duty_cycles), ("mismatches", mismatches)):
        if not names:
            raise InputError(f"{argument(name)}: names none; give some, or leave it out for the usual ones")
    duties = [load_scenario(name) for name in several(duty_cycles)]
    return plan(
        [controller_named(name) for name in dict.fromkeys([*several(controllers), *more])],
        duties if cell is None else [driven(cell, duty) for duty in duties],
        [load_mismatch(name) for name in several(mismatches)],
        sets,
    )


def _compared_on(system: str) -> Machine:
    known = [each for each in machines() if machine_named(each).controllers]
    if system not in known:
        told = instead(system, known)
        raise InputError(f"{argument('system', system)}: no such system to compare on; {told}")
    return machine_named(system)


@dataclass(frozen=True)
class Row:
    """One run, compared with no compensation in the same duty cycle and mismatch.

    `uncompensated_um` is the largest error without a controller, and `removed_percent` the share of it that
    was removed, None where there was none, or no run. Scores that differ by less than `equal_within_um`, the
    error budget, are equal; it is None where it is not known. `tolerance_um` is what production allows.
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
        """Productive minutes won compared with warming up first; NaN in a run that stopped."""
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

    def equals(self, best_um: float) -> bool:
        """Whether the largest error is no more than the error budget above the best one."""
        return self.outcome.max_abs_um - best_um <= (self.equal_within_um or 0.0)


@dataclass(frozen=True, repr=False)
class Comparison(Answer):
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

    def best_um(self, duty_cycle: str, mismatch: str) -> float:
        """Smallest largest error of a duty cycle and mismatch; NaN where there is none."""
        rows = (self.row(each, duty_cycle, mismatch) for each in self.controllers)
        return min((row.outcome.max_abs_um for row in rows if row.outcome.stopped is None), default=math.nan)

    def to_frame(self) -> pandas.DataFrame:
        """A row for each run with its figures."""
        import pandas

        return pandas.DataFrame(self.records())

    def summary(self) -> str:
        """Largest error in um of each controller, a line for each duty cycle and mismatch."""
        keys = ["duty_cycle", "mismatch"]
        table = self.to_frame().pivot_table("max_abs_um", keys, "controller", sort=False, dropna=False)
        return f"largest error in um\n{table.round(1).to_string()}"

    def records(self) -> list[dict[str, Any]]:
        """Every row with its figures by name, as JSON has them."""
        return [
            {
                **dict(zip(COLUMNS, key, strict=False)),
                **row.outcome.to_dict(),
                "removed_percent": row.removed_percent,
                "equal_within_um": row.equal_within_um,
                "productive_minutes_won": row.minutes_won if row.minutes_won == row.minutes_won else None,
                "equal_to_best": row.equals(self.best_um(row.duty_cycle, row.mismatch)),
                "defeated": row.controller != NO_CONTROLLER and row.defeated,
            }
            for key, row in self.rows.items()
        ]


@contextmanager
def compared(plan: Plan, options: RunOptions, out: str | Path | None) -> Iterator[Comparison]:
    """Run a plan; the folder in which finished runs are kept is locked until the block ends."""
    with open_study(plan.runs, options, out) as work:
        with progress_bar(f"{len(plan.cases)} runs") as progress:
            comparison = run_comparison(plan.cases, work.workers, progress)
        yield comparison


def run_comparison(cases: Sequence[Case], workers: Workers, progress: Callable[[float], None]) -> Comparison:
    """Run a plan; rows and figures are the same whatever the number of workers."""
    outcomes: dict[tuple[str, ...], Outcome] = {}
    done, total = 0.0, sum(case.work_hours for case in cases)
    for place, outcome in workers.run(cases):
        outcomes[cases[place].label] = outcome
        done += cases[place].work_hours
        progress(done / total)
    rows = {}
    for case in cases:
        name, duty, mismatch = case.label
        outcome, without = outcomes[case.label], outcomes[NO_CONTROLLER, duty, mismatch]
        nominal = outcomes.get((NO_CONTROLLER, duty, NOMINAL), without)
        budget = nominal if without.coupling_um is None else without
        equal = None if budget.coupling_um is None else budget.coupling_um + budget.discretisation_um
        removed = None
        if outcome.stopped is None and without.stopped is None and without.max_abs_um > 0:
            removed = 100 * (1 - outcome.max_abs_um / without.max_abs_um)
        rows[name, duty, mismatch] = Row(
            name, duty, mismatch, outcome, without.max_abs_um, removed, equal, 1e6 * case.tolerance
        )
    controllers, duties, mismatches = (tuple(dict.fromkeys(each)) for each in zip(*rows, strict=True))
    return Comparison(controllers, duties, mismatches, rows)


def write_csv(comparison: Comparison, path: Path) -> None:
    """Write `compare.csv`, one row for each run; unknown values are left empty."""
    write_frame(comparison.to_frame()[[*COLUMNS]].round(6), path)
