"""Perturb every input and parameter of an FMU; print which outputs change, running and at the start."""

from __future__ import annotations

import json
import math
import random
import sys

from sampling import other, running, start_time, value
from slave import Slave

FULL, MOST = 4, 3000
"""Trials in which everything is perturbed, and after those at most as many for what was not seen yet.

A Boolean at the start is a comparison that random values seldom meet, and gets no trials of its own.
"""

Seen = dict[str, set[str]]


def changed(slave: Slave, names: list[str], rng: random.Random, seen: Seen, tails: bool) -> None:
    outputs = slave.named("output")
    before = slave.outputs()
    for name in names:
        (present,) = slave.get(name)
        slave.set({name: other(slave, name, present, rng, tails)})
        after = slave.outputs()
        for output, a, b in zip(outputs, before, after, strict=True):
            if a != b and not (math.isnan(a) and math.isnan(b)):
                seen[output].add(name)
        slave.set({name: present})


def declared(unknowns: list) -> Seen:
    return {u.variable.name: {d.name for d in u.dependencies} for u in unknowns}


def with_its_check(slave: Slave, rng: random.Random) -> dict[str, float]:
    """What an observer takes for the memory of an earlier run: numbers that add up to the first of them."""
    held = [rng.uniform(0.1, 2.0) for name in slave.named("parameter") if name.startswith("recalled[")][1:]
    check = 1 + sum((1 + 0.618034 * (i % 7) + 0.1 * i) * number for i, number in enumerate(held))
    return {f"recalled[{i}]": number for i, number in enumerate([check, *held], 1)}


def starting(slave: Slave, rng: random.Random, tails: bool) -> Slave:
    """The slave in initialization mode with random parameters, fit or not, and random inputs."""
    slave.fmu.reset()
    slave.fmu.setupExperiment(startTime=start_time(rng))
    slave.fmu.enterInitializationMode()
    names = slave.named("parameter") + slave.named("input")
    slave.set({name: value(slave, name, rng, tails) for name in names})
    if "recalled_for" in slave.variables and rng.random() < 0.5:
        slave.set({**with_its_check(slave, rng), "recalled_for": rng.uniform(0.0, 1000.0)})
    return slave


def observed(fmu: str, rng: random.Random, excused: set[str]) -> dict:
    probe = Slave(fmu)
    description = probe.description
    strict = {v.name for v in description.modelVariables if v.type != "Boolean"}
    result = {}
    for phase, unknowns in (("outputs", description.outputs), ("initial", description.initialUnknowns)):
        said = declared(unknowns)
        seen: Seen = {name: set() for name in said}
        for trial in range(MOST):
            wanted = {n: said[n] - excused for n in said if phase == "outputs" or n in strict}
            unseen = set().union(*(wanted[name] - seen[name] for name in wanted))
            if trial >= FULL and not unseen:
                break
            tails = phase == "initial" and trial % 2 == 1
            slave = running(fmu, rng) if phase == "outputs" else starting(probe, rng, tails)
            every = slave.named("input") + (slave.named("parameter") if phase == "initial" else [])
            changed(slave, every if trial < FULL else sorted(unseen), rng, seen, tails)
            if slave is not probe:
                slave.fmu.freeInstance()
        result[phase] = {
            name: {"declared": sorted(said[name]), "seen": sorted(seen[name]), "strict": name in strict}
            for name in said
        }
    return result


print(json.dumps(observed(sys.argv[1], random.Random(20), set(sys.argv[2:]))))
