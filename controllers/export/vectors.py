"""What a law says to inputs that try it: duty, readings that come and go, and such as none should be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError

SAMPLES = 240
"""Samples of the test vectors."""

WILD = (math.nan, 1e20, 400.0)
"""What each input is for a sample, one after the other, in the later part of the vectors."""


@dataclass(frozen=True)
class Vectors:
    """Inputs and outputs of a law from a cold start, by its Python form; the first row is the start.

    Attributes
    ----------
    inputs, outputs : shapes (SAMPLES + 1, u.size) and (SAMPLES + 1, y.size)
    wild : whether readings are missing among the inputs, and such as none should be
    """

    inputs: NDArray[np.float64]
    outputs: NDArray[np.float64]
    wild: bool


def vectors(component: Component, period: float) -> Vectors:
    """Test vectors of a law, `period` in s; without wild inputs where those leave it without a number.

    Raises InputError if it has none with any.
    """
    for wild in (True, False):
        given = np.array(list(_inputs(component, period, wild)))
        try:
            return Vectors(given, said(component, given, period), wild)
        except InputError:
            if not wild:
                raise
    raise AssertionError


def said(component: Component, inputs: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Outputs of a law by its Python form, shape (n, y.size), for inputs (n, u.size) a period in s apart."""
    instance, taken = Instance(component), []
    for sample, row in enumerate(inputs):
        instance.set(dict(zip(component.u.names, map(float, row), strict=True)))
        if sample == 0:
            instance.initialize()
        else:
            instance.step((sample - 1) * period, period)
        taken.append(np.array(instance.outputs()))
    return np.array(taken)


def _inputs(component: Component, period: float, wild: bool) -> Iterator[list[float]]:
    """A motor that starts and stops in a room that warms up, readings missing for a while if wild."""
    _, start = component.start_values()
    places = [name for name in component.u.names if name != "drift_valid"]
    for sample in range(SAMPLES + 1):
        row = dict(zip(component.u.names, start.tolist(), strict=True))
        warm = 6.0 * (1.0 - math.exp(-sample / 60.0))
        for place, name in enumerate(name for name in row if name.endswith("_temperature")):
            row[name] = 295.15 + warm / (1 + place) + 0.05 * math.sin(1.7 * sample + place)
        row["ambient_temperature"] = 295.15 + sample * period / 3600.0
        row["speed"], row["torque"] = (3.0, 2.5) if sample % 60 < 40 else (0.0, 0.0)
        if wild and 50 <= sample < 70:
            row["tip_temperature"] = math.nan
        if sample >= 60:
            row["drift_valid"], row["measured_drift"] = 1.0, 1e-6 * math.sin(sample // 30)
        late = sample - 130
        if wild and late >= 0 and late % 3 == 0:
            row[places[late // 3 % len(places)]] = WILD[late // 3 // len(places) % len(WILD)]
        yield list(row.values())
