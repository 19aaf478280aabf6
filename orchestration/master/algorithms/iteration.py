"""Implicit coupling: a macro step is repeated by rollback until inputs and outputs agree at its end."""

from __future__ import annotations

from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.algorithms.loops import Group, plan
from warmlink.orchestration.master.algorithms.signals import History, Port, derivatives, port, value_at
from warmlink.orchestration.master.network import Network, Snapshot
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.system.model import Value

Vector = NDArray[np.float64]


class Sweep(Protocol):
    """One evaluation of a group's macro step: from torn input values to what the slaves answer."""

    def __call__(self, torn: Vector) -> Vector:
        """Roll back, step all members, give the values that the torn inputs would take."""


class Solver(Protocol):
    """Finds torn values that the slaves confirm."""

    def solve(self, sweep: Sweep, guess: Vector, scale: Vector) -> Vector | None:
        """Give the values of the last sweep made, or None where it does not converge.

        The last call of `sweep` must be the one whose result is accepted, for it leaves the slaves in
        that state.
        """

    def memory(self) -> object:
        """Give what is carried from step to step."""

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""


class SolverMaker(Protocol):
    """Makes a solver for each group."""

    def __call__(self) -> Solver:
        """Give a new solver."""


class IteratedStepper:
    """Steps groups of slaves one after the other, each iterated until its torn inputs agree.

    During a step an input follows the polynomial through its value at the end of the step (iterated) and
    those at past communication points. Order 0 holds the value of the end; a slave that takes no input
    derivatives gets the mean of the polynomial, held, which is of order two where the step resolves the
    slave's fastest mode.

    Parameters
    ----------
    network : Network
        With inputs set and outputs read.
    interpolation : int
        Order 0, 1 or 2 of the inputs during a step.
    solver : callable
        Makes a solver; one is made for each group of the plan.
    """

    def __init__(self, network: Network, interpolation: int, solver: SolverMaker) -> None:
        if interpolation not in (0, 1, 2):
            raise InputError(f"interpolation: order {interpolation} is not known; choose 0, 1 or 2")
        self.network = network
        self.interpolation = interpolation
        self.plan = plan(network)
        self.remarks = self.plan.remarks
        self.history = History(network, max(interpolation, 1) + 1)
        self.ports = [port(network, k) for k in range(len(network.slaves))]
        self._solvers = [solver() for _ in self.plan.groups]
        self._scales = [self._scale(group) for group in self.plan.groups]
        self._snapshots: list[Snapshot | None] = [None] * len(self.plan.groups)

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network = self.network
        self.history.start(time)
        started = [list(outputs) for outputs in network.outputs]
        for index in range(len(self.plan.groups)):
            self._step_group(index, time, step_size, started)
        for k in self.plan.sampled:
            network.write(k)
            network.step(k, time, step_size)
            network.read(k)
        # Inputs from sampled slaves change only now: they are held during a step.
        for group in self.plan.groups:
            for k in (*group.members, *group.followers):
                network.write(k)
        self.history.keep(time + step_size)

    def memory(self) -> object:
        """Give past inputs and what the solvers carry."""
        return self.history.memory(), [solver.memory() for solver in self._solvers]

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""
        past, carried_by_solvers = cast("tuple[object, list[object]]", memory)
        self.history.recall(past)
        for solver, carried in zip(self._solvers, carried_by_solvers, strict=True):
            solver.recall(carried)

    def _step_group(self, index: int, time: float, step_size: float, started: list[list[Value]]) -> None:
        group = self.plan.groups[index]
        if group.torn:
            self._converge(index, time, step_size, started)
        else:
            for k in group.members:
                self._advance(k, time, step_size, started)
        for k in group.followers:
            self._advance(k, time, step_size, started)

    def _converge(self, index: int, time: float, step_size: float, started: list[list[Value]]) -> None:
        group, network = self.plan.groups[index], self.network
        snapshot = network.snapshot(group.members, self._snapshots[index])
        self._snapshots[index] = snapshot
        fresh = True

        def sweep(torn: Vector) -> Vector:
            nonlocal fresh
            if not fresh:
                for k, state in zip(snapshot.members, snapshot.states, strict=True):
                    network.slaves[k].restore(state)
            fresh = False
            given = dict(zip(group.torn, torn, strict=True))
            for k in group.members:
                self._advance(k, time, step_size, started, given)
            return self._answer(group)

        guess = np.array([self._guess(k, position, time, step_size) for k, position in group.torn])
        if self._solvers[index].solve(sweep, guess, self._scales[index]) is None:
            k, position = group.torn[0]
            raise SlaveError(
                network.slaves[k].name,
                "not converged",
                time,
                f"the iteration of {', '.join(network.slaves[m].name for m in group.members)} does not "
                f"converge within a step of {step_size:g} s; take smaller communication steps",
                network.writes[k][position],
            )

    def _advance(
        self,
        k: int,
        time: float,
        step_size: float,
        started: list[list[Value]],
        torn: dict[tuple[int, int], float] | None = None,
    ) -> None:
        """Step one slave along its input polynomials, then read it with its inputs of the end."""
        network, at = self.network, self.ports[k]
        values = self._held(k, at, started)
        ends = [self._end(k, position, torn or {}) for position in at.positions]
        slopes: list[tuple[float, float]] = []
        for position, end in zip(at.positions, ends, strict=True):
            if self.interpolation == 0:
                values[position] = end
                continue
            points = self._points(k, position, time, step_size, end)
            first, second = derivatives(points)
            if at.varies:
                slopes.append((first, second))
            else:
                values[position] = points[0][1] + step_size * (first / 2 + step_size * second / 6)
        if values:
            network.put(k, values)
        if slopes:
            slave = network.slaves[k]
            slave.set_input_derivatives(at.names, 1, [first for first, _ in slopes])
            if self.interpolation == 2:
                slave.set_input_derivatives(at.names, 2, [second for _, second in slopes])
        network.step(k, time, step_size)
        if at.positions:
            values = list(values)
            for position, end in zip(at.positions, ends, strict=True):
                values[position] = end
            network.put(k, values)
        network.read(k)

    def _held(self, k: int, at: Port, started: list[list[Value]]) -> list[Value]:
        """Give a slave's inputs at the start of the step: continuous ones as they were, others as sent."""
        past = self.history.past[0][1][k]
        smooth = set(at.positions)
        return [
            past[position] if position in smooth else wire.convert(started[wire.slave][wire.position])
            for position, wire in enumerate(self.network.wires[k])
        ]

    def _end(self, k: int, position: int, torn: dict[tuple[int, int], float]) -> float:
        if (k, position) in torn:
            return float(torn[k, position])
        wire = self.network.wires[k][position]
        return float(wire.convert(self.network.outputs[wire.slave][wire.position]))

    def _points(
        self, k: int, position: int, time: float, step_size: float, end: float
    ) -> list[tuple[float, float]]:
        past = self.history.points(k, position, time, self.interpolation)
        return [past[0], (step_size, end), *past[1:]]

    def _guess(self, k: int, position: int, time: float, step_size: float) -> float:
        return value_at(self.history.points(k, position, time, 3), step_size)

    def _answer(self, group: Group) -> Vector:
        network = self.network
        wires = (network.wires[k][position] for k, position in group.torn)
        return np.array([wire.convert(network.outputs[wire.slave][wire.position]) for wire in wires], float)

    def _scale(self, group: Group) -> Vector:
        network = self.network
        return np.array(
            [nominal(network.slaves[k].variables[network.writes[k][position]]) for k, position in group.torn]
        )
