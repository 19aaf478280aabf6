"""One micro step of the continuous states, in C: with all that a component can do, and without what is rare.

Most runs want nothing of what the rare parameters bring, which can take a fifth of a step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from warmlink.fmus.component import Component
from warmlink.fmus.component.integrator import GAMMA, ros2
from warmlink.fmus.packaging.native.elimination import Factorisation
from warmlink.fmus.packaging.native.symbols import Expression, Function, Symbols

_CHOICE = """
#include <string.h>

void WL(advance)({declared}, double *result)
{{
    static const int rare[] = {{{rare}}};
    static const double zero;
    int i;
    for (i=0; i < (int)(sizeof rare / sizeof *rare); i++)
        if (memcmp(d + rare[i], &zero, sizeof zero)) {{
            advance_with_all_of({given}, result);
            return;
        }}
    advance_without_of({given}, result);
}}
"""


def stepping(component: Component, s: Symbols, later: Expression | None = None) -> Iterator[Function]:
    """Yield `advance`, the states after one step; where parameters are rare, with all of them and without.

    Parameters
    ----------
    component : a component with rates
    s : its symbols, the inputs being those at the start of the step
    later : inputs at the end of the step, shape (u.size,), given after those at its start; None: the same
    """
    import casadi

    ends = [] if later is None else [later]
    arguments = [s.x, s.u, *ends, s.d, s.time, s.step]
    at_end = s.u if later is None else later
    rare = _rare(component)
    if not rare:
        yield "advance", arguments, _micro_step(component, s, at_end)
        return
    yield "advance_with_all", arguments, _micro_step(component, s, at_end)
    zero = casadi.SX(0)
    without = casadi.vertcat(*(zero if i in rare else each for i, each in enumerate(casadi.vertsplit(s.d))))
    yield "advance_without", arguments, _micro_step(component, replace(s, d=without), at_end)


def choice_of_step(component: Component, arguments: Sequence[str]) -> str:
    """C function `advance` that takes the step without what is rare while that is all 0; empty: none is rare.

    Parameters
    ----------
    arguments : names of those of `stepping`, among them `d`
    """
    rare = _rare(component)
    if not rare:
        return ""
    declared = ", ".join(f"const double *{each}" for each in arguments)
    return _CHOICE.format(declared=declared, rare=", ".join(map(str, rare)), given=", ".join(arguments))


def _rare(component: Component) -> list[int]:
    """Places of the rare parameters in `d`."""
    return [component.d.index[each.name] for each in component.parameters if each.rare]


def _micro_step(component: Component, s: Symbols, later: Expression) -> Expression:
    """Continuous states after one step of ROS2, the method of the Python form, as expressions."""
    import casadi

    size = component.continuous.size
    x, held = s.x[:size], s.x[size:]
    slope = component.rates_of(s.x, s.u, s.d, s.time)
    if component.solve is None:
        solve = Factorisation(casadi.SX.eye(size) - GAMMA * s.step * casadi.jacobian(slope, x)).solve
    else:
        solve = partial(component.solved, p=s.d, step=GAMMA * s.step)

    def slope_ahead(ahead: Expression) -> Expression:
        return component.rates_of(casadi.vertcat(ahead, held), later, s.d, s.time + s.step, since=s.time)

    return ros2(slope, solve, slope_ahead, x, s.step)
