"""The bench's own machines: heat is kept, logs are as an owner's, and warmlink's plant is not in them."""

from __future__ import annotations

import ast
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks import strange_machine
from benchmarks.strange_machine import STEP, Demand, Machine, Room, logs


def test_heat_is_kept() -> None:
    """Heat stored and lost is the heat that was made, to rounding."""
    machine, room = Machine(3), Room(wander=0.0)
    run = machine.run([Demand(3600, 3.4, 0.0)], 1, room)
    p, rise = machine.p, np.diff(run.history, axis=0)
    _, to_room, _ = machine._solver(3.4, 0.0, 0.0)
    warm = run.history[:-1, strange_machine.LUMPS.index("gearbox")]
    friction = (p["coulomb"] + p["viscous"] * np.exp(-p["thinning"] * (warm - 22.0)) * 3.4) * 3.4
    made = STEP * (friction + p["brake_power"])
    lost = STEP * (run.history[1:] - run.air[:, None]) @ to_room
    assert rise @ machine.capacity + lost == pytest.approx(made, rel=1e-6)


def test_a_machine_at_rest_in_still_air_stays_as_it_is() -> None:
    """What is as warm as the air neither warms nor grows."""
    run = Machine(1).run([Demand(3600)], 1, Room(wander=0.0))
    assert np.ptp(run.history) < 1e-9
    assert np.ptp(run.log()["growth [um]"]) == 0.0


def test_a_day_is_quick_and_logs_are_as_an_owner_has_them() -> None:
    """Measured columns, growth once a minute, and growth as large as tolerances make one care about."""
    begun = time.perf_counter()
    found = dict(logs(2))
    hours = sum(len(each) for each in found.values()) / 3600
    assert (time.perf_counter() - begun) / (hours / 24) < 3.0
    log = found["training"]
    assert log["elongation [um]"].notna().sum() == 300
    assert 50 < log["growth [um]"].max() < 150
    base = log["base_temperature [degC]"]
    assert (16 * base == (16 * base).round()).all()
    assert np.std(np.diff(base[7000:7600])) == pytest.approx(0.1 * 2**0.5, rel=0.2)


def test_machines_differ_by_their_seed_alone() -> None:
    """The same seed gives the same log."""
    one, again, other = (Machine(seed).run([Demand(600, 3, 2)], 5).log() for seed in (1, 1, 2))
    assert one.equals(again)
    assert not one.equals(other)


def test_nothing_of_the_laws_or_their_plant_is_in_it() -> None:
    """It imports NumPy, SciPy and pandas alone."""
    tree = ast.parse(Path(strange_machine.__file__).read_text("utf-8"))
    imported = [each.module for each in ast.walk(tree) if isinstance(each, ast.ImportFrom)]
    assert not [name for name in imported if name and name.startswith("warmlink")]
