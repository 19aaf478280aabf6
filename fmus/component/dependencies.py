"""Which outputs depend directly on which inputs, found from the structure of the component's functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from warmlink.fmus.component import Component

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True)
class Dependencies:
    """What each scalar output depends on, by its name.

    Attributes
    ----------
    outputs : names of the inputs that act on the output at once, the states being held; with `time` where
        time itself acts
    initial : names of the inputs and parameters that settle the output during initialization, with `time`
    """

    outputs: dict[str, tuple[str, ...]]
    initial: dict[str, tuple[str, ...]]


TIME = "time"


@lru_cache(maxsize=256)
def dependencies(
    component: Component, states: tuple[str, ...] = (), rates: tuple[str, ...] = ()
) -> Dependencies:
    """Find the dependencies of a component by the sparsity of its functions in CasADi, which takes a while.

    A variable that only stands in a condition counts: it acts on the output though its derivative is zero.

    Parameters
    ----------
    component : the declaration
    states, rates : names by which the states and their time derivatives go, where a host knows them; states
        then act on outputs and rates, and rates stand beside the outputs, at the start the states too
    """
    import casadi

    sizes = {"x": component.x.size, "u": component.u.size, "p": component.p.size, "t": 1}
    x, u, p, t = (casadi.SX.sym(name, size) for name, size in sizes.items())
    settled, nothing = component.settled(p), casadi.SX(0, 1)

    def unknowns(x: casadi.SX) -> casadi.SX:
        slopes = component.rates_of(x, u, settled, t) if rates else nothing
        return casadi.vertcat(component.outputs_of(x, u, settled, t)[: component.output_count], slopes)

    # The start values stand in place of the states, as they do during initialization.
    begun = casadi.SX(component.states_at_start(u, settled))
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
    """For each element of an expression the names of what it depends on, in the order of `known`."""
    import casadi

    pattern = casadi.jacobian_sparsity(casadi.SX(expression), casadi.vertcat(*symbols))
    found: dict[str, list[int]] = {name: [] for name in unknowns}
    for row, column in zip(*pattern.get_triplet(), strict=True):
        found[unknowns[row]].append(column)
    return {name: tuple(known[column] for column in sorted(each)) for name, each in found.items()}
