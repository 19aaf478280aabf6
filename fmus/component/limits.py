"""What a component's parameters and inputs may be, and the sentence for what they may not."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import FIELD, Component, Input, Parameter, Scalar
from warmlink.fmus.component.variables import Variable
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead

BOUND_TOLERANCE = 1e-9
"""Share of its ordinary size by which an input may miss a bound, as sums and means of hosts do."""


def problems(component: Component, instance: str, values: Sequence[float]) -> list[str]:
    """Sentences on flat parameters in SI units, shape (component.p.size,), that are out of range.

    The name of the instance, where there is one, is put before the variable's.
    """
    scalars = component.scalars()[: component.p.size]
    each = (problem(scalar, value) for scalar, value in zip(scalars, values, strict=True))
    sentences = [sentence for sentence in each if sentence is not None]
    if not sentences:
        record, index = component.p.read(np.asarray(values)), component.p.index
        # Nine digits, as a native FMU writes them (`report_check`).
        sentences = [
            FIELD.sub(lambda field: f"{values[index[field[1]]]:.9g}", check.sentence)
            for check in component.checks
            if not check.margin(record) >= 0
        ]
    return [f"{instance}.{sentence}".lstrip(".") for sentence in sentences]


def refuse_problems(component: Component, instance: str, values: Sequence[float]) -> None:
    """Raise InputError with the first of the `problems` of flat parameters, where there is one."""
    for sentence in problems(component, instance, values):
        raise InputError(sentence)


def checked(
    component: Component, instance: str, given: Mapping[str, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Flat parameters and inputs in SI units, at their start values but for those given by name.

    InputError: a name is unknown, or a parameter out of range.
    """
    for name in given:
        if name not in component.p.index and name not in component.u.index:
            raise InputError(unknown(component, instance, name))
    p, u = component.start_values(given)
    refuse_problems(component, instance, p.tolist())
    return p, u


def unknown(component: Component, instance: str, name: str) -> str:
    """Sentence on a name that is no variable of a component's."""
    part, dot, rest = name.rpartition(".")
    if component.joint is not None and part in component.joint.parts:
        return unknown(component.joint.parts[part], f"{instance}{dot}{part}".lstrip("."), rest)
    known = [variable.name for variable in (*component.parameters, *component.inputs)]
    return f"{instance}.{name}: {component.name} has no such variable; {instead(name, known)}".lstrip(".")


def problem(scalar: Scalar, value: float) -> str | None:
    """Sentence on one value out of its range, None where it is well."""
    refusal = _refusal(scalar.variable, value, _unit(scalar))
    # Few values are refused, and writing one shortest takes longer than looking at it.
    return None if refusal is None else f"{scalar.name}: {_shown(value)}{_unit(scalar)} {refusal}"


def _refusal(variable: Variable, value: float, unit: str) -> str | None:
    if math.isnan(value):
        accepted = isinstance(variable, Input) and variable.accepts_nan
        return None if accepted else "is not a number; give a value"
    if math.isinf(value):
        return "is not finite; give a finite value"
    if isinstance(variable, Parameter) and variable.positive and value <= 0:
        return f"is not positive; give a value above 0{unit}"
    if variable.minimum is not None and value < variable.minimum:
        return f"is too low; give at least {_shown(variable.minimum)}{unit}"
    if variable.maximum is not None and value > variable.maximum:
        return f"is too high; give at most {_shown(variable.maximum)}{unit}"
    if variable.type != "Real" and value != round(value):
        return "is not a whole number; give one"
    return None


def clamped(scalar: Scalar, value: float) -> float:
    """Give the bound that a value misses by a rounding error only, and any other value as it is."""
    variable = scalar.variable
    low = -math.inf if variable.minimum is None else variable.minimum
    bound = max(low, min(value, math.inf if variable.maximum is None else variable.maximum))
    return bound if abs(value - bound) <= BOUND_TOLERANCE * ordinary_size(variable) else value


def taken_for(scalar: Scalar, value: float) -> str:
    """Sentence on a value that was clamped."""
    unit = _unit(scalar)
    bound = _shown(clamped(scalar, value))
    return f"{scalar.name}: {_shown(value)}{unit} is taken for {bound}{unit}, here and from now on"


def ordinary_size(variable: Variable) -> float:
    """Size of an ordinary value: the nominal one, or the larger bound, or 1."""
    return variable.nominal or max(abs(variable.minimum or 0.0), abs(variable.maximum or 0.0)) or 1.0


def wild_state(component: Component, states: Sequence[float]) -> str | None:
    """Name of the first of the flat states that is not finite, nor NaN where that is allowed; else None."""
    if all(map(math.isfinite, states)):
        return None
    missing = [state.accepts_nan for state in component.states for _ in range(state.count)]
    every = zip(component.x.names, states, missing, strict=True)
    wild = (n for n, v, nan in every if not (math.isfinite(v) or (nan and math.isnan(v))))
    return next(wild, None)


def _shown(value: float) -> str:
    """A number with six digits, or as many more as tell it from every other, as a native FMU writes it."""
    return next((text for n in range(6, 17) if float(text := f"{value:.{n}g}") == value), f"{value:.17g}")


def _unit(scalar: Scalar) -> str:
    return "" if scalar.variable.unit == "1" else f" {scalar.variable.unit}"
