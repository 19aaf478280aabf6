"""Polynomials through what an input was at the last points: their derivatives and values."""

from __future__ import annotations

from collections.abc import Sequence

Point = tuple[float, float]
"""Time in s, from the start of the step, and value."""


def derivatives(points: Sequence[Point]) -> tuple[float, float]:
    """Give first and second derivative at offset 0 of the polynomial through one to three points.

    The first has offset 0 s. Newton's divided differences.
    """
    (_, v0), *rest = points
    if not rest:
        return 0.0, 0.0
    (t1, v1), *rest = rest
    slope1 = (v1 - v0) / t1
    if not rest:
        return slope1, 0.0
    t2, v2 = rest[0]
    curvature = ((v2 - v0) / t2 - slope1) / (t2 - t1)
    return slope1 - curvature * t1, 2.0 * curvature


def value_at(points: Sequence[Point], offset: float) -> float:
    """Evaluate the polynomial through one to three points."""
    first, second = derivatives(points)
    return points[0][1] + offset * (first + 0.5 * offset * second)
