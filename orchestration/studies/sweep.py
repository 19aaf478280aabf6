"""Sweeps: all points of a grid or a Latin hypercube, run and judged."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.studies.case import METRICS, Outcome
from warmlink.orchestration.studies.points import (
    AT_ONCE,
    OBJECTIVES,
    Judged,
    Progress,
    Searched,
    evaluate,
    latin_hypercube,
)
from warmlink.orchestration.studies.session import USUAL, RunOptions, open_study
from warmlink.orchestration.studies.study import MOST_POINTS, Point, Study, load_study
from warmlink.orchestration.studies.workers import Workers

if TYPE_CHECKING:
    import pandas
    import pyarrow


@dataclass(frozen=True, repr=False)
class Swept(Searched):
    """A study with all points of its sweep."""

    def table(self) -> pyarrow.Table:
        """A row for each run: point, values, duty cycle, mismatch, figures, objectives, reason.

        Figures that a run does not have are null; an objective is that of all runs of the point.
        """
        import pyarrow

        study, figures = self.study, [name for name in METRICS if name in asdict(Outcome())]
        text, number = pyarrow.string(), pyarrow.float64()
        columns = {
            "point": pyarrow.int64(),
            **{axis.heading: number for axis in study.axes},
            **{"duty_cycle": text, "mismatch": text},
            **dict.fromkeys(
                [*figures, "ready_percent", "within_tolerance_min", *OBJECTIVES[: len(study.objectives)]],
                number,
            ),
            **{"feasible": pyarrow.bool_(), "reason": text},
        }
        rows = [
            {
                "point": each.number,
                **{axis.heading: each.point[axis.name] for axis in study.axes},
                **{"duty_cycle": duty, "mismatch": mismatch},
                **(each.outcomes[k].to_dict() if each.outcomes else {}),
                **each.to_dict(),
            }
            for each in self.found
            for k, (duty, mismatch) in enumerate(study.run_names)
        ]
        return pyarrow.Table.from_pylist(rows, pyarrow.schema(list(columns.items())))

    def to_frame(self) -> pandas.DataFrame:
        """A row for each run, as in `sweep.parquet`."""
        return self.table().to_pandas()

    def write(self, path: Path) -> None:
        """Write a Parquet file with a row for each run."""
        from pyarrow import parquet

        with path.open("wb") as stream:
            parquet.write_table(self.table(), stream)


def sweep_study(
    study: str | Path | Study, *, options: RunOptions = USUAL, out: str | Path | None = None
) -> Swept:
    """Run a grid or a Latin hypercube of parameters in closed loop.

    Parameters
    ----------
    study : a study file (TOML) with a table [sweep], or a shipped study by name
    options : kind of FMU, and number of processes or a Dask scheduler
    out : folder in which finished runs are kept, so that the same call goes on where it was interrupted

    Raises
    ------
    InputError
        If there is no such study, or it asks for what does not exist or cannot be.

    Examples
    --------
    >>> wl.sweep("study.toml").to_frame()
    """
    asked = study if isinstance(study, Study) else load_study(str(study))
    with swept(asked, options, out) as found:
        return found


@contextmanager
def swept(study: Study, options: RunOptions, out: str | Path | None) -> Iterator[Swept]:
    """Run all points of a study's sweep; the folder of the finished runs is locked until the block ends."""
    points = points_of(study)
    with open_study(study.runs, options, out) as work:
        with progress_bar(study.title) as progress:
            found = sweep(study, points, work.workers, lambda done: progress(done / len(points)))
        yield Swept(study, found)


def sweep(study: Study, points: list[Point], workers: Workers, progress: Progress) -> list[Judged]:
    """Run the points; gives what each came to in their order."""
    found: list[Judged] = []
    for first in range(0, len(points), AT_ONCE):
        for judged in evaluate(study, points[first : first + AT_ONCE], workers, first):
            found.append(judged)
            progress(len(found))
    return sorted(found, key=lambda judged: judged.number)


def points_of(study: Study) -> list[Point]:
    """The points of a sweep in the order of its table; InputError for too many points."""
    if study.sweep.kind != "grid":
        return latin_hypercube(study, study.sweep.points)
    levels = [axis.levels(study.sweep.points) for axis in study.axes]
    count = math.prod(len(level) for level in levels)
    if count > MOST_POINTS:
        raise InputError(
            f"{study.name}: a grid of {count} points; give fewer points for each parameter, "
            "or a latin_hypercube"
        )
    names = [axis.name for axis in study.axes]
    return [dict(zip(names, values, strict=True)) for values in itertools.product(*levels)]
