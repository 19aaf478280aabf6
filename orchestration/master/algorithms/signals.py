"""Which signals may vary inside a step, and the polynomials by which they do."""

from __future__ import annotations

from collections.abc import Sequence

from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Slave

Point = tuple[float, float]


def is_sampled(slave: Slave) -> bool:
    """Tell whether a slave acts at samples.

    None of its outputs is then a continuous Real, or it has a parameter `sample_time`, as our own have.
    Such a slave sees its inputs at its sampling instants alone, so they are neither interpolated nor
    iterated: it takes the newest values.
    """
    if "sample_time" in slave.variables:
        return True
    outputs = [v for v in slave.variables.values() if v.causality == "output"]
    return bool(outputs) and not any(v.kind == "Real" and v.variability == "continuous" for v in outputs)


def continuous_inputs(network: Network, k: int) -> tuple[int, ...]:
    """Give the positions among a slave's connected inputs of those that are continuous signals.

    Both ends must be continuous Reals, and the slave must not act at samples.
    """
    slave = network.slaves[k]
    if is_sampled(slave):
        return ()
    found = []
    for position, (name, wire) in enumerate(zip(network.writes[k], network.wires[k], strict=True)):
        source = network.slaves[wire.slave].variables[network.reads[wire.slave][wire.position]]
        target = slave.variables[name]
        if all(v.kind == "Real" and v.variability == "continuous" for v in (source, target)):
            found.append(position)
    return tuple(found)


def switching_outputs(network: Network) -> tuple[tuple[int, int], ...]:
    """Give slave and position of the outputs that jump and feed slaves which integrate.

    Such a jump within a step is seen only at its end, too late by part of the step.
    """
    found: dict[tuple[int, int], None] = {}
    for k, slave in enumerate(network.slaves):
        smooth = continuous_inputs(network, k)
        if not is_sampled(slave):
            jumps = (wire for position, wire in enumerate(network.wires[k]) if position not in smooth)
            found |= {(wire.slave, wire.position): None for wire in jumps}
    return tuple(found)


def derivatives(points: Sequence[Point]) -> tuple[float, float]:
    """Give first and second derivative at offset 0 of the polynomial through one to three points.

    Parameters
    ----------
    points : sequence of (offset, value)
        The first has offset 0 s. Newton's divided differences.
    """
    (_, v0), *rest = points
    if not rest:
        return 0.0, 0.0
    (t1, v1), *rest = rest
    slope1 = (v1 - v0) / t1
    if not rest:
        return slope1, 0.0
    t2, v2 = rest[0]
    curvature = ((v2 - v0) / t2 - slope1) / (t2 - t1)
    return slope1 - curvature * t1, 2.0 * curvature


def value_at(points: Sequence[Point], offset: float) -> float:
    """Evaluate the polynomial through one to three points."""
    first, second = derivatives(points)
    return points[0][1] + offset * (first + 0.5 * offset * second)
