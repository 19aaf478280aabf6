"""Which signals may vary inside a step, and the polynomials by which they do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.slaves.slave import Names, Slave, takes_input_derivatives
from warmlink.orchestration.system.model import Value

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


@dataclass(frozen=True)
class Port:
    """The continuous inputs of one slave, and whether they may vary inside a step."""

    slave: int
    positions: tuple[int, ...]
    names: Names
    varies: bool


def port(network: Network, k: int) -> Port:
    """Describe the continuous inputs of a slave."""
    positions = continuous_inputs(network, k)
    names = tuple(network.writes[k][position] for position in positions)
    return Port(k, positions, names, takes_input_derivatives(network.slaves[k]))


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


class History:
    """Inputs at past communication points, newest first; enough for polynomials of one order."""

    def __init__(self, network: Network, order: int) -> None:
        self.network = network
        self.order = order
        self.past: list[tuple[float, list[list[Value]]]] = []

    def keep(self, time: float) -> None:
        """Add the present inputs, those of `time`; only the newest are held."""
        if self.order:
            values = [list(inputs) for inputs in self.network.inputs]
            self.past = [(time, values), *self.past[: self.order]]

    def start(self, time: float) -> None:
        """Take the inputs of the very first communication point."""
        if not self.past:
            self.keep(time)

    def points(self, k: int, position: int, now: float, count: int) -> list[Point]:
        """Give at most `count` past values of one input, by their offset from `now`."""
        return [(time - now, float(values[k][position])) for time, values in self.past[:count]]

    def memory(self) -> object:
        """Give what was kept."""
        return [(time, [list(v) for v in values]) for time, values in self.past]

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""
        self.past = list(memory)  # type: ignore[call-overload]
