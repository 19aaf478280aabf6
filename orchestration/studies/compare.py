"""Controllers x duty cycles x mismatches: every combination run in closed loop, and one row for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from warmlink.orchestration.console import Answer, progress_bar
from warmlink.orchestration.scenarios.mismatch import NOMINAL
from warmlink.orchestration.scenarios.overrides import StartValueSet, given_values
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.studies.at_work import USUAL, Means, at_work
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.plan import Plan, plan_on
from warmlink.orchestration.studies.workers import Workers

if TYPE_CHECKING:
    import pandas

COLUMNS = (
    *("controller", "duty_cycle", "mismatch", "max_abs_um", "p95_abs_um"),
    *("time_to_tolerance_s", "removed_percent", "equal_within_um"),
)
"""Columns of `compare.csv`."""

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Row:
    """One run, compared with no compensation in the same duty cycle and mismatch.

    Attributes
    ----------
    outcome : its figures
    uncompensated_um : largest error without a controller
    removed_percent : share of the largest error that was removed; None where there was none, or no run
    equal_within_um : error budget: scores that differ by less are equal; None where it is not known
    tolerance_um : largest error that production allows
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

    def to_frame(self) -> pandas.DataFrame:
        """A row for each run with its figures."""
        import pandas

        return pandas.DataFrame(self.records())

    def summary(self) -> str:
        """Largest error in um of each controller, a line for each duty cycle and mismatch."""
        table = self.to_frame().pivot_table(
            "max_abs_um", ["duty_cycle", "mismatch"], "controller", sort=False, dropna=False
        )
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
                "equal_to_best": self.equal_to_best(row),
                "defeated": row.controller != NO_CONTROLLER and row.defeated,
            }
            for key, row in self.rows.items()
        ]

    def equal_to_best(self, row: Row) -> bool:
        """Whether no other controller does better in the same run by more than the error budget."""
        scores = [self.row(c, row.duty_cycle, row.mismatch).outcome.max_abs_um for c in self.controllers]
        known = [score for score in scores if score == score]
        return bool(known) and row.outcome.max_abs_um - min(known) <= (row.equal_within_um or 0.0)


def compare(
    controllers: Sequence[str] | None = None,
    duty_cycles: Sequence[str] | None = None,
    mismatches: Sequence[str] | None = None,
    *,
    system: str = CELL.name,
    scenario: str | Path | None = None,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    means: Means = USUAL,
    out: str | Path | None = None,
) -> Comparison:
    """Compare controllers with each other and with no compensation, over duty cycles and mismatches.

    Parameters
    ----------
    controllers : names, or laws of one's own as `my_law.py:MyLaw`; all that are designed for the system
    duty_cycles, mismatches : names or files; all that are usual for the system
    system : WarmupCell or SixAxisArm
    scenario : file (TOML) of a cell of one's own, whose parameters and sensors hold in every duty cycle
    parameters : start values, or the path of a parameter set (SSV), for the controllers that have them
    means : kind of FMU and number of processes
    out : folder in which finished runs are kept, so that the same call goes on where it was interrupted

    Raises
    ------
    InputError
        If there is none of a name, or a value is refused.
    """
    given = given_values(parameters)
    sets = [StartValueSet("parameters", given)] if given else []
    plan = plan_on(system, controllers, duty_cycles, mismatches, sets, scenario)
    with compared(plan, means, out) as comparison:
        return comparison


@contextmanager
def compared(plan: Plan, means: Means, out: str | Path | None) -> Iterator[Comparison]:
    """Run a plan; the folder in which finished runs are kept is locked until the block ends."""
    cases = plan.cases
    with at_work(plan.scenarios, means, out) as work:
        with progress_bar(f"{len(cases)} runs") as progress:
            comparison = run_comparison(cases, work.workers, progress)
        yield comparison


def run_comparison(cases: Sequence[Case], workers: Workers, progress: Progress) -> Comparison:
    """Run a plan; rows and figures are the same whatever the number of workers."""
    outcomes: dict[tuple[str, ...], Outcome] = {}
    done, total = 0.0, sum(case.hours for case in cases)
    for place, outcome in workers.run(cases):
        outcomes[cases[place].label] = outcome
        done += cases[place].hours
        progress(done / total)
    controllers, duties, mismatches = (
        tuple(dict.fromkeys(each)) for each in zip(*(case.label for case in cases), strict=True)
    )
    rows = {}
    for case in cases:
        name, duty, mismatch = case.label
        outcome, without = outcomes[case.label], outcomes[NO_CONTROLLER, duty, mismatch]
        budget = without
        if budget.coupling_um is None:
            budget = outcomes.get((NO_CONTROLLER, duty, NOMINAL), without)
        equal = None if budget.coupling_um is None else budget.coupling_um + budget.discretisation_um
        removed = None
        if outcome.stopped is None and without.stopped is None and without.max_abs_um > 0:
            removed = 100 * (1 - outcome.max_abs_um / without.max_abs_um)
        rows[name, duty, mismatch] = Row(
            name, duty, mismatch, outcome, without.max_abs_um, removed, equal, 1e6 * case.tolerance
        )
    return Comparison(controllers, duties, mismatches, rows)


def write_csv(comparison: Comparison, path: Path) -> None:
    """Write `compare.csv`, one row for each run; unknown values are left empty."""
    comparison.to_frame()[[*COLUMNS]].round(6).to_csv(path, index=False, lineterminator="\n")
