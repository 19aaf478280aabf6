"""Signals as linear functions of others, now and in the steps before: lags, ARX models, regressions.

x[k+1] = sum over i of ahead_i x[k-i] + driven f + constant     f: means of the features over the step
y      = shown x + direct f + offset                            f: the features now

Within a step x goes in a straight line to where the features so far take it. Features are the inputs, then
sizes of products of two of them. L. Ljung, System Identification, 2nd edition (1999), section 4.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total, truth, where

Array = NDArray[np.float64]

_EARLY = 1e-9
"""Share of a step by which rounding may put its end too early."""


@dataclass(frozen=True, eq=False)
class LinearForm:
    """How one output follows from features and from its own past, in SI.

    Attributes
    ----------
    step : s of a step; of no effect without a past
    ahead : weights of the states of so many steps before, shape (order, n, n)
    driven : of the features' means, shape (n, features)
    constant : added in each step, shape (n,)
    start : states at the start, shape (n,)
    shown : weights of the states in the output, shape (n,)
    direct : of the features now, shape (features,)
    offset : added to the output
    error : root mean square error that was found on rows that were held out
    """

    step: float
    ahead: Array
    driven: Array
    constant: Array
    start: Array
    shown: Array
    direct: Array
    offset: float
    error: float

    @property
    def order(self) -> int:
        """Number of past steps that count."""
        return len(self.ahead)

    def next(self, past: Number, mean: Number) -> Number:
        """States a step later, from those of the steps before, the last one first, and the features' mean."""
        n = len(self.constant)
        told = [ahead @ past[i * n : (i + 1) * n] for i, ahead in enumerate(self.ahead)]
        return sum(told, self.driven @ mean + self.constant)


@dataclass(frozen=True, eq=False)
class Forms:
    """Every output's form by its name, and what their features are made of.

    Attributes
    ----------
    forms : by output
    inputs : names of the inputs
    products : pairs of inputs whose product's size is a feature
    low, high : range of each feature in what was fitted, shape (features,)
    """

    forms: Mapping[str, LinearForm]
    inputs: tuple[str, ...]
    products: tuple[tuple[str, str], ...]
    low: Array
    high: Array

    @property
    def remembering(self) -> dict[str, LinearForm]:
        """Forms that have a past."""
        return {name: form for name, form in self.forms.items() if form.order}

    def features(self, u: Record) -> Number:
        """Inputs and products' sizes, shape (features,)."""
        values = {name: getattr(u, name) for name in self.inputs}
        pairs = (absolute(values[one] * values[other]) for one, other in self.products)
        return stack(*values.values(), *pairs)


def past_of(name: str) -> str:
    """Name of the states that are an output's past."""
    return f"past_{name}"


def begin(u: Record, p: Record, model: Forms) -> Values:
    """States at the start, as if it had been so before."""
    now = model.features(u)
    states: dict[str, Number] = {"held": now}
    for name, form in model.remembering.items():
        start = getattr(p, f"start_{name}")
        states |= {past_of(name): stack(*[start] * form.order), f"sum_{name}": 0.0 * now}
        states[f"elapsed_{name}"] = 0.0
    return states


def update(x: Record, u: Record, p: Record, time: Number, step: Number, model: Forms) -> Values:
    """States after a sample, during which the inputs were as at the last one."""
    states: dict[str, Number] = {"held": model.features(u)}
    for name, form in model.remembering.items():
        past, elapsed = getattr(x, past_of(name)), getattr(x, f"elapsed_{name}") + step
        gathered = getattr(x, f"sum_{name}") + x.held * step
        due = truth(elapsed >= form.step * (1 - _EARLY))
        over = maximum(elapsed - form.step, 0.0)
        later = form.next(past, (gathered - x.held * over) / form.step)
        n = len(form.constant)
        states[past_of(name)] = where(due > 0, _first(later, past, n, form.order), past)
        states[f"sum_{name}"] = where(due > 0, x.held * over, gathered)
        states[f"elapsed_{name}"] = where(due > 0, over, elapsed)
    return states


def _first(later: Number, past: Number, n: int, order: int) -> Number:
    """The past with new states before it, without the oldest."""
    return stack(later, past[: n * (order - 1)]) if order > 1 else later


def outputs(x: Record, u: Record, p: Record, time: Number, model: Forms) -> Values:
    """Each output, its spread, and how far the features are outside what was fitted, as a share of that."""
    now = model.features(u)
    width = np.where(model.high > model.low, model.high - model.low, np.inf)
    beyond = (maximum(now - model.high, 0.0) + maximum(model.low - now, 0.0)) / width
    told: dict[str, Number] = {"outside": total(beyond)}
    for name, form in model.forms.items():
        value = total(form.direct * now) + form.offset
        if form.order:
            value = value + total(form.shown * _now(x, name, form))
        told |= {name: value, f"{name}_spread": form.error * (1.0 + told["outside"])}
    return told


def _now(x: Record, name: str, form: LinearForm) -> Number:
    """States within a step."""
    past, elapsed = getattr(x, past_of(name)), getattr(x, f"elapsed_{name}")
    last = past[: len(form.constant)]
    mean = where(elapsed > 0, getattr(x, f"sum_{name}") / maximum(elapsed, 1e-9), x.held)
    return last + (form.next(past, mean) - last) * (elapsed / form.step)


def features_of(inputs: Sequence[str], products: Sequence[tuple[str, str]]) -> list[tuple[str, ...]]:
    """Features in their order, each as the names of the inputs that it is made of."""
    return [*((name,) for name in inputs), *products]
