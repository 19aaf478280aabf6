"""Which outputs are computed together: those that share much of their work."""

from collections import Counter, defaultdict

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native.casadi_code import Symbols

_SHARED_WORK = 0.25
"""Share of the lesser output's operations above which two outputs are computed together."""

LARGEST_COUNT = 64
"""Groups that one word of flags can hold."""


def output_groups(component: Component) -> list[list[int]]:
    """Indices of the outputs, in groups to be computed together: those that share much of their work.

    A host asks for a few outputs of many; the others need not be computed, nor the local variables, which are
    the last of at most `LARGEST_COUNT` groups.
    """
    count = component.output_count
    local = [list(range(count, component.y.size))] if count < component.y.size else []
    return [*fewer(groups_by_work(component), LARGEST_COUNT - len(local)), *local]


def fewer(groups: list[list[int]], most: int) -> list[list[int]]:
    """At most so many groups: those beyond are one."""
    rest = [i for group in groups[most - 1 :] for i in group]
    return [*groups[: most - 1], *([rest] if rest else [])]


def groups_by_work(component: Component) -> list[list[int]]:
    """Indices of the outputs that share their work, local variables aside."""
    from scipy.sparse.csgraph import connected_components

    count, operations = component.output_count, _operations(component)
    used = np.array([[i in outputs for i in range(count)] for outputs in operations], dtype=float)
    often = np.array([*operations.values()], dtype=float)
    shared = used.reshape(-1, count).T * often @ used.reshape(-1, count)
    lesser = np.minimum.outer(shared.diagonal(), shared.diagonal())
    number, labels = connected_components(shared > _SHARED_WORK * lesser, directed=False)
    return [np.flatnonzero(labels == label).tolist() for label in range(number)]


def _operations(component: Component) -> Counter[frozenset[int]]:
    """How many operations of the outputs' expressions there are, by the outputs that use their results."""
    import casadi

    now = Symbols.of(component).now
    y = casadi.cse(casadi.SX(component.outputs_of(*now))[: component.output_count])
    function = casadi.Function("outputs", now, [y])
    row = function.sparsity_out(0).row()
    leaves = {casadi.OP_INPUT, casadi.OP_CONST, casadi.OP_PARAMETER}
    wanted: dict[int, frozenset[int]] = defaultdict(frozenset)
    operations: Counter[frozenset[int]] = Counter()
    for k in reversed(range(function.n_instructions())):
        kind = function.instruction_id(k)
        taken, given = function.instruction_input(k), function.instruction_output(k)
        if kind == casadi.OP_OUTPUT:
            wanted[taken[0]] |= {row[given[1]]}
            continue
        users = wanted.pop(given[0], frozenset())
        if kind not in leaves:
            operations[users] += 1
            for slot in taken:
                wanted[slot] |= users
    return operations
