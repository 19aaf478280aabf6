"""How well numbers are known: what was calibrated with its intervals, and the profile of each strength.

Profile likelihood is how chi-square rises as one strength moves away and everything else is fitted anew.
W. Q. Meeker and L. A. Escobar, The American Statistician 49 (1995) 48-53: unlike an interval from the
curvature it shows where a bound, or another cause, ends what the data can say.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.data.experiment import PER_RUN
from warmlink.orchestration.diagnosis.fit.candidates import FreeNumber, Item
from warmlink.orchestration.diagnosis.fit.fitting import held_at, of_numbers
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.system.units import ZERO_CELSIUS

_AWAY = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Standard deviations at which a strength is held."""


INTERVAL = 1.959964
"""Standard deviations on either side of a 95 % interval."""

_ON_BOUND = 1e-3
"""Share of a bound, or of the room between both, within which a number lies on it."""

_ALIKE = 0.95
"""Correlation of two numbers from which the data know only a combination of them."""


@dataclass(frozen=True)
class Calibrated:
    """A calibrated number, its interval within its bounds; its name has the label that it belongs to.

    It is in the SI unit, an absolute temperature in degC (its standard deviation in K).
    `at_bound`: it lies on a bound; `unknown`: the interval covers all between the
    bounds; `alike`: others with which it is correlated so much that only a combination is known.
    """

    name: str
    value: float
    std: float
    low95: float
    high95: float
    unit: str
    at_bound: bool
    unknown: bool
    alike: tuple[str, ...]


def interval(freed: FreeNumber, value: float, std: float, per_si: float = 1.0) -> dict[str, float]:
    """A fitted number, its deviation and its 95 % interval within its bounds, in a unit of so many per SI."""
    low, high = max(value - INTERVAL * std, freed.lower), min(value + INTERVAL * std, freed.upper)
    known = {"value": value, "std": std, "low95": low, "high95": high}
    return {name: each * per_si for name, each in known.items()}


def _read_in(rig: Rig, variable: str, known: dict[str, float]) -> dict[str, Any]:
    """A number with its interval in the unit in which people read it, and that unit."""
    if not rig.variables[variable].is_temperature:
        return {**known, "unit": rig.unit(variable)}
    return {**{name: each - ZERO_CELSIUS * (name != "std") for name, each in known.items()}, "unit": "degC"}


def calibration(diagnosis: Diagnosis) -> list[Calibrated]:
    """Numbers by which the model to use from now on was calibrated, in order, those of causes aside."""
    calibrated = diagnosis.delivery.model == CALIBRATED
    fit, rig = diagnosis.calibration, diagnosis.experiment.rig
    # Where the data know only a combination, the bounds are all that is known of the rest.
    span = np.array([freed.span for freed in fit.freed])
    gram = of_numbers(fit.freed, fit.freed, fit.point)[0]
    covariance = np.linalg.inv(gram * np.outer(span, span) + np.eye(span.size)) * np.outer(span, span)
    spreads = np.sqrt(np.diag(covariance))
    alike = np.abs(covariance) > _ALIKE * np.outer(spreads, spreads)
    names = [f"{f.variable} ({f.group})" if f.group else f.variable for f in fit.freed]
    return [
        Calibrated(
            names[i],
            **_read_in(rig, freed.variable, interval(freed, float(fit.theta[i]), float(spreads[i]))),
            at_bound=_at_bound(freed, float(fit.theta[i])),
            unknown=bool(2 * INTERVAL * spreads[i] > freed.span),
            alike=tuple(names[j] for j in np.flatnonzero(alike[i]) if j != i),
        )
        for i, freed in enumerate(fit.freed)
        if (freed.calibrated or calibrated) and not _is_start(freed) and freed.variable in rig.variables
    ]


def _is_start(freed: FreeNumber) -> bool:
    """Whether it is what a run's start is off by."""
    return freed.calibrated and freed.added


def _at_bound(freed: FreeNumber, value: float) -> bool:
    """Whether it lies on a bound; what is usually at one, as a resistance that is not there, says nothing."""
    bounds = (freed.lower, freed.upper)
    if not freed.calibrated and abs(value - freed.start) <= _ON_BOUND * freed.span:
        return False
    return any(abs(value - each) <= _ON_BOUND * min(abs(each) or freed.span, freed.span) for each in bounds)


def calibration_doubts(diagnosis: Diagnosis) -> list[str]:
    """Sentences on what limits the calibration of the model to use from now on, bounds aside."""
    fit, given = diagnosis.calibration, diagnosis.experiment.calibrated
    said = []
    if given and diagnosis.assessment.problem.ended_early:
        limit = f"{diagnosis.experiment.time_limit:g} s"
        said.append(f"The time limit of {limit} ended the calibration: these are the best numbers so far.")
    elif given and not fit.arrived:
        told = "a further step would still gain something; give starts nearer to them, or calibrate fewer"
        said.append(f"The calibrated numbers are not yet the best ones: {told}.")
    denied = [(f.variable, v) for f, v in fit.values.items() if f.calibrated and f.added]
    if denied and not diagnosis.experiment.initial_measured:
        starts = ", ".join(f"{name} by {value:+.3g} K" for name, value in denied)
        said.append(
            f"The first readings are not those of the start that is given, so it is fitted too: {starts}; "
            'say so with initial = "measured" in the experiment.'
        )
    return said


def met_bounds(diagnosis: Diagnosis) -> str:
    """A sentence on calibrated numbers that lie at their bounds, "" if none does."""
    on = [
        f"{c.name} ({c.value:.4g} {c.unit})".replace(" 1)", ")") for c in calibration(diagnosis) if c.at_bound
    ]
    told = "widen the bounds if they may be wider, or look for what the model lacks"
    return f"At a bound of its calibration lies {', '.join(on)}: {told}." if on else ""


@dataclass(frozen=True)
class Profile:
    """Chi-square along one strength that a cause frees: its rise above the least value, shape (points,).

    The values of the strength are in SI, rising.
    """

    item: Item
    variable: str
    values: Array
    rise: Array


def name_of(item: Item, freed: FreeNumber, variable: str) -> str:
    """Name of a number that a cause frees, with the label that it belongs to."""
    return f"{variable} ({item.label or PER_RUN} = {freed.group})" if freed.group else variable


def profiles_of(assessment: Assessment) -> list[Profile]:
    """Profile of every strength of the chosen model."""
    best = assessment.best
    spreads = np.sqrt(np.diag(best.covariance()))
    found = []
    for item, freed in [(each, freed) for each in best.items for freed in each.freed]:
        index = best.freed.index(freed)
        steps = best.theta[index] + float(spreads[index]) * np.array(_AWAY)
        values = np.unique(np.clip(steps, freed.lower, freed.upper))
        held = (held_at(value, freed, best.items) for value in values.tolist())
        rise = np.array([assessment.fitter.fit(items, best.values).chi2 for items in held]) - best.chi2
        name = name_of(item, freed, freed.variable)
        found.append(Profile(item, name, values, np.maximum(rise, 0.0)))
    return found
