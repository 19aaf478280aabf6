"""Serialise the state of FMUs at a random time, restore it here and in a new instance, and compare bits."""

from __future__ import annotations

import json
import random
import sys

from sampling import running, stepped, value
from slave import Slave


def continued(slave: Slave, plan: list[tuple[dict[str, float], float]]) -> list[str]:
    rows = []
    for inputs, step in plan:
        slave.set(inputs)
        stepped(slave, step)
        rows.append(slave.bits())
    return rows


def check(fmu: str, rng: random.Random) -> int:
    slave = running(fmu, rng)

    def plan(count: int) -> list[tuple[dict[str, float], float]]:
        names = slave.named("input")
        # The longest is chosen seldom: a law then takes twenty samples in Python.
        steps = rng.choices((0.3, 1.0, 7.0, 20.0), (6, 6, 3, 1), k=count)
        return [({name: value(slave, name, rng) for name in names}, step) for step in steps]

    continued(slave, plan(rng.randint(1, 12)))
    time, at = slave.time, slave.bits()
    state = slave.fmu.getFMUState()
    stored = slave.fmu.serializeFMUState(state)
    rest = plan(6)
    first = continued(slave, rest)

    slave.fmu.setFMUState(state)
    slave.time = time
    assert slave.bits() == at, "the state itself differs after a restore"
    assert continued(slave, rest) == first, "the same instance goes on differently"

    fresh = Slave(fmu, "two")
    fresh.fmu.setFMUState(fresh.fmu.deSerializeFMUstate(stored))
    fresh.time = time
    assert fresh.bits() == at, "the state itself differs in another instance"
    assert continued(fresh, rest) == first, "another instance goes on differently"
    assert fresh.fmu.serializeFMUState(fresh.fmu.getFMUState()) == slave.fmu.serializeFMUState(
        slave.fmu.getFMUState()
    )
    return len(set(first))


print(json.dumps({fmu: [check(fmu, random.Random(seed)) for seed in range(2)] for fmu in sys.argv[1:]}))
