"""The winner of a study: polished along its gradient, and written as parameter sets (SSV)."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Literal

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.studies.case import Constraint
from warmlink.orchestration.studies.points import Judged, evaluate
from warmlink.orchestration.studies.study import Point, Study
from warmlink.orchestration.studies.workers import Workers
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
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
    reached = zip(study.objectives, winner.objectives, strict=True)
    limits = [*(Constraint(**vars(each), at_most=value) for each, value in reached), *study.constraints]
    found, cases = [winner], study.cases(winner.point, "")

    def left(z: Array) -> Array:
        """Margins of the runs to each limit at shares of the ways between the axes' bounds.

        The first of `z` is by how much the first objective's bound is lowered; the shares follow. What was
        run before, as where that alone differs, the workers know.
        """
        moved = {axis.name: axis.at(float(x)) for axis, x in zip(axes, z[1:], strict=True)}
        (ended,) = evaluate(study, [{**winner.point, **moved}], workers, winner.number)
        if ended.reason is not None:
            raise ArithmeticError
        found.append(ended)
        first, *others = (limit.margins(ended.outcomes, cases) for limit in limits)
        return np.concatenate([first + z[0], *others])

    with suppress(ArithmeticError):
        minimize(
            lambda z: z[0],
            [0.0, *(axis.share(winner.point[axis.name]) for axis in axes)],
            bounds=[(None, None), *[(0.0, 1.0)] * len(axes)],
            constraints={"type": "ineq", "fun": left},
            method="SLSQP",
            options={"maxiter": MOST_ITERATIONS, "ftol": 1e-6, "eps": DIFFERENCE},
        )
    fit = [each for each in found if each.feasible and each.objectives[1:] <= winner.objectives[1:]]
    return min(fit, key=lambda each: each.objective)


def write_winner(study: Study, point: Point, folder: Path) -> list[Path]:
    """Write `winner.ssv` for the compensator, and `winner-INSTANCE.ssv` for what else was varied."""
    sets: dict[str, dict[str, SsvValue]] = {}
    for axis in study.axes:
        instance, _, variable = axis.name.partition(".")
        unit = None if axis.unit == "1" or axis.integer else parse_unit(axis.unit)
        value = int(point[axis.name]) if axis.integer else point[axis.name]
        kind: Literal["Integer", "Real"] = "Integer" if axis.integer else "Real"
        sets.setdefault(instance, {})[variable] = SsvValue(variable, kind, value, unit)
    paths = []
    for instance, values in sets.items():
        path = folder / ("winner.ssv" if instance == COMPENSATOR else f"winner-{instance}.ssv")
        write_ssv(values, path, f"{study.name}, {instance}")
        paths.append(path)
    return paths
