"""Whether a communication step size is stable, that is, whether small disturbances die out.

This is checked after a run, from a copy of its first state, so that the check cannot disturb the run.
"""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.algorithm import Stepper
from warmlink.orchestration.master.algorithms.structure import continuous_inputs
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal

PROBE_STEPS = 120
DISTURBANCE = 1e-5  # of the nominal values
# What slaves in a row integrate grows with a power of time, a thermal runaway slowly: both stay below.
GROWS_FROM = 1.025
# Past this there is no doubt, and the numbers would soon overflow.
ENOUGH = 1e8
# Of nominal values.
BEYOND_BOUNDS = 1e100


def instability(
    name: str,
    network: Network,
    stepper: Stepper,
    points: CommunicationPoints,
    start: Snapshot,
    memory: object,
) -> tuple[str, ...]:
    """Say where a disturbance grows with the steps of an explicit algorithm of that name, and what to do.

    Start and memory are the network's state and the stepper's memory at the beginning of a run that is over;
    there the slaves are left.
    """
    factor = _growth(network, stepper, points, start, memory)
    if factor is None or factor < GROWS_FROM:
        return ()
    return (
        f"{name} is unstable here with steps of {points.step_size:g} s: a disturbance of the exchanged "
        f"values grows {factor:.3g} times in a step; take smaller steps or an iterated algorithm",
    )


def _growth(
    network: Network, stepper: Stepper, points: CommunicationPoints, start: Snapshot, memory: object
) -> float | None:
    """Give the factor by which a disturbance grows from one communication step to the next.

    None where there is nothing to disturb or the probe itself fails.
    """
    wires = [(k, position) for k in range(len(network.slaves)) for position in continuous_inputs(network, k)]
    steps = min(PROBE_STEPS, points.count)
    if not wires or steps < 4:
        return None
    scale = np.array([nominal(network.slaves[k].variables[network.writes[k][p]]) for k, p in wires])
    distances: list[float] = []
    base: list[Array] = []
    try:
        for size in (0.0, DISTURBANCE):
            network.rewind(start)
            stepper.recall(memory)
            _disturb(network, wires, size)
            for point in range(steps if size == 0.0 else len(base)):
                stepper.step(points.time(point), points.step_size)
                row = np.array([float(network.gather(k)[p]) for k, p in wires]) / scale
                if size == 0.0:
                    base.append(row)
                    continue
                distances.append(float(np.max(np.abs(row - base[point]))))
                if distances[-1] > ENOUGH * DISTURBANCE:
                    return float((distances[-1] / distances[0]) ** (1.0 / max(point, 1)))
        network.rewind(start)
    except SlaveError as failure:
        # Values that had grown beyond all bounds were unstable; a NaN from nowhere says nothing of the step.
        grown = bool(base) and float(np.max(np.abs(base[-1]))) > BEYOND_BOUNDS
        return float("inf") if failure.status == "not finite" and grown else None
    quarter = steps // 4
    before, after = max(distances[-2 * quarter : -quarter]), max(distances[-quarter:])
    return (after / before) ** (1.0 / quarter) if before > 0 else None


def _disturb(network: Network, wires: list[tuple[int, int]], size: float) -> None:
    """Move the sources of continuous inputs, alternately up and down, and hand them on."""
    for index, (k, position) in enumerate(wires):
        wire = network.wires[k][position]
        step = size * nominal(network.source(wire)) * (-1) ** index
        network.outputs[wire.slave][wire.position] = float(network.outputs[wire.slave][wire.position]) + step
    for k in range(len(network.slaves)):
        network.write(k)
