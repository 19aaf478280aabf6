"""Several axes in a chain as one linear model, from the reduced plant of each.

Between the tip of one link and the shaft of the next motor heat passes by a conductance. The reduction keeps
a plant symmetric, so a temperature that a reduced plant gives is a place where heat may enter it: the column
of heat in W at a place is the row of its temperature over the plant's whole heat capacity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.plant import INPUTS, OUTPUTS, Plant, plant_model
from warmlink.controllers.design.reduction import ReducedPlant, reduce_plant

Array = NDArray[np.float64]

NEIGHBOUR = "neighbour_conductance"
"""Parameter of the motor that couples it to the link before it."""


@dataclass(frozen=True)
class Chain:
    """Reduced plants of the axes, from the base outwards, and how they are coupled.

        dz/dt = A(speeds) z + sum over axes of B u,    y = C z

    with z the modes of all axes one after another, in K above `temperature`.

    Attributes
    ----------
    axes : reduced plant of each axis
    heat_capacity : of each axis in J/K
    conductance : from each axis's shaft to the tip of the link before it in W/K; the first one is not used
    """

    axes: tuple[ReducedPlant, ...]
    heat_capacity: tuple[float, ...]
    conductance: tuple[float, ...]

    @property
    def order(self) -> int:
        """Number of modes of all axes."""
        return sum(axis.order for axis in self.axes)

    @property
    def temperature(self) -> float:
        """Temperature in K from which the modes count."""
        return self.axes[0].temperature

    def place(self, axis: int) -> slice:
        """Where the modes of an axis, counted from 0, lie."""
        start = sum(each.order for each in self.axes[:axis])
        return slice(start, start + self.axes[axis].order)

    def row(self, axis: int, output: str) -> Array:
        """Derivative of an output of an axis by all modes, shape (order,)."""
        row = np.zeros(self.order)
        row[self.place(axis)] = self.axes[axis].C[OUTPUTS.index(output)]
        return row

    def column(self, axis: int, output: str) -> Array:
        """What heat in W where an output temperature is taken does to the modes, in K/J, shape (order,)."""
        return self.row(axis, output) / self.heat_capacity[axis]

    def state_matrix(self, speeds: Sequence[float]) -> Array:
        """State matrix in 1/s at the speeds of the joints in rad/s, shape (order, order)."""
        blocks = [
            np.diag(axis.rate) + abs(speed) * axis.M for axis, speed in zip(self.axes, speeds, strict=True)
        ]
        matrix: Array = linalg.block_diag(*blocks)
        for i in range(1, len(self.axes)):
            difference = self.row(i, "shaft_temperature") - self.row(i - 1, "tip_temperature")
            into = self.column(i - 1, "tip_temperature") - self.column(i, "shaft_temperature")
            matrix += self.conductance[i] * np.outer(into, difference)
        return matrix

    def input_matrix(self, speeds: Sequence[float], name: str) -> Array:
        """Columns in 1/s or K/J of one of the plant's inputs, one an axis, shape (order, axes)."""
        which = INPUTS.index(name)
        columns = [
            axis.B[:, which] + abs(speed) * axis.B_speed[:, which]
            for axis, speed in zip(self.axes, speeds, strict=True)
        ]
        return np.asarray(linalg.block_diag(*(column[:, None] for column in columns)))


def chain_model(plants: Sequence[Plant], order: int) -> Chain:
    """Chain of so many modes an axis.

    Parameters
    ----------
    plants : parameters of motor and link of each axis, from the base outwards; `neighbour_conductance` among
        those of the motor couples it to the link before it
    order : modes of each axis

    Raises
    ------
    InputError
        A parameter is unknown or out of range.
    """
    reduced, capacities, conductances = [], [], []
    for plant in plants:
        motor = dict(plant.motor)
        conductances.append(float(motor.pop(NEIGHBOUR, 0.0)))
        full = plant_model(Plant(motor, plant.link))
        reduced.append(reduce_plant(full, order))
        capacities.append(float(full.heat_capacity.sum()))
    return Chain(tuple(reduced), tuple(capacities), tuple(conductances))
