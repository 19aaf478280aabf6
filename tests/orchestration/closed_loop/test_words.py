"""Figures as the table of a run shows them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import warmlink as wl
from warmlink.orchestration.closed_loop.metrics import ErrorMetrics, error_metrics
from warmlink.orchestration.closed_loop.outcome import _micrometres, _time_to_tolerance

SMALL: ErrorMetrics = error_metrics(np.arange(2.0), np.zeros(2), 1e-6)


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [(None, "never"), (0.0, "start"), (59.0, "59 s"), (60.0, "1 min"), (3540.0, "59 min"), (5400.0, "1.5 h")],
)
def test_a_time_has_the_unit_in_which_it_is_short(seconds: float | None, shown: str) -> None:
    assert _time_to_tolerance(replace(SMALL, time_to_tolerance_s=seconds)) == shown


def test_an_error_of_more_than_a_metre_is_no_row_of_digits() -> None:
    assert _micrometres(12.34) == "12.3 µm"
    assert _micrometres(3.21e9) == "3.21e+09 µm"


def test_a_long_name_of_a_law_keeps_its_distance_from_its_neighbour() -> None:
    """The two read "nonelinear_observer"."""
    head = wl.run("stop_and_go", "linear_observer", stop="1 min").summary().splitlines()[1]
    assert head.split() == ["none", "linear_observer"]
