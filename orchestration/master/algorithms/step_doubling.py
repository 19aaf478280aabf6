"""Step-size control by step doubling: each part is done in one step and in two, and compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from warmlink.orchestration.master.algorithms.algorithm import Around, Stepper
from warmlink.orchestration.master.algorithms.iteration import Vector
from warmlink.orchestration.master.algorithms.signals import continuous_inputs
from warmlink.orchestration.master.algorithms.substeps import SubSteps, halvings, refuse_unless_repeatable
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import nominal

SHARE_OF_NOMINAL = 1e-6


@dataclass(frozen=True)
class StepDoubling(Around):
    """Keep the coupling error of chosen variables within tolerances over the whole run.

    The two results differ by (2**p - 1) times the error of the finer one, p being the order of the inner
    algorithm (Richardson). The finer one is kept where that error is at most the tolerance's share of the
    part in the run's duration; else the part is halved and repeated. Errors that do not grow by themselves
    then stay below the tolerance at the end, too.

    Parameters
    ----------
    tolerances : mapping, optional
        Largest error by `slave.variable`, in that variable's unit; default: 1e-6 of the nominal value for
        every continuous signal that is exchanged.
    minimum_step : float, optional
        In s; the run stops where an even smaller step were needed. Default: 1/1024 of the communication
        step size.
    """

    tolerances: Mapping[str, float] | None = None
    minimum_step: float | None = None
    repeats_steps: ClassVar[bool] = True

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network, whose slaves must all be able to repeat steps."""
        refuse_unless_repeatable(network, "step doubling")
        return DoublingStepper(network, self, points)


class DoublingStepper(SubSteps):
    """Step doubling on one network."""

    def __init__(self, network: Network, chosen: StepDoubling, points: CommunicationPoints) -> None:
        order = chosen.inner.order
        super().__init__(
            network,
            chosen.inner.bind(network, points),
            halvings(points.step_size, chosen.minimum_step or points.step_size / 1024),
            0.5 ** (order + 2),
        )
        self._duration = points.stop_time - points.start_time
        self._share = float(2**order - 1)
        tolerances = _exchanged(network) if chosen.tolerances is None else chosen.tolerances
        self._places = [network.locate(name) for name in tolerances]
        self._tolerances = np.array(list(tolerances.values()))
        self._start: Snapshot | None = None

    def attempt(self, time: float, step_size: float) -> float:
        """Step once, go back, step twice, compare."""
        self._start = self.network.snapshot(reuse=self._start)
        memory = self.inner.memory()
        self.inner.step(time, step_size)
        if self.too_long:
            return np.inf
        coarse = self._values()
        self.back(self._start, memory)
        self.inner.step(time, step_size / 2)
        self.inner.step(time + step_size / 2, step_size / 2)
        allowed = self._tolerances * (step_size / self._duration)
        return float(np.max(np.abs(self._values() - coarse) / self._share / allowed, initial=0.0))

    def _values(self) -> Vector:
        return np.array([self.network.slaves[k].get((name,))[0] for k, name in self._places], float)


def _exchanged(network: Network) -> dict[str, float]:
    """Give a tolerance for every continuous signal that is exchanged."""
    found = {}
    for k in range(len(network.slaves)):
        for position in continuous_inputs(network, k):
            wire = network.wires[k][position]
            slave, name = network.slaves[wire.slave], network.reads[wire.slave][wire.position]
            found[f"{slave.name}.{name}"] = SHARE_OF_NOMINAL * nominal(slave.variables[name])
    return found
