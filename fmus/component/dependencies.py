"""Which outputs depend directly on which inputs, from the structure of the component's own functions."""

from __future__ import annotations

from dataclasses import dataclass
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


def dependencies(component: Component) -> Dependencies:
    """Find the dependencies of a component by the sparsity of its functions in CasADi.

    A variable that only stands in a condition counts: it acts on the output though its derivative is zero.
    """
    import casadi

    symbols = {
        "x": casadi.SX.sym("x", component.x.size),
        "u": casadi.SX.sym("u", component.u.size),
        "p": casadi.SX.sym("p", component.p.size),
        "t": casadi.SX.sym("t"),
    }
    u, p, t = symbols["u"], symbols["p"], symbols["t"]
    settled = component.settled(p)
    running = component.outputs_of(symbols["x"], u, settled, t)
    # The start values stand in place of the states, as they do during initialization.
    starting = component.outputs_of(casadi.SX(component.states_at_start(u, settled)), u, settled, t)

    known = casadi.vertcat(p, u, t)
    names = [*component.p.names, *component.u.names, TIME]
    acting = {*component.u.names, TIME}
    return Dependencies(
        {
            output: tuple(name for name in found if name in acting)
            for output, found in _by_output(component, running, known, names).items()
        },
        _by_output(component, starting, known, names),
    )


def _by_output(
    component: Component, expression: casadi.SX, known: casadi.SX, names: list[str]
) -> dict[str, tuple[str, ...]]:
    import casadi

    pattern = casadi.jacobian_sparsity(casadi.SX(expression), known)
    found: dict[str, list[str]] = {name: [] for name in component.y.names}
    for row, column in zip(*pattern.get_triplet(), strict=True):
        found[component.y.names[row]].append(names[column])
    order = {name: i for i, name in enumerate(names)}
    return {name: tuple(sorted(each, key=order.__getitem__)) for name, each in found.items()}
