"""Random values that a slave's variables may take, by its own model description."""

from __future__ import annotations

import math
import random
import re

from slave import OK, Slave


def value(slave: Slave, name: str, rng: random.Random, tails: bool = False) -> float:
    """Some value inside the variable's range, with tails one of any size."""
    v = slave.variables[name]
    if v.type == "Boolean":
        return rng.random() < 0.5
    low = -math.inf if v.min is None else float(v.min)
    high = math.inf if v.max is None else float(v.max)
    start = float(v.start)
    if v.type == "Integer":
        return rng.randint(int(max(low, 0)), int(min(high, 5)))
    kind = rng.random()
    if kind < 0.25:
        return start
    if kind < 0.35 and name in slave.accepting_nan:
        return math.nan
    scale = float(v.nominal or abs(start) or 1.0)
    if kind < 0.6 and start:
        drawn = start * rng.uniform(0.5, 1.5)
    elif kind < 0.8 or not tails:
        drawn = scale * rng.uniform(0.01, 2.0)
    else:
        drawn = rng.choice((1, 1, -1)) * scale * 10 ** rng.uniform(-8.0, 2.0)
    return min(max(drawn, low), high)


def start_time(rng: random.Random) -> float:
    return rng.choice((0.0, 10 ** rng.uniform(0.0, 5.5), rng.uniform(0.0, 1e5)))


def other(slave: Slave, name: str, present: float, rng: random.Random, tails: bool) -> float:
    """A value that differs from the present one."""
    for _ in range(50):
        drawn = value(slave, name, rng, tails)
        if drawn != present and not (math.isnan(drawn) and math.isnan(present)):
            return drawn
    raise AssertionError(f"{name} has one value alone")


def running(fmu: str, rng: random.Random) -> Slave:
    """An initialized slave with random parameters that pass its own checks, and random inputs."""
    start = start_time(rng)
    probe = Slave(fmu)
    parameters = {name: value(probe, name, rng) for name in probe.named("parameter")}
    if "sample_time" in parameters:
        # A nanosecond is a fair sample time, but not one to run 10 s with.
        parameters["sample_time"] = rng.uniform(0.3, 3.0)
    # Second moments drawn one by one belong to no random variables: the law's estimates would be NaN.
    parameters |= {n: float(probe.variables[n].start) for n in parameters if n.startswith("moments[")}
    for _ in range(2 * len(parameters) + 1):
        slave = Slave(fmu, start=start)
        inputs = {name: value(slave, name, rng) for name in slave.named("input")}
        slave.initialize(parameters | inputs)
        if not slave.messages:
            for _ in range(rng.randint(0, 3)):
                stepped(slave, rng.choice((0.5, 1.0, 10.0)))
            return slave
        # The check's sentence speaks of one element; of the vectors in it the same element counts.
        sentence = slave.messages[0][2]
        blamed = sentence.partition(":")[0].partition(".")[2]
        element = blamed.partition("[")[1] + blamed.partition("[")[2]
        named = {blamed} | {word + element for word in re.findall(r"\w+", sentence)}
        starts = {n: float(slave.variables[n].start) for n in parameters}
        again = {n: v for n, v in parameters.items() if n in named and v != starts[n]}
        parameters |= {n: starts[n] for n in again} or starts
    raise AssertionError("no parameters pass")


def stepped(slave: Slave, step: float) -> Slave:
    assert slave.step(slave.time, step) == OK, slave.messages
    slave.time += step
    return slave
