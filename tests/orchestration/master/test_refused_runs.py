"""What a run is asked for that cannot be is refused before anything is stepped."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.run import simulate

from .pairs import assembly, counter, wire


def asked(algorithm: Any = None, **how: Any) -> None:
    slaves, wires = [counter("x", 1e-3), counter("z", -1e-3)], (wire("x.y -> z.u"), wire("z.y -> x.u"))
    simulate(assembly(slaves, *wires), 10.0, 1.0, algorithm, **how)


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, math.nan])
def test_a_tolerance_that_is_none(tolerance: float) -> None:
    """No error is above one below 0, so that steps of any size were good."""
    with pytest.raises(InputError, match=f"tolerance of x.y: {tolerance:g} is not above 0"):
        asked(StepDoubling(InterfaceNewton(), {"x.y": tolerance}))
    with pytest.raises(InputError, match=f"tolerance: {tolerance:g} is not above 0"):
        asked(FixedPoint(tolerance=tolerance))


@pytest.mark.parametrize("every", [0, 2.5, "3"])
def test_a_number_of_steps_between_checkpoints_that_is_none(every: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"long_run.every=.*: not a number of communication steps"):
        asked(long_run=LongRun(tmp_path, every=every))


def test_a_way_to_step_that_there_is_none() -> None:
    with pytest.raises(InputError, match="stepping='compield': not known; did you mean compiled"):
        asked(stepping="compield")
