"""The objective of a study: one figure of each run, combined into one number."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated

from warmlink.orchestration.scenarios.entries import Number, OneOf
from warmlink.orchestration.scenarios.written import TABLE
from warmlink.orchestration.studies.case import Case, Outcome

Metric = Callable[[Outcome, Case], float]


def _time_to_tolerance(outcome: Outcome, case: Case) -> float:
    return case.stop_time if outcome.time_to_tolerance_s is None else outcome.time_to_tolerance_s


METRICS: dict[str, Metric] = {
    "max_abs_um": lambda outcome, case: outcome.max_abs_um,
    "p95_abs_um": lambda outcome, case: outcome.p95_abs_um,
    "rms_um": lambda outcome, case: outcome.rms_um,
    "time_to_tolerance_s": _time_to_tolerance,
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

    __pydantic_config__ = TABLE

    metric: Annotated[str, OneOf(tuple(METRICS))] = "max_abs_um"
    over: Annotated[str, OneOf(GATHERINGS)] = "worst"
    level: Annotated[float, Number("share", above=0, at_most=1)] = 0.2

    @property
    def title(self) -> str:
        """The objective in words."""
        share = f" of the worst {100 * self.level:g} %" if self.over == "cvar" else ""
        return f"{'mean' if self.over == 'cvar' else self.over}{share} {self.metric}"

    def limited(self, at_most: float) -> Constraint:
        """The constraint that it exceeds no bound."""
        return Constraint(self.metric, self.over, self.level, at_most=at_most)

    def value(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """The figure for the runs of one point; NaN where one of them gave none."""
        figure = METRICS[self.metric]
        return gather([figure(o, c) for o, c in zip(outcomes, cases, strict=True)], self.over, self.level)


@dataclass(frozen=True)
class Constraint(Gathered):
    """A figure that must not exceed a bound, which is in the metric's unit."""

    __pydantic_config__ = TABLE

    at_most: Annotated[float, Number("bound")] = field(kw_only=True)

    def excess(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """Amount by which the bound is exceeded; 0 or negative if it is kept."""
        return self.value(outcomes, cases) - self.at_most


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
