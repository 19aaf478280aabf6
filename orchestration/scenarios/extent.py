"""How long a run may be: what it records has to fit into the memory, and no warm-up lasts for years."""

from __future__ import annotations

from warmlink.fmus.errors import InputError

LONGEST = 365 * 86400.0
"""Longest time in s that a scenario may simulate."""

MOST_POINTS = 1_000_000
"""Communication points of a run that keeps them all: eleven days in steps of 1 s."""

MOST_SEGMENTS = 100_000
"""Segments that a duty cycle may be drawn or ramped into."""


def check_extent(name: str, stop_time: float, step_size: float, most: int = MOST_POINTS) -> None:
    """Refuse a run that is too long or has too many communication points.

    Parameters
    ----------
    name : of the scenario
    stop_time, step_size : in s
    most : communication points that fit

    Raises
    ------
    InputError
        It would run for more than a year, or hold too many points.
    """
    if stop_time > LONGEST:
        raise InputError(
            f"{name}: the stop time {stop_time:g} s is more than a year ({LONGEST:g} s), in which every cell "
            "has long been warm; give a shorter one"
        )
    if stop_time / step_size > most:
        raise InputError(
            f"{name}: {stop_time:g} s in steps of {step_size:g} s are {stop_time / step_size:.3g} "
            f"communication points, and a run keeps at most {most} in memory; take a longer step or "
            "a shorter time, or stream it to disk with `warmlink simulate SYSTEM.ssp --checkpoint 3600`"
        )


def check_segments(count: float, where: str) -> None:
    """Refuse a duty cycle of too many segments; raises InputError."""
    if count > MOST_SEGMENTS:
        raise InputError(
            f"{where}: makes up to {count:.3g} segments, and {MOST_SEGMENTS} are the most; make them longer"
        )
