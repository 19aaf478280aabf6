"""One micro step of a joined component of which parts recur, and its rates.

What a kind of part does is written once: its rates, and their derivatives by its own states and by what the
wires bring. Only the elimination, which couples all parts, is written out for the whole.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from warmlink.fmus.component.integrator import GAMMA
from warmlink.fmus.component.variables import split_name
from warmlink.fmus.packaging.native.casadi_code import Expression, Function, Symbols
from warmlink.fmus.packaging.native.kinds import Kind, Place
from warmlink.fmus.packaging.native.micro_step import Elimination
from warmlink.fmus.packaging.native.wired import Tangents, WiredSignals, WirePlan


def stepping(plan: WirePlan) -> Iterator[Function]:
    """Yield `advance`, as `micro_step.stepping` does with other inputs at the end of the step."""
    import casadi

    s, whole = Symbols.of(plan.component, calls=True), plan.component
    later = casadi.MX.sym("later", whole.u.size)
    signals = WiredSignals(plan, plan.states(s.x), s.u, s.d, s.time)
    linear, size = _Linearised(plan, signals, s.step), whole.continuous.size
    solve_first, solve_second = _solving(linear, size)
    ahead, first, factors = solve_first(s.x[:size], s.step, linear.numbers, linear.slope)
    there = WiredSignals(
        plan, plan.states(casadi.vertcat(ahead, s.x[size:])), later, s.d, s.time + s.step, held_at=s.time
    )
    following = solve_second(s.x[:size], s.step, first, factors, rates(there))
    yield "advance", [s.x, s.u, later, s.d, s.time, s.step], following


def slopes(plan: WirePlan) -> Iterator[Function]:
    """Yield `rates` and `rates_tangent`, for hosts that integrate."""
    import casadi

    s = Symbols.of(plan.component, calls=True)
    signals = WiredSignals(plan, plan.states(s.x), s.u, s.d, s.time)
    along = [casadi.MX.sym("also", each.numel()) for each in (s.x, s.u, s.time)]
    tangents = Tangents(signals, plan.states(along[0]), *along[1:])
    yield "rates", s.now, rates(signals)
    moving = (kind.rates_tangent()(*tangents.along(key, kind.rate_inputs)) for key, kind in _moving(plan))
    yield "rates_tangent", [*s.now, *along], casadi.vertcat(*moving)


def rates(signals: WiredSignals) -> Expression:
    """Rates of all continuous states."""
    import casadi

    of = (kind.rates()(*signals.now(key, kind.rate_inputs)) for key, kind in _moving(signals.plan))
    return casadi.vertcat(*of)


def _moving(plan: WirePlan) -> Iterator[tuple[str, Kind]]:
    """Parts with continuous states, in their order, and their kinds."""
    return ((key, kind) for key, kind in plan.kinds.items() if kind.component.continuous.size)


class _Linearised:
    """Rates of a whole, and the numbers that make up the matrix of its steps, I - gamma step J.

    Within a part, it gives the matrix's elements. Between parts an element of J is a sum of products: of a
    rate's derivative by an input, and of that input's by a state.

    Attributes
    ----------
    slope : rates of all continuous states
    numbers : what the elements are made of
    """

    def __init__(self, plan: WirePlan, signals: WiredSignals, step: Expression) -> None:
        import casadi

        self._within: dict[Place, int] = {}
        self._between: dict[Place, list[Place]] = defaultdict(list)
        gradients, slopes, numbers, count = _Gradients(signals), [], [], 0
        wanted, fed_back = _coupling(plan, gradients)
        for key, kind in _moving(plan):
            inputs, size, first = wanted[kind], kind.component.continuous.size, plan.places[key][2].start
            run, places = kind.linearised(inputs, fed_back[kind])
            by_input = {i: gradients.of_input(key, i) for i in inputs}
            back = (by_input[i].get(first + state, casadi.MX(0)) for i, state in fed_back[kind])
            found = run(*signals.now(key, kind.rate_inputs), step, casadi.vertcat(casadi.MX(0, 1), *back))
            slopes.append(found[:size])
            numbers.append(found[size:])
            at = {place: count + k for k, place in enumerate(places)}
            count += len(places)
            self._within |= {(first + i, first + j): number for (i, j), number in at.items() if j < size}
            for k, i in enumerate(inputs):
                rows = [(row, number) for (row, column), number in at.items() if column == size + k]
                for state in sorted(by_input[i].keys() - {*range(first, first + size)}):
                    numbers.append(by_input[i][state])
                    for row, number in rows:
                        self._between[first + row, state].append((number, count))
                    count += 1
        self.slope, self.numbers = casadi.vertcat(*slopes), casadi.vertcat(*numbers)

    def matrix(self, numbers: Expression, step: Expression, size: int) -> Expression:
        """Matrix (SX, shape (size, size)) of a step from the numbers."""
        import casadi

        elements = {place: numbers[number] for place, number in self._within.items()}
        for place, products in self._between.items():
            elements[place] = -(GAMMA * step * sum(numbers[i] * numbers[j] for i, j in products))
        for i in range(size):
            elements.setdefault((i, i), casadi.SX(1))
        order = sorted(elements, key=lambda place: place[::-1])
        sparsity = casadi.Sparsity.triplet(size, size, *map(list, zip(*order, strict=True)))
        return casadi.SX(sparsity, casadi.vertcat(*(elements[place] for place in order)))


def _coupling(plan: WirePlan, gradients: _Gradients) -> tuple[dict[Kind, list[int]], dict[Kind, list[Place]]]:
    """By kind, over all its parts, the inputs of its rates that depend on states, and on which of its own."""
    wanted: dict[Kind, set[int]] = defaultdict(set)
    fed_back: dict[Kind, set[Place]] = defaultdict(set)
    for key, kind in _moving(plan):
        first, size = plan.places[key][2].start, kind.component.continuous.size
        for i in kind.rate_inputs:
            states = gradients.of_input(key, i)
            own = (state - first for state in states)
            wanted[kind] |= {i} if states else set()
            fed_back[kind] |= {(i, state) for state in own if 0 <= state < size}
    return {kind: sorted(of) for kind, of in wanted.items()}, {
        kind: sorted(of) for kind, of in fed_back.items()
    }


class _Gradients:
    """Derivatives of signals by the whole's continuous states, where they are not 0."""

    def __init__(self, signals: WiredSignals) -> None:
        self.signals, self.plan = signals, signals.plan
        self._known: dict[str, dict[int, Expression]] = {}

    def of_input(self, key: str, place: int) -> dict[int, Expression]:
        """Those of a part's input, by the state's index."""
        feed = self.plan.feeds[key][place]
        return {} if isinstance(feed, int) else self._of_output(feed)

    def _of_output(self, name: str) -> dict[int, Expression]:
        if name not in self._known:
            key, own = split_name(name)
            number, at = self.plan.kinds[key].place[own]
            kind, first = self.plan.kinds[key], self.plan.places[key][2].start
            run, places = kind.gradient(number)
            found: dict[int, Expression] = {}
            states = kind.component.continuous.size
            if any(row == at for row, _ in places):
                values = run(*self.signals.now(key, kind.blocks[number].inputs))
                for k, (row, column) in enumerate(places):
                    if row == at and column < states:
                        found[first + column] = values[k]
                    elif row == at:
                        for state, value in self.of_input(key, column - states).items():
                            product = values[k] * value
                            found[state] = found[state] + product if state in found else product
            self._known[name] = found
        return self._known[name]


def _solving(linear: _Linearised, size: int) -> tuple[Any, Any]:
    """Functions for the two stages of ROS2; the second takes the factors of the first."""
    import casadi

    x, step = casadi.SX.sym("x", size), casadi.SX.sym("step")
    numbers = casadi.SX.sym("numbers", linear.numbers.numel())
    slope, first, further = (casadi.SX.sym(name, size) for name in ("slope", "first", "further"))
    elimination = Elimination(linear.matrix(numbers, step, size))
    found = elimination.solved(slope)
    solve_first = casadi.Function(
        "first", [x, step, numbers, slope], [x + step * found, found, elimination.factors]
    )
    factors = casadi.SX.sym("factors", elimination.factors.numel())
    second = elimination.solved(further - 2 * first, factors)
    following = x + step * (1.5 * first + 0.5 * second)
    return solve_first, casadi.Function("second", [x, step, first, factors, further], [following])
