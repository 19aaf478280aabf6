"""Sweeps: a grid or a Latin hypercube of points, each run in closed loop, as one table."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.cores.workers import Workers
from warmlink.orchestration.studies.objective import METRICS
from warmlink.orchestration.studies.points import Judged, evaluate, latin_hypercube
from warmlink.orchestration.studies.study import MOST_POINTS, Point, Study

AT_ONCE = 1000
"""Points whose runs are laid out in memory, some 10 kB for each run."""

Progress = Callable[[int], None]
"""Called with the number of points done."""


def points_of(study: Study) -> list[Point]:
    """The points of a sweep in the order of its table; InputError for more than anybody can have meant."""
    names = [axis.name for axis in study.axes]
    if study.sweep.kind == "grid":
        levels = [axis.levels(study.sweep.points) for axis in study.axes]
        count = math.prod(len(level) for level in levels)
        if count > MOST_POINTS:
            raise InputError(
                f"{study.name}: a grid of {count} points; give fewer points for each parameter, "
                "or a latin_hypercube"
            )
        return [dict(zip(names, values, strict=True)) for values in itertools.product(*levels)]
    return latin_hypercube(study, study.sweep.points)


def sweep(study: Study, points: list[Point], workers: Workers, progress: Progress) -> list[Judged]:
    """Run the points; gives what each came to in their order."""
    found: list[Judged] = []
    for first in range(0, len(points), AT_ONCE):
        for judged in evaluate(study, points[first : first + AT_ONCE], workers, first):
            found.append(judged)
            progress(len(found))
    return sorted(found, key=lambda judged: judged.number)


def write_parquet(study: Study, found: list[Judged], path: Path) -> None:
    """Write a row for each run: point, values, duty cycle, mismatch, figures, objective, reason.

    Figures that a run does not have are null; the objective is that of all runs of the point.
    """
    import pyarrow
    from pyarrow import parquet

    figures = [*(name for name in METRICS if name != "outside_tolerance_min"), "within_tolerance_min"]
    text, number = pyarrow.string(), pyarrow.float64()
    schema = pyarrow.schema(
        [
            ("point", pyarrow.int64()),
            *((axis.heading, number) for axis in study.axes),
            *(("duty_cycle", text), ("mismatch", text)),
            *((name, number) for name in (*figures, "objective")),
            *(("feasible", pyarrow.bool_()), ("reason", text)),
        ]
    )
    rows = [
        {
            "point": each.number,
            **{axis.heading: each.point[axis.name] for axis in study.axes},
            "duty_cycle": duty,
            "mismatch": mismatch,
            **(each.outcomes[k].to_dict() if each.outcomes else {}),
            **each.to_dict(),
        }
        for each in found
        for k, (duty, mismatch) in enumerate(study.runs)
    ]
    with path.open("wb") as stream:
        parquet.write_table(pyarrow.Table.from_pylist(rows, schema), stream)
