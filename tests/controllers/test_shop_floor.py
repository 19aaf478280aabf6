"""Signals that lie, controllers that restart: a sample of what `python -m benchmarks.faults` runs."""

import numpy as np
import pytest

from benchmarks.fault_kinds import Kind, kinds
from benchmarks.faults import ALLOWED, ALLOWED_READY, bench_faults, trial

pytestmark = pytest.mark.xdist_group("shop_floor")

KINDS = {kind.name: kind for kind in kinds()}


@pytest.mark.parametrize(
    "name",
    [
        "torque one sample of 1000 while it runs",
        "torque one sample of 200 while it runs",
        "torque x 2 from the start",
        "torque x 3 from the start",
        "torque and speed missing while it runs",
        "speed x 9.5493 from the start",
        "ambient +40 K from the start",
        "ambient +20 K while it runs",
        "ambient in degC while it runs",
        "both +5 K from the start",
        "base -5 K from the start",
        "both delayed 30 min while it runs",
        "both drifts +5 K/h while it runs",
        "restart at 0.7 of the run after 1 s with nothing retained, thermometers gone",
    ],
)
def test_what_was_found_on_the_floor_costs_no_more_than_no_compensation(name: str) -> None:
    """Each cost up to 500 um once, or had `ready` said for an hour at 76 um."""
    found = trial("observer", KINDS[name], "windshield_wiper", 0, 31)
    assert found.worse_by <= ALLOWED
    if found.group in {"duty", "ambient", "restarts"}:
        assert found.ready_wrong <= ALLOWED_READY


def test_a_sample_of_all_kinds_in_any_duty_cycle() -> None:
    chosen = [str(name) for name in np.random.default_rng(20261122).permutation(list(KINDS))[:12]]
    runs = bench_faults(chosen, 1, 20261122, laws=["observer"])
    assert {run.kind for run in runs} == set(chosen)
    assert max(run.worse_by for run in runs) <= ALLOWED


def test_without_a_fault_nothing_is_doubted() -> None:
    found = trial("observer", Kind("none", "sound", lambda told, draw: told), "windshield_wiper", 0, 1)
    assert found.worse_by <= 0.1 * ALLOWED
    assert found.ready_share > 0.99
