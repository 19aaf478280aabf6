"""Inputs that go on as they went: polynomials through past communication points."""

from __future__ import annotations

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.network import Network
from warmlink.orchestration.master.signals import History, derivatives, port


class Extrapolation:
    """Sets the input derivatives of every slave that takes them, from its past inputs.

    Parameters
    ----------
    network : Network
        With the inputs of the communication point already set.
    order : int
        1 or 2; less while there is too little past.
    """

    def __init__(self, network: Network, order: int) -> None:
        if order not in (0, 1, 2):
            raise InputError(f"extrapolation: order {order} is not known; choose 0, 1 or 2")
        self.order = order
        self.network = network
        self.history = History(network, order)
        ports = [port(network, k) for k in range(len(network.slaves))]
        self._ports = {p.slave: p for p in ports if p.varies and p.positions} if order else {}
        held = [network.slaves[p.slave].name for p in ports if p.positions and not p.varies]
        self.remarks: tuple[str, ...] = ()
        if order and held:
            self.remarks = (
                f"{', '.join(held)}: takes no input derivatives, so its inputs are held during a step "
                "and the coupling is of first order there",
            )

    def apply(self, k: int, time: float) -> None:
        """Let the inputs of a slave vary in the coming step from `time`."""
        at = self._ports.get(k)
        if at is None:
            return
        found = [
            derivatives(self.history.points(k, position, time, self.order + 1)) for position in at.positions
        ]
        slave = self.network.slaves[k]
        slave.set_input_derivatives(at.names, 1, [first for first, _ in found])
        if self.order == 2:
            slave.set_input_derivatives(at.names, 2, [second for _, second in found])
