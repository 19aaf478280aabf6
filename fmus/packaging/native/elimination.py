"""Sparse Gaussian elimination on expressions, written out once so that a C compiler sees plain arithmetic.

Pivots are taken from the diagonal without exchange: the matrices are I - gamma h J of dissipative systems,
whose diagonal dominates for every step size.
"""

from __future__ import annotations

from typing import Any

from warmlink.fmus.packaging.native.casadi_code import unsimplified

Expression = Any
"""A CasADi SX."""


def elimination_order(coupled: list[set[int]]) -> list[int]:
    """Order in which to eliminate unknowns: least fill first, and of equals the one left alone longest.

    The second rule works a chain from both its ends at once, so that a processor has two independent
    chains of divisions to overlap rather than one of twice the length.

    Parameters
    ----------
    coupled : for each unknown the others that share an equation with it
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


class Factorisation:
    """Matrix of expressions, factorised symbolically; solves for any number of right-hand sides.

    Parameters
    ----------
    matrix : square CasADi SX, shape (n, n)
    """

    def __init__(self, matrix: Expression) -> None:
        size = matrix.shape[0]
        rows: list[dict[int, Expression]] = [{} for _ in range(size)]
        for i, j, element in zip(*matrix.sparsity().get_triplet(), matrix.nonzeros(), strict=True):
            rows[i][j] = element
        coupled: list[set[int]] = [set() for _ in range(size)]
        for i, row in enumerate(rows):
            for j in row:
                coupled[i].add(j)
                coupled[j].add(i)
        self._order = elimination_order(coupled)
        self._rows = rows
        self._lower: list[tuple[int, int, Expression]] = []
        self._reciprocals: dict[int, Expression] = {}
        remaining = set(range(size))
        for pivot in self._order:
            remaining.discard(pivot)
            self._eliminate(pivot, remaining)

    def solve(self, right: Expression) -> Expression:
        """Solution for one right-hand side, shape (n,)."""
        import casadi

        size = len(self._order)
        known = [right[i] for i in range(size)]
        for i, pivot, factor in self._lower:
            known[i] = known[i] - factor * known[pivot]
        solution: dict[int, Expression] = {}
        for pivot in reversed(self._order):
            value = known[pivot]
            for j, element in self._rows[pivot].items():
                if j in solution:
                    value = value - element * solution[j]
            with unsimplified():
                solution[pivot] = value * self._reciprocals[pivot]
        return casadi.vertcat(*(solution[i] for i in range(size)))

    def _eliminate(self, pivot: int, remaining: set[int]) -> None:
        row = self._rows[pivot]
        self._reciprocals[pivot] = 1 / row[pivot]
        for i in sorted(remaining):
            below = self._rows[i].pop(pivot, None)
            if below is None:
                continue
            with unsimplified():
                factor = below * self._reciprocals[pivot]
            self._lower.append((i, pivot, factor))
            for j, element in row.items():
                if j in remaining:
                    self._rows[i][j] = self._rows[i].get(j, 0) - factor * element
