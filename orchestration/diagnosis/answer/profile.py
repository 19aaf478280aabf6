"""Profile likelihood: how chi-square rises as one strength moves away and everything else is fitted anew.

W. Q. Meeker and L. A. Escobar, The American Statistician 49 (1995) 48-53: unlike an interval from the
curvature it shows where a bound, or another cause, ends what the data can say.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.fit.problem import Freed, Item
from warmlink.orchestration.diagnosis.fit.verdict import Assessment

Vector = NDArray[np.float64]

_AWAY = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Standard deviations at which a strength is held."""


@dataclass(frozen=True)
class Profile:
    """Chi-square along one strength.

    Attributes
    ----------
    item, variable : the cause, and what it frees
    values : of the strength in SI, rising, shape (points,)
    rise : of chi-square above its least value, shape (points,)
    """

    item: Item
    variable: str
    values: Vector
    rise: Vector


def profiles_of(assessment: Assessment) -> list[Profile]:
    """Profile of every strength of the chosen model."""
    return [_profile(assessment, item, f) for item in assessment.best.items for f in item.freed]


def _profile(assessment: Assessment, item: Item, freed: Freed) -> Profile:
    best = assessment.best
    index = best.freed.index(freed)
    spread = float(np.sqrt(best.covariance()[index, index]))
    steps = best.theta[index] + spread * np.array(_AWAY)
    values = np.unique(np.clip(steps, freed.lower, freed.upper))
    rise = np.array(list(_refitted(assessment, item, freed, values))) - best.chi2
    name = f"{freed.variable} ({item.label} = {freed.group})" if freed.group else freed.variable
    return Profile(item, name, values, np.maximum(rise, 0.0))


def _refitted(assessment: Assessment, item: Item, freed: Freed, values: Vector) -> Iterable[float]:
    """Chi-square with a strength held at each value."""
    best = assessment.best
    for value in values.tolist():
        held = replace(freed, lower=value, upper=value)
        swapped = {f: held if f is freed else f for f in best.freed}
        items = [replace(i, freed=tuple(swapped[f] for f in i.freed)) for i in best.items]
        start = {swapped[f]: theta for f, theta in zip(best.freed, best.theta.tolist(), strict=True)}
        yield assessment.fitter.fit(items, start).chi2
