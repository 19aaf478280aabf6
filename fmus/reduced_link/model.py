"""What a reduced link is made of: the numbers that finite elements and their reduction give."""

import json
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.records import dataclass

Array = NDArray[np.float64]

STORED = "resources/reduced_link.json"
"""File in a reduced link's FMU that holds its model."""


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A body's heat and growth by n patterns of temperature, for the material in its parameters.

    The temperature is the initial one plus the patterns times their amplitudes z [K]:

        V c dz/dt = -(k conduction + sum of h_g cooling_g) z + loads (Q, Q_tip, f_1, ...)

    with c the heat capacity of a unit volume [J/(m3.K)], k the conductivity, h_g the convection coefficient
    of the surface g and f_g the heat flux into it. G surfaces are cooled. The mean over the volume V of the
    product of two patterns is 1 for equal ones and 0 for others; the first is 1 everywhere.

    Attributes
    ----------
    material : nominal `conductivity`, `density`, `specific_heat` and `expansion_coefficient` in SI units
    volume : of the body [m3]
    conduction : of each pattern, shape (n,) [m]
    cooling : shape (G, n, n) [m2]
    loads : of 1 W at base and tip, which also give the mean temperatures there, and of 1 W/m2 on each
        surface, shape (n, 2 + G)
    outputs : displacement [m] and rotation [rad] of the tool for an expansion coefficient of 1, and the
        temperatures of the sensors, shape (3 + 3 + 8, n)
    reach : from the middle of the heated face to the tool point, shape (3,) [m]
    initial : amplitudes for a rise of 1 K at each sensor, shape (n, 8)
    error_gain : largest error of displacement [m], rotation [rad] and temperature [K], times the
        conductivity, for each load, and for each change of a surface's convection by 1 W/(m2.K) where an end
        is 1 K from its surroundings, shape (3, 2 + 2 G); an expansion coefficient of 1 for the first two
    discretisation : error of the elongation due to the mesh, as a share of it
    conductivity_range, convection_range : for which `error_gain` was computed, in SI units
    """

    material: dict[str, float]
    volume: float
    conduction: Array
    cooling: Array
    loads: Array
    outputs: Array
    reach: Array
    initial: Array
    error_gain: Array
    discretisation: float
    conductivity_range: tuple[float, float]
    convection_range: tuple[float, float]

    @property
    def order(self) -> int:
        """Number of patterns."""
        return len(self.conduction)

    @property
    def area(self) -> Array:
        """Area of each cooled surface, shape (G,) [m2]."""
        return self.loads[0, 2:]


def stored(model: ReducedModel) -> bytes:
    """Content of the file `STORED`."""
    return json.dumps(asdict(model), default=lambda array: array.tolist()).encode()


def read_stored(content: bytes) -> ReducedModel:
    """Model in the content of the file `STORED`."""
    held: dict[str, Any] = json.loads(content)
    for name, value in held.items():
        if isinstance(value, list):
            held[name] = tuple(value) if name.endswith("_range") else np.array(value)
    return ReducedModel(**held)
