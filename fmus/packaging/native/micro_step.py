"""One micro step of the continuous states, in C: with all that a component can do, and without what is rare.

Most runs want nothing of what the rare parameters bring, which can take a fifth of a step.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from warmlink.fmus.calls import Written, called
from warmlink.fmus.component import Component
from warmlink.fmus.component.integrator import GAMMA, ros2
from warmlink.fmus.packaging.native.casadi_code import (
    Expression,
    Function,
    Symbols,
    apart,
    function,
    unsimplified,
)


def elimination_order(coupled: list[set[int]]) -> list[int]:
    """Order in which to eliminate unknowns: least fill first, and of equals the one left alone longest.

    For each unknown the others are given that share an equation with it. The second rule works a chain from
    both its ends at once: a processor can overlap two chains of divisions, but not one of twice the length.
    """
    neighbours = [set(others) - {i} for i, others in enumerate(coupled)]
    remaining = set(range(len(coupled)))
    touched = [0] * len(coupled)
    order: list[int] = []
    while remaining:
        chosen = min(remaining, key=lambda i: (len(neighbours[i]), touched[i], i))
        remaining.discard(chosen)
        order.append(chosen)
        for i in neighbours[chosen]:
            neighbours[i] = (neighbours[i] | neighbours[chosen]) - {i, chosen}
            touched[i] = len(order)
    return order


def solver(matrix: Expression) -> Callable[[Expression], Expression]:
    """Solution of a matrix (SX, shape (n, n)) for any right-hand side, shape (n,), as a function of that."""
    return Elimination(matrix).solved


class Elimination:
    """A matrix (SX, shape (n, n)) and the solutions of equations with it.

    The elimination is written out once, so that a C compiler sees plain arithmetic. Pivots are taken from the
    diagonal without exchange: the matrices are I - gamma h J of dissipative systems, whose diagonal dominates
    for every step size.

    Attributes
    ----------
    factors : what solutions need of the matrix, a vector
    """

    def __init__(self, matrix: Expression) -> None:
        import casadi

        self._size = size = matrix.shape[0]
        rows: list[dict[int, Expression]] = [{} for _ in range(size)]
        coupled: list[set[int]] = [set() for _ in range(size)]
        for i, j, element in zip(*matrix.sparsity().get_triplet(), matrix.nonzeros(), strict=True):
            rows[i][j] = element
            coupled[i].add(j)
            coupled[j].add(i)
        self._order = elimination_order(coupled)
        reciprocals: dict[int, Expression] = {}
        lower: dict[tuple[int, int], Expression] = {}
        for k, pivot in enumerate(self._order):
            reciprocals[pivot] = 1 / rows[pivot][pivot]
            left = sorted(self._order[k + 1 :])
            lower |= {(i, pivot): each for i, each in _eliminate(rows, pivot, left, reciprocals[pivot])}
        upper = {(i, j): element for i, row in enumerate(rows) for j, element in row.items() if i != j}
        self._lower, self._upper = list(lower), list(upper)
        numbers = (*(reciprocals[i] for i in range(size)), *lower.values(), *upper.values())
        self.factors = casadi.vertcat(*numbers)

    def solved(self, right: Expression, factors: Expression | None = None) -> Expression:
        """Solution for a right-hand side, shape (n,), from the factors, or symbols that stand for them."""
        import casadi

        numbers = self.factors if factors is None else factors
        each = iter([numbers[k] for k in range(numbers.numel())])
        reciprocals = [next(each) for _ in range(self._size)]
        known = [right[i] for i in range(self._size)]
        for (i, pivot), factor in zip(self._lower, each, strict=False):
            known[i] = known[i] - factor * known[pivot]
        rows: list[dict[int, Expression]] = [{} for _ in range(self._size)]
        for (i, j), element in zip(self._upper, each, strict=True):
            rows[i][j] = element
        solution: dict[int, Expression] = {}
        for pivot in reversed(self._order):
            value = known[pivot]
            for j, element in rows[pivot].items():
                if j in solution:
                    value = value - element * solution[j]
            with unsimplified():
                solution[pivot] = value * reciprocals[pivot]
        return casadi.vertcat(*(solution[i] for i in range(self._size)))


def _eliminate(
    rows: list[dict[int, Expression]], pivot: int, remaining: list[int], reciprocal: Expression
) -> Iterator[tuple[int, Expression]]:
    """Take an unknown out of the remaining rows; yield those that held it, with the pivot row's factor."""
    row = {j: element for j, element in rows[pivot].items() if j in remaining}
    for i in remaining:
        below = rows[i].pop(pivot, None)
        if below is None:
            continue
        with unsimplified():
            factor = below * reciprocal
        for j, element in row.items():
            rows[i][j] = rows[i].get(j, 0) - factor * element
        yield i, factor


def stepping(component: Component, s: Symbols, later: Expression | None = None) -> Iterator[Function]:
    """Yield `advance`, the states after one step, without what is rare while all that brings it is 0.

    Parameters
    ----------
    component : a component with rates
    s : its symbols, the inputs being those at the start of the step
    later : inputs at the end of the step, shape (u.size,), given after those at its start. None: the same;
        in that place is given what `held`, yielded first, makes for the usual step of inputs, settled
        parameters and step size
    """
    import casadi

    at_end = s.u if later is None else later
    rare = [component.d.index[each.name] for each in component.parameters if each.rare]
    settled = casadi.SX(s.d)
    settled[rare] = 0
    usual = _micro_step(component, replace(s, d=settled), at_end)
    if later is None:
        (usual,), later, held = apart([usual], s.u, s.d, s.step)
        yield "held", [s.u, s.d, s.step], held
    arguments = [s.x, s.u, later, s.d, s.time, s.step]
    if not rare:
        yield "advance", arguments, usual
        return
    whole = function("advance_with_all", arguments, _micro_step(component, s, at_end))
    less = function("advance_without", arguments, usual)
    given = whole.mx_in()
    asked = casadi.sum1(given[3][rare] != 0)
    yield "advance", given, called(whole, Written(whole, otherwise=less))(asked, *given)


def _micro_step(component: Component, s: Symbols, later: Expression) -> Expression:
    """Continuous states after one step of ROS2, the method of the Python form, as expressions."""
    import casadi

    size = component.continuous.size
    x, held = s.x[:size], s.x[size:]
    slope = component.rates_of(*s.now)
    solve: Callable[[Expression], Expression] = partial(component.solved, p=s.d, step=GAMMA * s.step)
    if component.solve is None:
        solve = solver(casadi.SX.eye(size) - GAMMA * s.step * casadi.jacobian(slope, x))

    def slope_ahead(ahead: Expression) -> Expression:
        return component.rates_of(casadi.vertcat(ahead, held), later, s.d, s.time + s.step, held_at=s.time)

    return ros2(slope, solve, slope_ahead, x, s.step)
