"""What hosts see of a component's inside: local variables; states and rates, which they may integrate."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

from warmlink.fmus.component import Component, Local, Record, Scalar, Values
from warmlink.fmus.component.arithmetic import Number


@cache
def opened(component: Component) -> Component:
    """Component whose local variables stand behind its outputs, as native FMUs have them."""
    observe, look_inside = component.observe, component.look_inside
    if look_inside is None:
        return component

    def observe_all(x: Record, u: Record, p: Record, time: Number) -> Values:
        return {**observe(x, u, p, time), **look_inside(x, u, p, time)}

    return replace(
        component, outputs=(*component.outputs, *component.local), observe=observe_all, look_inside=None
    )


class ExchangedState(NamedTuple):
    """A continuous state as hosts see it, as `state.temperature`, and its rate, `der(state.temperature)`.

    Their value references lie after all others and after time.
    """

    state: Scalar
    rate: Scalar


def exchanged_states(component: Component) -> list[ExchangedState]:
    """States of a component that can be integrated by its host: one that samples nothing.

    Returns
    -------
    list of ExchangedState
        Empty for a component that samples, or has no states.
    """
    if component.sampled:
        return []
    first, count = component.p.size + component.u.size + component.y.size + 1, component.x.size
    found: list[ExchangedState] = []
    for each in component.states:
        for name in (f"state.{own}" for own in each.scalar_names):
            nominal = _nominal(component, each.name)
            state = Local(name, each.unit, "state, for hosts that integrate it", nominal=nominal)
            rate = Local(f"der({name})", f"{each.unit}/s", "rate of change")
            at = first + len(found)
            pair = Scalar(at, name, state, 0), Scalar(at + count, rate.name, rate, 0)
            found.append(ExchangedState(*pair))
    return found


def _nominal(component: Component, state: str) -> float:
    """Nominal value of the output of the same name, or of the parameter that it starts from, or 1."""
    whole, _, own = state.rpartition(".")
    part = component.joint.parts[whole] if component.joint else component
    declared = next(each for each in part.states if each.name == own)
    known = {variable.name: variable.nominal for variable in (*part.parameters, *part.outputs)}
    return known.get(own) or known.get(str(declared.start)) or 1.0
