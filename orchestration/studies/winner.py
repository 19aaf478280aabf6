"""The winner of a study: polished along its gradient, and written as parameter sets (SSV)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Literal

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.studies.case import Constraint
from warmlink.orchestration.studies.points import Judged, evaluate
from warmlink.orchestration.studies.study import Axis, Point, Study
from warmlink.orchestration.studies.workers import Workers
from warmlink.orchestration.system.shipped import COMPENSATOR
from warmlink.orchestration.system.ssp.parameter_values import Parameter, write_ssv
from warmlink.orchestration.system.units import parse_unit

DIFFERENCE = 1e-4
"""Of the way between a parameter's bounds: small beside what matters, large beside rounding."""

MOST_ITERATIONS = 15


def polish(study: Study, winner: Judged, workers: Workers) -> Judged:
    """Improve a winner by sequential quadratic programming; the winner itself if nothing better is found.

    Where another run becomes the worst, the objective has a kink; therefore every run gets a constraint of
    its own, that it stays below a bound, and the bound is minimised. A second objective gets no worse.
    """
    from scipy.optimize import minimize

    axes = [axis for axis in study.axes if not axis.integer and not axis.choice]
    found = [winner]
    linear = cache(partial(_linear, study, axes, workers, found))
    with suppress(ArithmeticError):
        minimize(
            lambda z: z[0],
            [0.0, *(axis.share(winner.point[axis.name]) for axis in axes)],
            jac=lambda z: np.eye(len(z))[0],
            bounds=[(None, None), *[(0.0, 1.0)] * len(axes)],
            constraints={"type": "ineq", "fun": lambda z: linear(*z)[0], "jac": lambda z: linear(*z)[1]},
            method="SLSQP",
            options={"maxiter": MOST_ITERATIONS, "ftol": 1e-6},
        )
    fit = [each for each in found if each.feasible and each.objectives[1:] <= winner.objectives[1:]]
    return min(fit, key=lambda each: each.objective)


def _linear(
    study: Study, axes: Sequence[Axis], workers: Workers, found: list[Judged], bound: float, *place: float
) -> tuple[Array, Array]:
    """Margins to a bound of what the first one found reached, and to constraints, and their derivatives.

    The place is given by shares of the ways between the axes' bounds; its point is found, too. Derivatives
    are differences of runs that go side by side. ArithmeticError where there is no axis, or no figure.
    """
    winner, steps = found[0], np.where(np.array(place) > 0.5, -DIFFERENCE, DIFFERENCE)
    points = [
        {**winner.point, **{axis.name: axis.at(float(x)) for axis, x in zip(axes, each, strict=True)}}
        for each in (place, *(place + np.diag(steps)))
    ]
    ended = sorted(evaluate(study, points, workers, winner.number), key=lambda each: each.number)
    if not axes or any(each.reason is not None for each in ended):
        raise ArithmeticError
    found.append(ended[0])
    reached = zip(study.objectives, winner.objectives, strict=True)
    limits = [*(Constraint(**vars(each), at_most=value) for each, value in reached), *study.constraints]
    cases = study.cases(winner.point, "")
    margins = [[limit.margins(each.outcomes, cases) for limit in limits] for each in ended]
    first, *moved = map(np.concatenate, margins)
    bounded = np.arange(first.size) < margins[0][0].size
    return first + bound * bounded, np.column_stack([bounded, (np.array(moved) - first).T / steps])


def write_winner(study: Study, point: Point, folder: Path) -> list[Path]:
    """Write `winner.ssv` for the compensator, and `winner-INSTANCE.ssv` for what else was varied."""
    sets: dict[str, dict[str, Parameter]] = {}
    for axis in study.axes:
        instance, _, variable = axis.name.partition(".")
        unit = None if axis.unit == "1" or axis.integer else parse_unit(axis.unit)
        value = int(point[axis.name]) if axis.integer else point[axis.name]
        kind: Literal["Integer", "Real"] = "Integer" if axis.integer else "Real"
        sets.setdefault(instance, {})[variable] = Parameter(variable, kind, value, unit)
    paths = []
    for instance, values in sets.items():
        path = folder / ("winner.ssv" if instance == COMPENSATOR else f"winner-{instance}.ssv")
        write_ssv(values, path, f"{study.name}, {instance}")
        paths.append(path)
    return paths
