"""Step-size control by a balance: what one slave delivers in a step, the other should receive."""

from __future__ import annotations

from dataclasses import dataclass

from warmlink.orchestration.master.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.audit import Balance
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.substeps import SubSteps, halvings, refuse_unless_repeatable


@dataclass(frozen=True)
class BalanceControl:
    """Keep what a coupling loses or invents within a tolerance over the whole run.

    The residual of a step costs nothing extra, for the slaves count themselves what they give and take:
    heat flow alone, for temperature times heat flow is not a power.

    Parameters
    ----------
    inner : Algorithm
        Does the steps.
    balance : Balance
        Two cumulative outputs.
    tolerance : float
        Largest sum of absolute residuals over the run, in the unit of the balance (J).
    minimum_step : float
        In s; the run stops where an even smaller step were needed.
    """

    inner: Algorithm
    balance: Balance
    tolerance: float
    minimum_step: float

    @property
    def order(self) -> int:
        """Order of convergence of the inner algorithm."""
        return self.inner.order

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network.

        Raises
        ------
        InputError
            Where a slave cannot repeat steps, or an end of the balance is unknown.
        """
        refuse_unless_repeatable(network, "step-size control by a balance")
        return BalanceStepper(network, self, points)


class BalanceStepper(SubSteps):
    """Control by a balance on one network."""

    def __init__(self, network: Network, chosen: BalanceControl, points: CommunicationPoints) -> None:
        super().__init__(
            network,
            chosen.inner.bind(network, points),
            halvings(points.step_size, chosen.minimum_step),
            0.5 ** (chosen.inner.order + 2),
        )
        self._ends = (network.locate(chosen.balance.delivered), network.locate(chosen.balance.received))
        self._rate = chosen.tolerance / (points.stop_time - points.start_time)

    def attempt(self, time: float, step_size: float) -> float:
        """Step and weigh."""
        before = self._difference()
        self.inner.step(time, step_size)
        return abs(self._difference() - before) / (self._rate * step_size)

    def _difference(self) -> float:
        given, taken = (float(self.network.slaves[k].get((name,))[0]) for k, name in self._ends)
        return given - taken
