"""Whether a communication step size is stable, that is, whether small disturbances die out.

This is checked after a run, from a copy of its first state, so that the check cannot disturb the run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.structure import continuous_inputs
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.recorder import Recorder
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.master.slaves.under_way import SIZE, UnderWay

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
    points: CommunicationPoints,
    rewind: Callable[[], None],
    advance: Callable[[Recorder], None],
) -> tuple[str, ...]:
    """Say where a disturbance grows with the steps of an explicit algorithm of that name, and what to do.

    `rewind` goes back to the beginning of a run that is over, where the slaves are left; `advance` steps
    until a recorder is full.
    """
    factor = _growth(network, replace(points, count=min(PROBE_STEPS, points.count)), rewind, advance)
    if factor is None or factor < GROWS_FROM:
        return ()
    return (
        f"{name} is unstable here with steps of {points.step_size:g} s: a disturbance of the exchanged "
        f"values grows {factor:.3g} times in a step; take smaller steps or an iterated algorithm",
    )


def _growth(
    network: Network,
    points: CommunicationPoints,
    rewind: Callable[[], None],
    advance: Callable[[Recorder], None],
) -> float | None:
    """Give the factor by which a disturbance grows from one communication step to the next.

    None where there is nothing to disturb or the probe itself fails.
    """
    wires = (network.wires[k][p] for k in range(len(network.slaves)) for p in continuous_inputs(network, k))
    sources = {(wire.slave, wire.position): network.source(wire) for wire in wires}
    if not sources or points.count < 4:
        return None
    names = [f"{network.slaves[k].name}.{source.name}" for (k, _), source in sources.items()]
    scale = np.array([nominal(source) for source in sources.values()])
    found: list[Array] = []
    overflown = False
    for size in (0.0, DISTURBANCE):
        rewind()
        for sign, ((k, position), of) in enumerate(zip(sources, scale, strict=True)):
            network.outputs[k][position] = float(network.outputs[k][position]) + size * of * (-1) ** sign
        for k in range(len(network.slaves)):
            network.write(k)
        recorder = Recorder(network, names, points, None, None)
        recorder.cells = UnderWay(bytearray(SIZE)).cells  # those of this process tell of the run
        try:
            recorder.take()
            advance(recorder)
        except SlaveError as failure:
            if failure.status != "not finite":
                return None
            overflown = True
        found.append(np.asarray(recorder.table().values)[1:] / scale)
    rewind()
    base, disturbed = found
    # Values that had grown beyond all bounds were unstable; a NaN from nowhere says nothing of the step.
    if overflown and len(base) and float(np.max(np.abs(base[-1]))) > BEYOND_BOUNDS:
        return float("inf")
    common = min(len(base), len(disturbed))
    distances = np.max(np.abs(disturbed[:common] - base[:common]), axis=1, initial=0.0)
    beyond = np.flatnonzero(distances > ENOUGH * DISTURBANCE)
    if beyond.size:
        return float((distances[beyond[0]] / distances[0]) ** (1.0 / max(beyond[0], 1)))
    if overflown or common < points.count:
        return None
    quarter = points.count // 4
    before, after = np.max(distances[-2 * quarter : -quarter]), np.max(distances[-quarter:])
    return float((after / before) ** (1.0 / quarter)) if before > 0 else None
