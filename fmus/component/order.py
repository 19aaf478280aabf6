"""The order in which coupled components are stepped one after another."""

from __future__ import annotations

from collections.abc import Sequence


def stepping_order(direct: Sequence[set[int]], every: Sequence[set[int]]) -> tuple[int, ...]:
    """Order such that each comes after those on which its outputs depend at once.

    Among those that may come next, the one with the fewest other sources still ahead is taken, then the
    first. In a cycle of direct feedthrough the one with the fewest open dependencies goes first, so the
    order is the same on every machine.

    Parameters
    ----------
    direct : for each component the others whose values act on its connected outputs at once
    every : for each component all others that it takes values from
    """
    remaining = list(range(len(direct)))
    order: list[int] = []
    while remaining:
        ahead = set(remaining)
        best = min(remaining, key=lambda k: (len(direct[k] & ahead), len(every[k] & ahead), k))
        order.append(best)
        remaining.remove(best)
    return tuple(order)
