"""The benchmark of steps measures what it says."""

from __future__ import annotations

import shutil

import pytest

from benchmarks.fmus import StepTimes, bench_fmus, times_table
from warmlink.fmus.catalogue import catalogue


@pytest.mark.slow
def test_a_step_of_the_heater() -> None:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler on this machine")
    (heater,) = bench_fmus([entry for entry in catalogue() if entry.component.name == "Heater"])
    assert heater.python is not None
    assert min(heater.bare, heater.native, heater.python) > 0
    assert 0 < heater.instance_bytes < 64 * 1024


def test_the_table_says_what_was_measured() -> None:
    lines = times_table([StepTimes("Heater", 0.5, 0.0, 0.1, 50.0, 2048)]).splitlines()
    assert lines[1].split() == ["Heater", "0.5", "s", "-", "0.100", "50.0", "500x", "2.0", "KiB"]
