"""Which outputs to compute together: those that share much of their work.

A host asks for a few outputs of many; the others need not be computed, nor the local variables.
"""

from itertools import combinations

from warmlink.fmus.component import Component

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
    users = _operations(component)
    count = component.output_count
    local = [list(range(count, component.y.size))] if count < component.y.size else []
    own = [sum(1 for outputs in users if i in outputs) for i in range(count)]
    shared = dict.fromkeys(combinations(range(count), 2), 0)
    for outputs in users:
        for pair in combinations(sorted(outputs), 2):
            shared[pair] += 1
    leader = list(range(count))

    def find(i: int) -> int:
        while leader[i] != i:
            i = leader[i]
        return i

    for (a, b), both in shared.items():
        if both > _SHARED_WORK * min(own[a], own[b]):
            leader[max(find(a), find(b))] = min(find(a), find(b))
    groups: dict[int, list[int]] = {}
    for i in range(count):
        groups.setdefault(find(i), []).append(i)
    ordered = list(groups.values())
    alone = LARGEST_COUNT - 1 - len(local)
    rest = [i for group in ordered[alone:] for i in group]
    return [*ordered[:alone], *([rest] if rest else []), *local]


def _operations(component: Component) -> list[frozenset[int]]:
    """For each operation of the outputs' expressions, the outputs that use its result."""
    import casadi

    x, u, d = (
        casadi.SX.sym(n, v.size) for n, v in (("x", component.x), ("u", component.u), ("d", component.d))
    )
    time = casadi.SX.sym("time")
    y = casadi.cse(casadi.SX(component.outputs_of(x, u, d, time))[: component.output_count])
    function = casadi.Function("outputs", [x, u, d, time], [y])
    row = function.sparsity_out(0).row()
    leaves = {casadi.OP_INPUT, casadi.OP_CONST, casadi.OP_PARAMETER}
    wanted: dict[int, frozenset[int]] = {}
    used = []
    for k in reversed(range(function.n_instructions())):
        kind, taken, given = (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
        )
        if kind == casadi.OP_OUTPUT:
            wanted[taken[0]] = wanted.get(taken[0], frozenset()) | {row[given[1]]}
            continue
        users = wanted.pop(given[0], frozenset())
        if kind in leaves:
            continue
        used.append(users)
        for slot in taken:
            wanted[slot] = wanted.get(slot, frozenset()) | users
    return used
