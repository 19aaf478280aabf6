"""A term as a component: heat by an expression, added to the heat that flows into a place already."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial

from warmlink.fmus.component import Component, Input, Output, Parameter, Record, State, Values
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.quantities import temperature_input
from warmlink.fmus.errors import InputError
from warmlink.fmus.heat_term.law import HeatLaw, identifier

STORED = "resources/heat_term.json"
"""Where an FMU of a term holds the term itself."""

RESERVED = ("heat", "to_heat_flow", "total_to_heat_flow", "lagged", "time")
"""Names of the component's own, which no parameter and no input may have."""

_NOMINAL = {"rad/s": 3.0, "N.m": 2.5, "A": 2.0, "W": 5.0, "m": 5e-5, "1": 1.0}
"""Usual sizes of inputs by their SI unit."""


@dataclass(frozen=True)
class HeatTerm:
    """Heat in W by an expression.

    Attributes
    ----------
    name : of its component, an identifier of C
    heat : the expression, see `law.py`
    inputs : SI unit of each name in the expression that is no parameter: a variable of the machine, or an
        input that something outside drives
    parameters : value in SI and unit of each of the others; the unit is "1" where none is given
    starts : value in SI of inputs until something drives them, where it is not the usual one
    """

    name: str
    heat: str
    inputs: Mapping[str, str]
    parameters: Mapping[str, tuple[float, str]]
    starts: Mapping[str, float] = field(default_factory=dict)

    @property
    def equation(self) -> str:
        """The equation with the values of its parameters, in Markdown."""
        rows = [f"    heat = {self.heat}          in W", ""]
        for name, (value, unit) in self.parameters.items():
            rows.append(f"- `{name}` = {value:.6g}{'' if unit == '1' else f' {unit}'}")
        return "\n".join(rows)


def heat_term(term: HeatTerm) -> Component:
    """Declare the component of a term.

    InputError if its law is no expression, or a name in it is one of the component's own or stands for two
    things.
    """
    law = HeatLaw(term.heat, f"{term.name}.heat")
    names = {name: identifier(name) for name in law.variables}
    for name in law.variables:
        if names[name] in RESERVED or [*names.values()].count(names[name]) > 1:
            raise InputError(f"{term.name}.heat: the name {name} is taken; rename it")
        if name not in term.parameters and name not in term.inputs:
            raise InputError(f"{term.name}.heat: {name} is neither a variable nor a parameter of the term")
    used = tuple(name for name in term.inputs if name in names)
    return Component(
        name=term.name,
        description="Heat by an equation, added to the heat that flows into a place already",
        inputs=(
            Input("to_heat_flow", "W", "heat flow into the place without this term", nominal=5),
            *(_input(names[name], term.inputs[name], name, term.starts.get(name)) for name in used),
        ),
        parameters=tuple(
            Parameter(
                identifier(name), unit, value, f"{name} in heat = {term.heat}", nominal=abs(value) or 1.0
            )
            for name, (value, unit) in term.parameters.items()
        ),
        states=(State("lagged", "1", size=law.lag_count),) if law.lag_count else (),
        outputs=(
            Output("heat", "W", f"heat = {term.heat}", nominal=5),
            Output("total_to_heat_flow", "W", "heat flow into the place with this term", nominal=5),
        ),
        rates=partial(rates, law=law, names=names) if law.lag_count else None,
        observe=partial(outputs, law=law, names=names),
    )


def rates(x: Record, u: Record, p: Record, time: Number, law: HeatLaw, names: Mapping[str, str]) -> Values:
    """Time derivative of each lag in its unit per s."""
    return {"lagged": stack(*law.lag_rates(lambda name: _of(u, p, names[name]), x.lagged, time))}


def outputs(x: Record, u: Record, p: Record, time: Number, law: HeatLaw, names: Mapping[str, str]) -> Values:
    """Heat flows in W."""
    lagged = x.lagged if law.lag_count else ()
    heat = 0.0 * u.to_heat_flow + law.heat(lambda name: _of(u, p, names[name]), lagged, time)
    return {"heat": heat, "total_to_heat_flow": u.to_heat_flow + heat}


def is_term(component: Component) -> bool:
    """Whether a component is a term."""
    return getattr(component.observe, "func", None) is outputs


def stored(term: HeatTerm) -> bytes:
    """Content of the file `STORED`."""
    return json.dumps(asdict(term)).encode()


def read_stored(content: bytes) -> HeatTerm:
    """Term in the content of the file `STORED`; KeyError, TypeError or ValueError if it holds none."""
    held = json.loads(content)
    parameters = {name: (float(value), str(unit)) for name, (value, unit) in held["parameters"].items()}
    starts = {name: float(value) for name, value in held.get("starts", {}).items()}
    return HeatTerm(str(held["name"]), str(held["heat"]), dict(held["inputs"]), parameters, starts)


def _of(u: Record, p: Record, name: str) -> Number:
    return getattr(u, name) if hasattr(u, name) else getattr(p, name)


def _input(name: str, unit: str, called: str, start: float | None) -> Input:
    told = f"{called} in the equation"
    found = Input(name, unit, told, nominal=_NOMINAL.get(unit, 1.0))
    found = temperature_input(name, told) if unit == "K" else found
    return found if start is None else replace(found, start=start)
