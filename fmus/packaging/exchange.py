"""What hosts see of a component's inside: local variables; states and rates, which they may integrate."""

from dataclasses import dataclass, replace
from functools import cache

from warmlink.fmus.component import Component, Record, Values
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


@dataclass(frozen=True)
class ExchangedState:
    """A continuous state as hosts see it, beside the variable that is its rate.

    Attributes
    ----------
    name : name of the variable, as `state.temperature[1]`; an output may bear the state's own name
    reference, rate_reference : value references, after all others and after time
    """

    name: str
    unit: str
    nominal: float
    reference: int
    rate_reference: int

    @property
    def rate_name(self) -> str:
        """Name of the rate, as FMI's structured names have it."""
        return f"der({self.name})"

    @property
    def rate_unit(self) -> str:
        """Unit of the rate."""
        return f"{self.unit}/s"


def exchanged_states(component: Component) -> list[ExchangedState]:
    """States of a component that can be integrated by its host: one that samples nothing.

    Returns
    -------
    list of ExchangedState
        Empty for a component that samples, or has no states.
    """
    if component.sampled or not component.states:
        return []
    first, count = component.p.size + component.u.size + component.y.size + 1, component.x.size
    states = [state for state in component.states for _ in range(state.count)]
    return [
        ExchangedState(
            f"state.{name}", state.unit, _nominal(component, state.name), first + i, first + count + i
        )
        for i, (name, state) in enumerate(zip(component.x.names, states, strict=True))
    ]


def _nominal(component: Component, state: str) -> float:
    """Nominal value of the output of the same name, or of the parameter that it starts from, or 1."""
    whole, _, own = state.rpartition(".")
    part = component.joint.parts[whole] if component.joint else component
    declared = next(each for each in part.states if each.name == own)
    known = {variable.name: variable.nominal for variable in (*part.parameters, *part.outputs)}
    return known.get(own) or known.get(str(declared.start)) or 1.0
