"""Which outputs to compute together: those that share much of their work.

A host asks for a few outputs of many; the others need not be computed, nor the local variables.
"""

from collections import defaultdict

import numpy as np

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native.casadi_code import Symbols

_SHARED_WORK = 0.25
"""Share of the lesser output's operations above which two outputs are computed together."""

LARGEST_COUNT = 64
"""Groups that one word of flags can hold."""


def output_groups(component: Component) -> list[list[int]]:
    """Indices of the outputs, in groups to be computed together.

    Returns
    -------
    list of list of int
        Every output once; at most `LARGEST_COUNT` groups, the last of which are the local variables.
    """
    from scipy.sparse.csgraph import connected_components

    count = component.output_count
    used = np.array([[i in outputs for i in range(count)] for outputs in _operations(component)], dtype=int)
    shared = used.reshape(-1, count).T @ used.reshape(-1, count)
    lesser = np.minimum.outer(shared.diagonal(), shared.diagonal())
    number, labels = connected_components(shared > _SHARED_WORK * lesser, directed=False)
    groups = [np.flatnonzero(labels == label).tolist() for label in range(number)]
    local = [list(range(count, component.y.size))] if count < component.y.size else []
    alone = LARGEST_COUNT - 1 - len(local)
    rest = [i for group in groups[alone:] for i in group]
    return [*groups[:alone], *([rest] if rest else []), *local]


def _operations(component: Component) -> list[frozenset[int]]:
    """For each operation of the outputs' expressions, the outputs that use its result."""
    import casadi

    now = Symbols.of(component).now
    y = casadi.cse(casadi.SX(component.outputs_of(*now))[: component.output_count])
    function = casadi.Function("outputs", now, [y])
    row = function.sparsity_out(0).row()
    leaves = {casadi.OP_INPUT, casadi.OP_CONST, casadi.OP_PARAMETER}
    wanted: dict[int, frozenset[int]] = defaultdict(frozenset)
    operations = []
    for k in reversed(range(function.n_instructions())):
        kind = function.instruction_id(k)
        taken, given = function.instruction_input(k), function.instruction_output(k)
        if kind == casadi.OP_OUTPUT:
            wanted[taken[0]] |= {row[given[1]]}
            continue
        users = wanted.pop(given[0], frozenset())
        if kind not in leaves:
            operations.append(users)
            for slot in taken:
                wanted[slot] |= users
    return operations
