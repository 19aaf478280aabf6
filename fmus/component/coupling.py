"""Which continuous states act on whose rates: where the Jacobian of a component may differ from zero.

It must not depend on when it is looked for, or a state that is restored in another instance would go on
otherwise. So it is found at points of its own, in which what is off at the start is on.
"""

from contextlib import suppress
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Component, Scalar
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.integrator import ComplexStepJacobian
from warmlink.fmus.component.limits import ordinary_size

POINTS = 4
"""Points that are looked at; the first one is the start, and choices take one value after another."""

_GOLDEN = (np.sqrt(5.0) - 1) / 2
"""Whose multiples lie evenly between 0 and 1 once their whole parts are taken off, and are never alike."""


@lru_cache(maxsize=64)
def coupling(component: Component) -> NDArray[np.bool_]:
    """Whether the rate of each continuous state (rows) depends on each of them (columns), shape (n, n).

    A state always counts for its own rate.
    """
    size = component.continuous.size
    jacobian, found = ComplexStepJacobian(np.ones((size, size), dtype=bool)), np.eye(size, dtype=bool)
    given = [scalar for scalar in component.scalars() if scalar.start is not None]
    for point in range(POINTS):
        shares = (point * _GOLDEN * np.arange(1, len(given) + 1)) % 1.0
        values = np.array([_value(*each, point) for each in zip(given, shares, strict=True)])
        u, time = values[component.p.size :], point / POINTS * component.default_stop_time
        # Equations may refuse a point where no run comes; where one does, its step says so.
        with np.errstate(all="ignore"), suppress(Exception):
            settled = component.settled(values[: component.p.size])
            x = np.asarray(component.states_at_start(u, settled, time), dtype=float)
            x = x + (point * _GOLDEN * np.arange(1, x.size + 1)) % 1.0
            rates = partial(_rates, component=component, held=x[size:], u=u, settled=settled, time=time)
            found |= jacobian(rates, x[:size]) != 0
    return found


def _rates(x: Number, component: Component, held: Number, u: Number, settled: Number, time: float) -> Number:
    return component.rates_of(stack(x, held), u, settled, time)


def _value(scalar: Scalar, share: float, point: int) -> float:
    """Value of a parameter or input that lies a share of its ordinary size above its start."""
    variable, start = scalar.variable, float(scalar.start or 0.0)
    low = -np.inf if variable.minimum is None else variable.minimum
    high = np.inf if variable.maximum is None else variable.maximum
    if variable.type != "Real":
        return float(np.clip(start + point, low, high))
    return float(np.clip(start + share * ordinary_size(variable), low, high))
