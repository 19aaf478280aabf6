"""What a study asks of its runs: one figure of each, gathered into one number."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.text_files import shown

Metric = Callable[[Outcome, Case], float]


def _settled(outcome: Outcome, case: Case) -> float:
    return case.stop_time if outcome.time_to_tolerance_s is None else outcome.time_to_tolerance_s


METRICS: dict[str, Metric] = {
    "max_abs_um": lambda outcome, case: outcome.max_abs_um,
    "p95_abs_um": lambda outcome, case: outcome.p95_abs_um,
    "rms_um": lambda outcome, case: outcome.rms_um,
    "time_to_tolerance_s": _settled,
    "outside_tolerance_min": lambda outcome, case: case.stop_time / 60 - outcome.within_tolerance_min,
    "correction_rate_um_s": lambda outcome, case: outcome.correction_rate_um_s,
}
"""Figures of a run, in the unit that the name ends with. Never settled counts as the run's whole time."""

GATHERINGS = ("worst", "mean", "cvar")


@dataclass(frozen=True)
class Gathered:
    """One figure over all runs of a point.

    Attributes
    ----------
    metric : from `METRICS`
    over : `worst`, `mean`, or `cvar`, the mean of the worst share
    level : that share
    """

    metric: str = "max_abs_um"
    over: str = "worst"
    level: float = 0.2

    @property
    def title(self) -> str:
        """What it is, in words."""
        share = f" of the worst {100 * self.level:g} %" if self.over == "cvar" else ""
        return f"{'mean' if self.over == 'cvar' else self.over}{share} {self.metric}"

    def value(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """The figure for the runs of one point; NaN where one of them gave none."""
        figure = METRICS[self.metric]
        return gather([figure(o, c) for o, c in zip(outcomes, cases, strict=True)], self.over, self.level)


@dataclass(frozen=True)
class Constraint:
    """A figure that must not exceed a bound."""

    figure: Gathered
    at_most: float

    def excess(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """By how much the bound is exceeded; 0 or below where it is kept."""
        return self.figure.value(outcomes, cases) - self.at_most


def gather(values: Sequence[float], over: str, level: float) -> float:
    """Largest value, mean, or conditional value at risk.

    The last is the mean of the worst `level` share of the values, the value at its edge counting in part:
    R. T. Rockafellar and S. Uryasev, "Conditional value-at-risk for general loss distributions", Journal of
    Banking & Finance 26 (2002), proposition 8.
    """
    if any(math.isnan(value) for value in values):
        return math.nan
    if over == "worst":
        return max(values)
    if over == "mean":
        return math.fsum(values) / len(values)
    wanted = level * len(values)
    ordered = sorted(values, reverse=True)
    whole = math.floor(wanted + 1e-9)
    parts = ordered[:whole]
    if whole < len(ordered):
        parts.append((wanted - whole) * ordered[whole])
    return math.fsum(parts) / wanted


def read_objective(table: Any, where: str) -> Gathered:
    """Objective from its table in a study file.

    Raises
    ------
    InputError
        If it names what does not exist, or the level is no share.
    """
    return _gathered(table, where, set())


def read_constraint(table: Any, where: str) -> Constraint:
    """Constraint from its table in a study file. Raises as `read_objective`."""
    figure = _gathered(table, where, {"at_most"})
    bound = table.get("at_most")
    if not math.isfinite(number(bound)):
        raise InputError(f"{where}.at_most: {shown(bound)} is no bound; give a number in the metric's unit")
    return Constraint(figure, float(bound))


def _gathered(table: Any, where: str, more: set[str]) -> Gathered:
    if not isinstance(table, Mapping):
        raise InputError(f"{where}: is not a table; give it metric and over")
    known = {"metric", "over", "level"} | more
    unknown = sorted(set(table) - known)
    if unknown:
        raise InputError(f"{where}: {unknown[0]} is not known; {instead(unknown[0], sorted(known))}")
    metric = one_of(METRICS, table.get("metric", "max_abs_um"), f"{where}.metric")
    over = one_of(GATHERINGS, table.get("over", "worst"), f"{where}.over")
    level = table.get("level", 0.2)
    if not 0 < number(level) <= 1:
        raise InputError(f"{where}.level: {shown(level)} is no share; give a number above 0, at most 1")
    return Gathered(metric, over, float(level))


def one_of(known: Iterable[str], value: Any, where: str) -> str:
    """A name that must be one of those known; raises InputError otherwise."""
    if not isinstance(value, str) or value not in known:
        name = value if isinstance(value, str) else ""
        raise InputError(f"{where}: {shown(value)} is not known; {instead(name, known)}")
    return value


def number(value: Any) -> float:
    """A number as a float; NaN for what is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf
