"""One closed-loop run of a study: its settings, as a value that any process can receive, and its figures."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.closed_loop.metrics import ErrorMetrics, conduct, error_metrics, warm_up_first
from warmlink.orchestration.closed_loop.outcome import discretisation_um
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.error_budget import coupling_error, whole_error
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.plausible import Declared, first_implausible, shipped_components, tight
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.written.entries import Number, OneOf
from warmlink.orchestration.written.tables import Table


@dataclass(frozen=True)
class Case:
    """One run of a system, times in s, start values in SI units by instance and variable.

    The `label` distinguishes it from the others of its study, as (controller, duty cycle, mismatch); `law` is
    the component behind the controllers, `tolerance` the largest error in m that production allows. With
    `with_budget` it is repeated at half the step, which bounds the coupling error.
    """

    label: tuple[str, ...]
    law: str
    values: Mapping[str, Mapping[str, Value]]
    stop_time: float
    step_size: float
    master: str
    tolerance: float
    with_budget: bool = False
    machine: Machine = WARMUP_CELL

    @property
    def work_hours(self) -> float:
        """Hours that take as long to simulate as the run does; half the step takes as long as two runs."""
        return self.stop_time / 3600 * (3 if self.with_budget else 1)

    @property
    def digest(self) -> str:
        """Digest of what the run's figures depend on, the FMUs apart."""
        facts = {name: value for name, value in vars(self).items() if name not in ("label", "machine")}
        machine, roles = self.machine, self.machine.roles
        facts |= {"machine": machine.name, "parts": dict(machine.parts), "wires": machine.wires}
        facts |= {"scaled": {end: asdict(each) for end, each in machine.scaled.items()}, "plant": roles.plant}
        facts |= {"tables": {name: table.digest for name, table in machine.tables.items()}}
        facts |= {"score": roles.score.text, "uncompensated": roles.uncompensated.text}
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Outcome:
    """Figures of one run, each in the unit that its name ends with; NaN or None in a run that stopped.

    Attributes
    ----------
    max_abs_um, p95_abs_um, rms_um, time_to_tolerance_s : as in `ErrorMetrics`
    within_tolerance_min : time that the error was within tolerance
    warm_up_first_min : that time at best, had one warmed up without compensation: see `warm_up_first`
    correction_rate_um_s : fastest change of a correction between two communication points
    discretisation_um : largest estimate that a link makes of the error of its grid
    coupling_um : bound of the coupling error of the growth and of the figures; None where none was asked for
    stopped : why the run ended early, or means nothing; None if neither
    ready_percent, ready_wrong_percent, fine_not_ready_percent, travel_um_h, leap_um : as in `Conduct`; the
        percents are None where no controller says whether it is ready
    """

    max_abs_um: float = math.nan
    p95_abs_um: float = math.nan
    rms_um: float = math.nan
    time_to_tolerance_s: float | None = None
    within_tolerance_min: float = math.nan
    warm_up_first_min: float = math.nan
    correction_rate_um_s: float = math.nan
    discretisation_um: float = math.nan
    coupling_um: float | None = None
    stopped: str | None = None
    ready_percent: float | None = None
    ready_wrong_percent: float | None = None
    fine_not_ready_percent: float | None = None
    travel_um_h: float | None = None
    leap_um: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; NaN becomes None."""
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(self).items()
        }


BOUNDED = ("max_abs_um", "p95_abs_um", "rms_um")
"""Figures whose coupling error is bounded."""


def case_of(scenario: Scenario, label: tuple[str, ...], *, with_budget: bool = False) -> Case:
    """The run that a scenario describes, every value checked; InputError where one cannot be."""
    values = scenario.values()
    algorithm(scenario.master)
    CommunicationPoints.between(0.0, scenario.stop_time, scenario.step_size)
    return Case(
        label=label,
        machine=replace(scenario.machine, designs=None, program=None, detail=None),
        law=scenario.controller.component.name,
        values=values,
        stop_time=scenario.stop_time,
        step_size=scenario.step_size,
        master=scenario.master,
        tolerance=scenario.tolerance,
        with_budget=with_budget,
    )


def run_case(case: Case, fmus: Mapping[str, Path], unpacked: Path | None = None) -> Outcome:
    """Run a case on FMUs by the component's name; a folder `unpacked` keeps what is unpacked of them.

    KeyboardInterrupt where Ctrl-C comes meanwhile.
    """
    system = case.machine.system(fmus, case.law, case.values)

    def simulated(step: float, by: Algorithm) -> Result:
        record = recorded(case.machine)
        ended = simulate(system, case.stop_time, step, by, record=record, balances=(), unpacked=unpacked)
        if ended.reason is not None and ended.error is None:  # nothing else stops a run without an error
            raise KeyboardInterrupt
        return ended

    chosen = algorithm(case.master)
    result = simulated(case.step_size, chosen)
    repeats = case.with_budget and result.reason is None
    fine = simulated(case.step_size / 2, chosen.at_half_the_step()) if repeats else None
    return figures(case, result, fine)


def recorded(machine: Machine) -> tuple[str, ...]:
    """Variables that the figures are computed from."""
    roles = machine.roles
    estimates = [f"{link}.discretisation_error" for link in machine.called("link")]
    scored = (*roles.score.variables, *roles.uncompensated.variables, *machine.corrections, *machine.claims)
    watched = tight(shipped_components(machine.parts))
    return tuple(dict.fromkeys((*scored, *estimates, *roles.plant, *watched)))


def figures(case: Case, result: Result, fine: Result | None = None) -> Outcome:
    """Figures of a run, with the coupling error where there is a run at half the step.

    A run in which a variable leaves its plausible band gives none, so that nothing is ranked by it.
    """
    machine, time = case.machine, result.times
    implausible = first_implausible(
        result.table, Declared(shipped_components(machine.parts), machine.fed, case.values)
    )
    if implausible is not None or result.reason is not None:
        return Outcome(stopped="; then ".join(told for told in (implausible, result.reason) if told))
    error, without = (
        np.asarray(each.value(result.__getitem__))
        for each in (machine.roles.score, machine.roles.uncompensated)
    )
    errors, spans = error_metrics(time, error, case.tolerance), np.diff(time)
    claims, corrections = (
        [result[name] for name in names] for names in (machine.claims, machine.corrections)
    )
    rates = [np.max(np.abs(np.diff(each)) / spans, initial=0.0) for each in corrections]
    said = conduct(time, error, claims, corrections, case.tolerance)
    return Outcome(
        max_abs_um=errors.max_abs_um,
        p95_abs_um=errors.p95_abs_um,
        rms_um=errors.rms_um,
        time_to_tolerance_s=errors.time_to_tolerance_s,
        # Of the steps that begin within it.
        within_tolerance_min=float(np.sum(spans[np.abs(error[:-1]) <= case.tolerance])) / 60,
        warm_up_first_min=warm_up_first(time, without, case.tolerance),
        **{name: None if math.isnan(value) else value for name, value in asdict(said).items()},
        correction_rate_um_s=1e6 * float(max(rates, default=0.0)),
        discretisation_um=discretisation_um(result),
        coupling_um=None if fine is None or fine.reason else _coupling_um(case, result, fine, errors),
    )


def _coupling_um(case: Case, result: Result, fine: Result, errors: ErrorMetrics) -> float:
    """Bound in um of the coupling error of the growth over a run, and of the figures that came of it.

    A controller can make more of the growth's error, as where a thermometer rounds: the figures show it.
    """
    roles, order = case.machine.roles, algorithm(case.master).order
    finer = error_metrics(result.times, np.asarray(roles.score.value(fine.__getitem__))[::2], case.tolerance)
    moved = (whole_error(order) * abs(getattr(errors, name) - getattr(finer, name)) for name in BOUNDED)
    return max(1e6 * max(coupling_error(result, fine, order, roles.plant).values(), default=0.0), *moved)


Metric = Callable[[Outcome, Case], float]


def _known(value: float | None) -> float:
    return math.nan if value is None else value


METRICS: dict[str, Metric] = {
    "max_abs_um": lambda outcome, case: outcome.max_abs_um,
    "p95_abs_um": lambda outcome, case: outcome.p95_abs_um,
    "rms_um": lambda outcome, case: outcome.rms_um,
    "time_to_tolerance_s": lambda outcome, case: (
        math.nan
        if outcome.stopped is not None
        else case.stop_time
        if outcome.time_to_tolerance_s is None
        else outcome.time_to_tolerance_s
    ),
    "outside_tolerance_min": lambda outcome, case: case.stop_time / 60 - outcome.within_tolerance_min,
    "correction_rate_um_s": lambda outcome, case: outcome.correction_rate_um_s,
    "not_ready_percent": lambda outcome, case: 100 - _known(outcome.ready_percent),
    "ready_wrong_percent": lambda outcome, case: _known(outcome.ready_wrong_percent),
    "fine_not_ready_percent": lambda outcome, case: _known(outcome.fine_not_ready_percent),
    "travel_um_h": lambda outcome, case: _known(outcome.travel_um_h),
    "leap_um": lambda outcome, case: _known(outcome.leap_um),
}
"""What a study may rank a run by, smaller being better, in the unit that the name ends with.

Never settled counts as the run's whole time; NaN in a run that stopped.
"""

GATHERINGS = ("worst", "mean", "cvar")


@dataclass(frozen=True)
class Gathered(Table):
    """One figure over all runs of a point: worst, mean, or `cvar`, the mean of the worst `level` share."""

    metric: Annotated[str, OneOf(tuple(METRICS))] = "max_abs_um"
    over: Annotated[str, OneOf(GATHERINGS)] = "worst"
    level: Annotated[float, Number("share", above=0, at_most=1)] = 0.2

    @property
    def title(self) -> str:
        """The objective in words."""
        share = f" of the worst {100 * self.level:g} %" if self.over == "cvar" else ""
        return f"{'mean' if self.over == 'cvar' else self.over}{share} {self.metric}"

    def value(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """The figure for the runs of one point; NaN where one of them gave none."""
        return gather(self._each(outcomes, cases), self.over, self.level)

    def _each(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> list[float]:
        return [METRICS[self.metric](o, c) for o, c in zip(outcomes, cases, strict=True)]


@dataclass(frozen=True)
class Constraint(Gathered):
    """A figure that must not exceed a bound, which is in the metric's unit."""

    at_most: Annotated[float, Number("bound")] = field(kw_only=True)

    def excess(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> float:
        """Amount by which the bound is exceeded; 0 or negative if it is kept."""
        return self.value(outcomes, cases) - self.at_most

    def margins(self, outcomes: Sequence[Outcome], cases: Sequence[Case]) -> Array:
        """What is left of the bound, as a share of it; in the metric's unit where the bound is 0.

        Shape (runs,) where the worst run counts, else (1,): the least of many would have a kink where another
        run becomes the worst, and who searches by derivatives wants none.
        """
        each = self._each(outcomes, cases) if self.over == "worst" else [self.value(outcomes, cases)]
        return (self.at_most - np.array(each)) / (abs(self.at_most) or 1.0)


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
