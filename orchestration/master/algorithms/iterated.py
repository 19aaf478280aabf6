"""Implicit coupling: a macro step is repeated by rollback until inputs and outputs agree at its end.

Fixed points are iterated, accelerated after Anderson, or found by Newton's method.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, cast

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.master.algorithms.algorithm import Algorithm, Stepper
from warmlink.orchestration.master.algorithms.polynomials import Point, derivatives, value_at
from warmlink.orchestration.master.algorithms.structure import continuous_inputs, plan
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.network import Network, SlaveStates
from warmlink.orchestration.master.slaves.slave import SlaveError, nominal
from warmlink.orchestration.system.model import Value

Sweep = Callable[[Array], Array]
"""Goes back to the start of the step, steps a group with torn inputs as given, gives what they should be."""

_REMEMBERED = 3
"""Past communication points, enough for a parabola."""

FARTHEST = 1e8
"""Multiple of its nominal value, or of where it began, beyond which a value has run away."""

DIFFERENCE = 1e-6  # of the nominal value


@dataclass(frozen=True)
class Iterated(Algorithm):
    """Repeat each step until the inputs at its end are what the slaves answer.

    `interpolation` is the order, 0, 1 or 2, of the inputs during a step; `tolerance` is on the residual of
    each iterated input, as a fraction of its nominal value.
    """

    interpolation: int = 1
    tolerance: float = 1e-10
    most: ClassVar[int] = 50
    """Iterations after which a step has not converged."""

    @property
    def order(self) -> int:
        """Order of convergence of the coupling error."""
        return 1 + self.interpolation

    def bind(self, network: Network, points: CommunicationPoints) -> Stepper:
        """Prepare for one network."""
        if self.interpolation not in (0, 1, 2):
            raise InputError(f"interpolation: order {self.interpolation} is not known; choose 0, 1 or 2")
        if not self.tolerance > 0:
            raise InputError(f"tolerance: {self.tolerance:g} is not above 0; give a share, as 1e-10")
        return IteratedStepper(network, self)

    @abstractmethod
    def solve(
        self, sweep: Sweep, guess: Array, scale: Array, kept: Array | None
    ) -> tuple[bool, Array | None]:
        """Find torn values that the slaves confirm; the last sweep made leaves the slaves in their state.

        Begins at `guess`, with `scale` the inputs' nominal values and `kept` what the last step gave to be
        kept. Gives whether it converged and what is to be kept now.
        """


@dataclass(frozen=True)
class FixedPoint(Iterated):
    """Repeat each step with the inputs that the last repetition answered, mixed after Anderson.

    D. G. Anderson, J. ACM 12 (1965) 547; the mixing of H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49
    (2011) 1715.
    """

    depth: ClassVar[int] = 5
    """How many earlier repetitions are mixed."""

    def solve(self, sweep: Sweep, guess: Array, scale: Array, kept: Array | None) -> tuple[bool, None]:
        """Iterate to the tolerance; nothing is carried from step to step."""
        x, farthest = guess, FARTHEST * np.maximum(scale, np.abs(guess))
        steps, changes = list[Array](), list[Array]()
        previous: tuple[Array, Array] | None = None
        for _ in range(self.most):
            residual = sweep(x) - x
            distance = np.abs(x)
            if not np.isfinite(residual).all() or (distance > farthest).any():
                return False, None
            size = np.maximum(scale, distance)
            if (np.abs(residual) <= self.tolerance * size).all():
                return True, None
            if previous is not None:
                steps = [*steps, x - previous[0]][-self.depth :]
                changes = [*changes, residual - previous[1]][-self.depth :]
            previous = (x, residual)
            x = x + residual
            if changes:
                F, X = np.array(changes).T, np.array(steps).T
                mix = np.linalg.lstsq(F / size[:, None], residual / size, rcond=1e-12)[0]
                x = x - (X + F) @ mix
        return False, None


@dataclass(frozen=True)
class InterfaceNewton(Iterated):
    """Solve each step's interface equations by Newton's method, reusing the Jacobian while it serves.

    It is that of the step, from rollback differences. Directional derivatives hold a slave's state fixed, so
    through a thermal link they are zero; what counts is how the outputs at the end of a step answer to the
    inputs during it.
    """

    most: ClassVar[int] = 20

    def solve(
        self, sweep: Sweep, guess: Array, scale: Array, kept: Array | None
    ) -> tuple[bool, Array | None]:
        """Iterate to the tolerance; a Jacobian that reduces the residual too slowly is made anew."""
        x, jacobian, last = guess, kept, np.inf
        farthest = FARTHEST * np.maximum(scale, np.abs(guess))
        for _ in range(self.most):
            residual = sweep(x) - x
            distance = np.abs(x)
            if not np.isfinite(residual).all() or (distance > farthest).any():
                return False, jacobian
            size = np.maximum(scale, distance)
            error = float((np.abs(residual) / size).max())
            if error <= self.tolerance:
                return True, jacobian
            if jacobian is None or error > 0.1 * last:
                jacobian = _differences(sweep, x, residual, size)
            last = error
            try:
                x = x - np.linalg.solve(jacobian, residual)
            except np.linalg.LinAlgError:  # nothing that the inputs are changed to changes what is left
                return False, None
        return False, jacobian


def _differences(sweep: Sweep, x: Array, residual: Array, size: Array) -> Array:
    columns = []
    for j in range(len(x)):
        moved = x.copy()
        moved[j] += DIFFERENCE * size[j]
        columns.append((sweep(moved) - moved - residual) / (moved[j] - x[j]))
    return np.array(columns).T


class Begun(NamedTuple):
    """What a step begins with at one slave: its inputs, and the past of those that are interpolated."""

    values: list[Value]
    past: dict[int, list[Point]]


def _replace(values: list[Value], changed: Mapping[int, Value]) -> None:
    for position, value in changed.items():
        values[position] = value


class IteratedStepper(Stepper):
    """Steps groups of slaves one after the other, each iterated until its torn inputs agree.

    During a step an input follows the polynomial through its value at the end of the step (iterated) and
    those at past communication points. Order 0 holds the value of the end; a slave that takes no input
    derivatives gets the mean of the polynomial, held, which is of order two where the step resolves the
    slave's fastest mode.
    """

    def __init__(self, network: Network, algorithm: Iterated) -> None:
        self.network = network
        self.algorithm = algorithm
        self.plan = plan(network)
        self.remarks = self.plan.remarks
        self._scales = [
            np.array([nominal(network.slaves[k].variables[network.writes[k][p]]) for k, p in group.torn])
            for group in self.plan.groups
        ]
        self._smooth = [continuous_inputs(network, k) for k in range(len(network.slaves))]
        self._names = [tuple(network.writes[k][p] for p in smooth) for k, smooth in enumerate(self._smooth)]
        self._past: list[tuple[float, list[list[Value]]]] = []  # times and inputs, newest first
        self._kept: list[Array | None] = [None] * len(self.plan.groups)
        self._snapshots: list[SlaveStates | None] = [None] * len(self.plan.groups)

    def step(self, time: float, step_size: float) -> None:
        """Advance all slaves by one communication step."""
        network = self.network
        if not self._past:
            self._remember(time)
        started = [list(outputs) for outputs in network.outputs]
        for index, group in enumerate(self.plan.groups):
            members = {k: self._begun(k, time, started) for k in group.members}
            if group.torn:
                self._converge(index, time, step_size, members)
            for k, begun in () if group.torn else members.items():
                self._advance(k, time, step_size, begun)
            for k in group.followers:
                self._advance(k, time, step_size, self._begun(k, time, started))
        for k in self.plan.sampled:
            network.write(k)
            network.step(k, time, step_size)
            network.read(k)
        # Inputs from sampled slaves change only now: they are held during a step.
        for group in self.plan.groups:
            for k in (*group.members, *group.followers):
                network.write(k)
        self._remember(time + step_size)

    def memory(self) -> object:
        """Give past inputs and what the solver carries from step to step."""
        return [(time, [list(v) for v in values]) for time, values in self._past], [
            None if each is None else each.tolist() for each in self._kept
        ]

    def recall(self, memory: object) -> None:
        """Take what `memory` gave."""
        past, kept = cast("tuple[list[tuple[float, list[list[Value]]]], list[Array | None]]", memory)
        self._past, self._kept = list(past), [None if each is None else np.array(each) for each in kept]

    def _remember(self, time: float) -> None:
        now = (time, [list(inputs) for inputs in self.network.inputs])
        self._past = [now, *self._past[: _REMEMBERED - 1]]

    def _begun(self, k: int, time: float, started: list[list[Value]]) -> Begun:
        smooth, order = self._smooth[k], self.algorithm.interpolation
        # Continuous inputs begin as they were, others as they were sent.
        values = [
            self._past[0][1][k][p] if p in smooth else wire.convert(started[wire.slave][wire.position])
            for p, wire in enumerate(self.network.wires[k])
        ]
        return Begun(values, {p: self._points(k, p, time, order) for p in smooth} if order else {})

    def _converge(self, index: int, time: float, step_size: float, members: Mapping[int, Begun]) -> None:
        group, network = self.plan.groups[index], self.network
        snapshot = network.snapshot(group.members, self._snapshots[index])
        self._snapshots[index] = snapshot
        fresh = True

        def sweep(torn: Array) -> Array:
            nonlocal fresh
            if not fresh:
                for k, state in zip(snapshot.members, snapshot.states, strict=True):
                    network.slaves[k].restore(state)
            fresh = False
            given = dict(zip(group.torn, torn.tolist(), strict=True))
            for k, begun in members.items():
                self._advance(k, time, step_size, begun, given)
            return np.array([network.arriving(k, position) for k, position in group.torn], float)

        guess = np.array([value_at(self._points(*each, time, _REMEMBERED), step_size) for each in group.torn])
        scale, kept = self._scales[index], self._kept[index]
        converged, self._kept[index] = self.algorithm.solve(sweep, guess, scale, kept)
        if not converged:
            k, position = group.torn[0]
            told = (
                f"the iteration of {', '.join(network.slaves[m].name for m in group.members)} does not "
                f"converge within a step of {step_size:g} s; take smaller communication steps"
            )
            name, variable = network.slaves[k].name, network.writes[k][position]
            raise SlaveError(name, "not converged", time, told, variable)

    def _advance(
        self,
        k: int,
        time: float,
        step_size: float,
        begun: Begun,
        torn: dict[tuple[int, int], float] | None = None,
    ) -> None:
        """Step one slave along its input polynomials, then read it with its inputs of the end."""
        network, slave, given = self.network, self.network.slaves[k], torn or {}
        ends = {p: given[k, p] if (k, p) in given else float(network.arriving(k, p)) for p in self._smooth[k]}
        values = list(begun.values)
        if not begun.past:
            _replace(values, ends)
        slopes: list[tuple[float, float]] = []
        # FMI 3.0 has no input derivatives, but a slave may ask for its inputs within a step.
        varies = slave.capabilities.interpolate_inputs or slave.capabilities.intermediate_update
        for p, (now, *past) in begun.past.items():
            first, second = derivatives([now, (step_size, ends[p]), *past])
            if varies:
                slopes.append((first, second))
            else:
                values[p] = now[1] + step_size * (first / 2 + step_size * second / 6)
        if values:
            network.put(k, values)
        for i in range(self.algorithm.interpolation if slopes else 0):
            slave.set_input_derivatives(self._names[k], i + 1, [slope[i] for slope in slopes])
        network.step(k, time, step_size)
        if ends:
            values = list(values)
            _replace(values, ends)
            network.put(k, values)
        network.read(k)

    def _points(self, k: int, position: int, now: float, count: int) -> list[Point]:
        """Give at most `count` past values of one input, by their offset from `now`."""
        return [(time - now, float(values[k][position])) for time, values in self._past[:count]]


MASTERS = {
    "fixed_point": (
        FixedPoint(),
        "steps are repeated until inputs and outputs agree, after Anderson, inputs interpolated",
    ),
    "interface_newton": (
        InterfaceNewton(),
        "the same by Newton's method, with step Jacobians from rollback differences",
    ),
}
"""Master algorithms by name, and what each does."""
