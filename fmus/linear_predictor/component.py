"""A plain fit as a component, with inputs and outputs as it was fitted to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from warmlink.fmus.component import Check, Component, Input, Output, Parameter, State
from warmlink.fmus.component.quantities import sample_time_parameter
from warmlink.fmus.component.variables import NOMINAL_TEMPERATURE
from warmlink.fmus.linear_predictor import equations
from warmlink.fmus.linear_predictor.equations import Forms, past_of

_SHOWN: Mapping[str, dict[str, Any]] = {
    "K": {"display": "degC", "nominal": NOMINAL_TEMPERATURE},
    "m": {"display": "um", "nominal": 5e-5},
}
"""How a quantity is read, by its unit."""

_SPREADS: Mapping[str, dict[str, Any]] = {"K": {"nominal": 0.1}, "m": {"display": "um", "nominal": 1e-6}}


def linear_predictor(name: str, description: str, model: Forms, units: Mapping[str, str]) -> Component:
    """Declare the component of plain fits.

    Parameters
    ----------
    name : name of the component, an identifier of C
    description : one line
    model : forms whose inputs and outputs have identifiers of C as names
    units : SI unit of each input and output by its name
    """
    remembering = model.remembering
    shortest = min((form.step for form in remembering.values()), default=1.0)
    sampled = sample_time_parameter("time between two looks at the inputs")
    return Component(
        name=name,
        description=description,
        inputs=tuple(_input(each, units[each]) for each in model.inputs),
        parameters=(
            *((sampled,) if remembering else ()),
            *(
                Parameter(
                    f"start_{each}",
                    "1",
                    0,
                    "states at the start, in SI: readings, less the surroundings where rises were fitted",
                    size=form.start.size,
                    starts=tuple(form.start.tolist()),
                )
                for each, form in remembering.items()
            ),
        ),
        states=tuple(_states(model)) if remembering else (),
        outputs=tuple(_outputs(model, units)),
        update=partial(equations.update, model=model) if remembering else None,
        begin=partial(equations.begin, model=model) if remembering else None,
        observe=partial(equations.outputs, model=model),
        checks=(
            Check(
                lambda p: shortest - p.sample_time,
                f"sample_time: {{sample_time}} s is longer than a step of {shortest:.6g} s; make it shorter",
            ),
        )
        if remembering
        else (),
    )


def _input(name: str, unit: str) -> Input:
    start = NOMINAL_TEMPERATURE if unit == "K" else 0.0
    return Input(name, unit, "what the fit goes by", start=start, **_SHOWN.get(unit, {}))


def _states(model: Forms) -> Sequence[State]:
    width = len(model.inputs) + len(model.products)
    states = [State("held", "1", size=width)]
    for name, form in model.remembering.items():
        states += [
            State(past_of(name), "1", size=form.order * form.start.size),
            State(f"sum_{name}", "1", size=width),
            State(f"elapsed_{name}", "s"),
        ]
    return states


def _outputs(model: Forms, units: Mapping[str, str]) -> Sequence[Output]:
    outside = "how far the inputs are outside what was fitted, as a share of its range; 0: inside"
    found = [Output("outside", "1", outside, nominal=1)]
    for name in model.forms:
        unit = units[name]
        found += [
            Output(name, unit, "what the fit says", **_SHOWN.get(unit, {})),
            Output(f"{name}_spread", unit, "1 sigma of it, by what was held out", **_SPREADS.get(unit, {})),
        ]
    return found
