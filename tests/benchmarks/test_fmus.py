"""The benchmark of steps: its figures hang together, and native FMUs are as fast as they should be."""

from __future__ import annotations

import shutil

import pytest

from benchmarks.fmus import StepTimes, bench_fmus, times_table
from warmlink.fmus.catalogue import catalogue


@pytest.mark.slow
def test_a_step_of_the_link() -> None:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler on this machine")
    (link,) = bench_fmus([entry for entry in catalogue() if entry.component.name == "ThermalLink"])
    # 1.5 µs where a bare loop took 0.87 µs: as a ratio it holds on any machine, and on a busy one.
    assert 0 < link.bare < link.native * 1.5
    assert link.native < 1.5 / 0.87 * link.bare
    assert link.times_faster > 30
    assert link.instance_bytes < 64 * 1024


def test_the_table_says_what_was_measured() -> None:
    lines = times_table([StepTimes("Heater", 0.5, 0.0, 0.1, 50.0, 2048)]).splitlines()
    assert lines[1].split() == ["Heater", "0.5", "s", "-", "0.100", "50.0", "500x", "2.0", "KiB"]
