"""How far off the tool point is: the figures of one run, and a controller compared with none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array


@dataclass(frozen=True)
class ErrorMetrics:
    """Figures of one error history, in um and s.

    `time_to_tolerance_s` is the first time after which the error stays within the tolerance: 0 if it always
    does, None if it is outside at the end.
    """

    max_abs_um: float
    rms_um: float
    p95_abs_um: float
    time_to_tolerance_s: float | None


def error_metrics(time: Array, error: Array, tolerance: float) -> ErrorMetrics:
    """Figures of an error history in m at communication points in s, shapes (n,), by a tolerance in m."""
    size, span = np.abs(error), time[-1] - time[0]
    outside = np.flatnonzero(~(size <= tolerance))
    settled: float | None = 0.0
    if outside.size:
        settled = None if outside[-1] == size.size - 1 else float(time[outside[-1] + 1])
    # Each communication point is weighted with the time that it represents.
    mean_square = np.trapezoid(error**2, time) / span if span > 0 else error[-1] ** 2
    largest, p95 = np.max(size), np.nan
    if np.isfinite(largest):  # what np.percentile gives, without the 8 ms that its first call takes
        place = 0.95 * (size.size - 1)
        below, above = int(place), min(int(place) + 1, size.size - 1)
        low, high = np.partition(size, (below, above))[[below, above]]
        p95 = (high - low) * (place - below) + low
    return ErrorMetrics(
        max_abs_um=1e6 * float(largest),
        rms_um=1e6 * float(np.sqrt(float(mean_square))),
        p95_abs_um=1e6 * float(p95),
        time_to_tolerance_s=settled,
    )


@dataclass(frozen=True)
class Conduct:
    """What controllers say of their error, and how they move the tool point; shares in percent.

    Controllers are ready where all of them are; this is wrong where the error is outside the tolerance, and
    `fine_not_ready_percent` is the share of the time within tolerance in which one of them is not. Of several
    controllers the one counts that travels farthest in an hour, and that leaps farthest in a step. Where no
    controller says whether it is ready, the percents are NaN.
    """

    ready_percent: float
    ready_wrong_percent: float
    fine_not_ready_percent: float
    travel_um_h: float
    leap_um: float


CONDUCT = tuple(each.name for each in fields(Conduct))
"""Names of these figures."""


def conduct(
    time: Array, error: Array, ready: Sequence[Array], corrections: Sequence[Array], tolerance: float
) -> Conduct:
    """Conduct of controllers over a run.

    Parameters
    ----------
    time, error : communication points in s, and the error there in m, shapes (n,)
    ready, corrections : what each controller says, 1 or 0, and its correction in m, shapes (n,) each
    tolerance : largest error in m that production allows
    """
    # Each communication point counts for the step that begins with it.
    spans = np.diff(time)
    said = np.all([np.asarray(each)[:-1] > 0.5 for each in ready], axis=0)
    fine = np.abs(error[:-1]) <= tolerance
    moves = [np.abs(np.diff(each)) for each in corrections]

    def percent(those: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
        """Share of a time in which something holds; 0 if there is no such time, NaN if nobody says it."""
        if not ready:
            return math.nan
        whole = float(np.sum(spans[among]))
        return 100 * float(np.sum(spans[those & among])) / whole if whole > 0 else 0.0

    hours = float(np.sum(spans)) / 3600
    return Conduct(
        ready_percent=percent(said, np.ones_like(fine)),
        ready_wrong_percent=percent(~fine, said),
        fine_not_ready_percent=percent(~said, fine),
        travel_um_h=1e6 * max((float(np.sum(each)) for each in moves), default=0.0) / hours if hours else 0.0,
        leap_um=1e6 * max((float(np.max(each, initial=0.0)) for each in moves), default=0.0),
    )


WARM_UP_GRID_S = 60.0
"""Time between the moments at which the end of a warm-up is tried, in s."""


def warm_up_first(time: Array, elongation: Array, tolerance: float) -> float:
    """Minutes within tolerance if the robot warms up without compensation and the zero is then set once.

    The end of the warm-up is the best of the moments on a grid of a minute, as if it had been known
    beforehand, so that a real warm-up gives at most a minute more. The growth is looked at six times a
    minute, or at every step where steps are longer.

    Parameters
    ----------
    time, elongation : communication points in s, equally far apart, and the growth there in m, shapes (n,)
    tolerance : largest error in m that production allows
    """
    step = float(time[1] - time[0])
    stride = max(1, round(WARM_UP_GRID_S / 6 / step))
    at, growth = time[::stride], elongation[::stride]
    each_minute = max(1, round(WARM_UP_GRID_S / (stride * step)))
    ends, spans, numbers = np.arange(0, at.size, each_minute), np.diff(at), np.arange(at.size - 1)
    best = 0.0
    for first in range(0, ends.size, 16):  # as many at once as fit into a processor's cache
        begin = ends[first]
        if at[-1] - at[begin] <= best:  # nor would any that begins later
            break
        some = ends[first : first + 16, None]
        away = growth[begin:-1] - growth[some]
        good = np.abs(away, out=away) <= tolerance
        good[:, : some[-1, 0] - begin] &= numbers[begin : some[-1, 0]] >= some
        best = max(best, float(np.max(good @ spans[begin:], initial=0.0)))
    return best / 60


SMALLEST_SHOWN_UM = 0.05
"""Errors below this are printed as 0.0 um, so that a share of them means nothing."""


def reduction_percent(
    uncompensated: ErrorMetrics, compensated: ErrorMetrics, budget_um: float = 0.0
) -> float | None:
    """Share of the largest error that was removed, in percent.

    None if one of the two errors is within the error budget, or too small to be shown.
    """
    least = max(budget_um, SMALLEST_SHOWN_UM)
    if not (uncompensated.max_abs_um > least and compensated.max_abs_um > least):
        return None
    return 100 * (1 - compensated.max_abs_um / uncompensated.max_abs_um)


def shown_percent(percent: float) -> str:
    """Whole percent, as `97 %`; what is nearly 100 % and not all of it has a decimal, as `99.6 %`."""
    return f"{min(percent, 99.9):.1f} %" if 99.5 <= percent < 100.0 else f"{percent:.0f} %"
