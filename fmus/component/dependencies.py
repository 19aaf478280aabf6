"""Which outputs depend directly on which inputs, and in which order coupled components follow each other.

Dependencies are found from the structure of a component's functions.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from warmlink.fmus.component import Component
from warmlink.fmus.component.variables import split_name
from warmlink.fmus.errors import InputError

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True)
class Dependencies:
    """What each scalar output depends on, by its name; with `time` where time itself acts.

    In `outputs` stand the inputs that act on it at once, the states being held; in `initial` the inputs and
    parameters that settle it during initialization.
    """

    outputs: dict[str, tuple[str, ...]]
    initial: dict[str, tuple[str, ...]]


TIME = "time"

Schedule = Sequence[tuple[str, list[str]]]
"""Parts to evaluate in this order, and which of their outputs are right by then."""


@lru_cache(maxsize=256)
def dependencies(
    component: Component, states: tuple[str, ...] = (), rates: tuple[str, ...] = ()
) -> Dependencies:
    """Find the dependencies of a component by the sparsity of its functions in CasADi, which takes a while.

    A variable that only stands in a condition counts: it acts on the output though its derivative is zero.
    Where a host knows states and rates, by the names given, states act on outputs and rates, and rates stand
    beside the outputs, at the start the states too.
    """
    import casadi

    sizes = (component.x.size, component.u.size, component.p.size, 1)
    x, u, p, t = (casadi.SX.sym(name, size) for name, size in zip("xupt", sizes, strict=True))
    settled, nothing = component.settled(p), casadi.SX(0, 1)

    def unknowns(x: casadi.SX) -> casadi.SX:
        slopes = component.rates_of(x, u, settled, t) if rates else nothing
        return casadi.vertcat(component.outputs_of(x, u, settled, t)[: component.output_count], slopes)

    # The start values stand in place of the states, as they do during initialization.
    begun = casadi.SX(component.states_at_start(u, settled, t))
    at_start = casadi.vertcat(unknowns(begun), begun if states else nothing)
    computed = [*component.y.names[: component.output_count], *rates]
    held = [*component.u.names, TIME]
    return Dependencies(
        _by_unknown(computed, unknowns(x), [*held, *states], [u, t, x] if states else [u, t]),
        _by_unknown([*computed, *states], at_start, [*component.p.names, *held], [p, u, t]),
    )


def _by_unknown(
    unknowns: Sequence[str], expression: casadi.SX, known: Sequence[str], symbols: Sequence[casadi.SX]
) -> dict[str, tuple[str, ...]]:
    """Names of the variables that each element of an expression depends on, in the order of `known`."""
    import casadi

    pattern = casadi.jacobian_sparsity(casadi.SX(expression), casadi.vertcat(*symbols))
    found: dict[str, tuple[str, ...]] = dict.fromkeys(unknowns, ())
    for column, row in sorted(zip(*reversed(pattern.get_triplet()), strict=True)):
        found[unknowns[row]] += (known[column],)
    return found


def stepping_order(direct: Sequence[set[int]], every: Sequence[set[int]]) -> tuple[int, ...]:
    """Order such that each comes after those on which its outputs depend at once.

    Among those that may come next, the one with the fewest other sources still ahead is taken, then the
    first. In a cycle of direct feedthrough the one with the fewest open dependencies goes first, so the
    order is the same on every machine. `direct` has for each component the others whose values act on its
    connected outputs at once, `every` all others that it takes values from.
    """
    ahead = set(range(len(direct)))
    order: list[int] = []
    while ahead:
        order.append(min(ahead, key=lambda k: (len(direct[k] & ahead), len(every[k] & ahead), k)))
        ahead.remove(order[-1])
    return tuple(order)


def _sampling_order(parts: Mapping[str, Component], wires: Mapping[str, str]) -> list[str]:
    """Instances that sample, in the order of data flow, also through parts without memory."""
    sources: dict[str, set[str]] = {key: set() for key in parts}
    for target, source in wires.items():
        sources[target.rpartition(".")[0]].add(source.rpartition(".")[0])

    def sampled_before(key: str, seen: set[str]) -> set[str]:
        found: set[str] = set()
        for giver in sources[key] - seen:
            seen.add(giver)
            if parts[giver].sampled:
                found.add(giver)
            elif not parts[giver].states:
                found |= sampled_before(giver, seen)
        return found

    keys = [key for key, part in parts.items() if part.sampled]
    before = [{keys.index(giver) for giver in sampled_before(key, {key})} for key in keys]
    return [keys[i] for i in stepping_order([set() for _ in keys], before)]


def _evaluation_order(
    parts: Mapping[str, Component],
    wires: Mapping[str, str],
    direct: Mapping[str, Mapping[str, Sequence[str]]],
) -> Schedule:
    """Which parts to evaluate in which order, and which of their outputs are right by then.

    A part comes more than once where some of its outputs feed others that its remaining ones wait for,
    as the link's temperature feeds the motor, whose heat flow the link waits for. `wires` has the output
    behind each input that one feeds, `direct` the inputs that each output of a part depends on at once.
    """
    needs = {
        f"{key}.{output}": {wires[f"{key}.{n}"] for n in known if f"{key}.{n}" in wires}
        for key, of in direct.items()
        for output, known in of.items()
    }
    steps: list[tuple[str, list[str]]] = []
    known: set[str] = set()
    while len(known) < len(needs):
        before = len(known)
        for key in direct:
            names = [n for n in parts[key].y.names if f"{key}.{n}" not in known]
            ready = [n for n in names if needs[f"{key}.{n}"] <= known]
            if ready:
                steps.append((key, ready))
                known |= {f"{key}.{n}" for n in ready}
        if len(known) == before:
            raise InputError(_loop({name: on - known for name, on in needs.items() if name not in known}))
    return steps


@dataclass(frozen=True)
class Orders:
    """In which order the parts of a joined component are evaluated: as it runs, and at its start.

    Attributes
    ----------
    parts : all of them, those that sample at the end, in the order of sampling
    direct : the inputs that each output of a part depends on at once, by part and output
    running, starting : parts, each with those of its outputs that are right by then
    """

    parts: Sequence[str]
    direct: Mapping[str, Mapping[str, Sequence[str]]]
    running: Schedule
    starting: Schedule

    @classmethod
    def of(cls, parts: Mapping[str, Component], wires: Mapping[str, str]) -> Orders:
        """Find the orders; InputError if wires close a loop of signals that depend on each other at once."""
        order = [key for key, part in parts.items() if not part.sampled] + _sampling_order(parts, wires)
        # Whatever rows a table has: what was found for one is not found again for another.
        found = {key: dependencies(replace(parts[key], tables=())) for key in order}
        direct = {key: each.outputs for key, each in found.items()}
        initial = {key: each.initial for key, each in found.items()}
        running, starting = (_evaluation_order(parts, wires, each) for each in (direct, initial))
        return cls(order, direct, running, starting)

    def before(self, waiting: Iterable[str], wires: Mapping[str, str]) -> Schedule:
        """What is evaluated, in which order, as it runs, for some inputs `instance.variable`."""
        ahead, needed = [*waiting], set[str]()
        while ahead:
            source = wires.get(ahead.pop())
            if source is not None and source not in needed:
                needed.add(source)
                key, own = split_name(source)
                ahead += [f"{key}.{name}" for name in self.direct[key][own]]
        steps = ((key, [n for n in ready if f"{key}.{n}" in needed]) for key, ready in self.running)
        return [(key, ready) for key, ready in steps if ready]


def _loop(waiting: Mapping[str, set[str]]) -> str:
    """Sentence that names a loop among outputs, each of which waits for others."""
    path = [next(iter(waiting))]
    while path[-1] not in path[:-1]:
        path.append(next(iter(waiting[path[-1]])))
    loop = path[path.index(path[-1]) :]
    return (
        f"{' <- '.join(loop)}: each of these signals depends on the next at once (an algebraic loop); "
        "put something with a memory between them"
    )
