"""Perturb every input and parameter of FMUs; print which outputs change, running and at the start."""

from __future__ import annotations

import json
import math
import random
import sys

from sampling import other, running, start_time, value
from slave import Slave

FULL, MOST, MANY = 3, 3000, 8
"""Trials in which everything is perturbed, in the first one by one, and after those at most as many for what
was not seen yet, first together where it is many.

A Boolean at the start is a comparison that random values seldom meet, and gets no trials of its own.
"""

Seen = dict[str, set[str]]


class Point:
    """A slave at some values of its inputs and parameters, and other values for some of them."""

    def __init__(self, slave: Slave, names: list[str], rng: random.Random, tails: bool) -> None:
        self._slave, self._before = slave, slave.outputs()
        self._present = dict(zip(names, slave.get(*names), strict=True))
        self._moved = {name: other(slave, name, at, rng, tails) for name, at in self._present.items()}

    def changed(self, names: list[str]) -> set[str]:
        """Outputs that change where these have their other values."""
        self._slave.set({name: self._moved[name] for name in names})
        pairs = zip(self._slave.named("output"), self._before, self._slave.outputs(), strict=True)
        self._slave.set({name: self._present[name] for name in names})
        return {name for name, a, b in pairs if a != b and not (math.isnan(a) and math.isnan(b))}

    def one_by_one(self, names: list[str], seen: Seen) -> None:
        for name in names:
            for output in self.changed([name]):
                seen[output].add(name)

    def in_groups(self, names: list[str], seen: Seen, said: Seen) -> None:
        """As one by one for outputs that must not change: names are tried together that change the same."""
        groups: dict[frozenset[str], list[str]] = {}
        for name in names:
            groups.setdefault(frozenset(o for o in said if name in said[o]), []).append(name)
        for outputs, alike in groups.items():
            for output in self.changed(alike) - outputs:
                seen[output].update(alike)

    def in_halves(self, names: list[str], seen: Seen, said: Seen) -> None:
        """As one by one, but of those that together change nothing new, none is tried alone."""
        if len(names) == 1:
            self.one_by_one(names, seen)
            return
        every = set(names)
        if any(said[o] & every - seen[o] or not seen[o] & every for o in self.changed(names)):
            self.in_halves(names[::2], seen, said)
            self.in_halves(names[1::2], seen, said)


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
            tried = every if trial < FULL else sorted(unseen)
            point = Point(slave, tried, rng, tails)
            if 0 < trial < FULL:
                point.in_groups(tried, seen, said)
            elif trial == 0 or len(tried) < MANY:
                point.one_by_one(tried, seen)
            else:
                point.in_halves(tried, seen, said)
            if slave is not probe:
                slave.fmu.freeInstance()
        result[phase] = {
            name: {"declared": sorted(said[name]), "seen": sorted(seen[name]), "strict": name in strict}
            for name in said
        }
    return result


fmus = [each for each in sys.argv[1:] if each.endswith(".fmu")]
print(json.dumps({fmu: observed(fmu, random.Random(20), {*sys.argv[1:]} - {*fmus}) for fmu in fmus}))
