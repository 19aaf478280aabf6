"""Reduction of the plant to a few modes, with the error computed.

The plant is a network of heat capacities and conductances, so in coordinates weighted by the square root of
the capacities its state matrix is symmetric at every speed. Taking every input and output for a port of both
kinds makes the system state-space symmetric; its two Gramians are then one, and balanced truncation is an
orthogonal projection on that Gramian's leading eigenvectors: it keeps the network's symmetry and stability
at *every* speed, and has the bound of twice the sum of what was cut (W. Q. Liu, V. Sreeram and K. L. Teo,
"Model reduction for state-space symmetric systems", Systems & Control Letters 34 (1998) 209-215; the bound
is K. Glover's, Int. J. Control 39 (1984) 1115-1193).

The ports are smoothed over half a minute first (frequency-weighted balancing): what passes within seconds
moves no tool point, and modes are better spent on what lasts.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.plant import INPUTS, OUTPUTS, LinearBySpeed, LinearPlant
from warmlink.fmus.errors import InputError

Array = NDArray[np.float64]

SIZES: Mapping[str, float] = {
    "winding_heat": 20.0,
    "shaft_heat": 20.0,
    "link_heat": 5.0,
    "ambient_temperature": 5.0,
}
"""Ordinary sizes of the inputs, in W and K, by which errors are judged."""

PRECISIONS: Mapping[str, float] = dict.fromkeys(OUTPUTS[:-1], 0.1) | {"elongation": 1e-7}
"""Errors of the outputs, in K and m, that count alike."""

BALANCING_SPEED = 2.0
"""rad/s at which the Gramian is taken, between still and fast."""

SMOOTHING = 30.0
"""s over which the ports are smoothed before balancing."""

CHECKED_SPEEDS = (0.0, 1.0, 3.43, 6.0)
"""rad/s at which the error is computed."""

TIMES = tuple(np.logspace(0, 5.5, 45).tolist())
"""s after a step at which the error is computed."""


@dataclass(frozen=True)
class ReductionError:
    """What the reduction costs an input of ordinary size (`SIZES`).

    Attributes
    ----------
    elongation_step : largest error in m of the elongation after a step of an input
    temperature_step : the same for the temperatures, in K
    """

    elongation_step: float
    temperature_step: float


@dataclass(frozen=True)
class ReducedPlant(LinearBySpeed):
    """The plant in the coordinates of its modes at standstill, so that A is diagonal.

    Attributes
    ----------
    link_loss, link_loss_per_speed : conductance from the link to the surroundings, W/K and W.s/(K.rad)
    error : what was lost
    """

    elongation_per_kelvin: float
    link_loss: float
    link_loss_per_speed: float
    error: ReductionError

    @property
    def rate(self) -> Array:
        """Rate of each mode in 1/s, all negative, slowest first, shape (r,)."""
        return np.diagonal(self.A)

    @property
    def order(self) -> int:
        """Number of modes."""
        return self.rate.size


@dataclass(frozen=True)
class Balanced:
    """The plant at the balancing speed in coordinates in which it is symmetric, with smoothed ports.

    Attributes
    ----------
    state : state matrix, symmetric, shape (n, n)
    ports : inputs and, transposed, outputs, each in ordinary sizes and smoothed, shape (n, 10)
    hankel : Hankel singular values, largest first, shape (n,)
    vectors : the Gramian's eigenvectors, each in a column, in the same order
    """

    state: Array
    ports: Array
    hankel: Array
    vectors: Array


def balanced(plant: LinearPlant) -> Balanced:
    """Balanced form of the plant at `BALANCING_SPEED`.

    Raises
    ------
    InputError
        The plant is not symmetric.
    """
    root = np.sqrt(plant.heat_capacity)
    A, B = plant.at(BALANCING_SPEED)
    state = root[:, None] * A / root
    if np.abs(state - state.T).max() > 1e-9 * np.abs(state).max():
        raise InputError(
            "the plant's heat network is not symmetric at the temperature given; linearise where all "
            "temperatures are equal, and let a HeatPath take out what it brings in, or design a regression"
        )
    state = (state + state.T) / 2
    scaled_in = root[:, None] * B * [SIZES[name] for name in INPUTS]
    scaled_out = plant.C / root / np.array([PRECISIONS[name] for name in OUTPUTS])[:, None]
    # A port of both kinds for each input and output; relative weight such that both reach alike.
    balance = np.sqrt(linalg.norm(scaled_out, 2) / linalg.norm(scaled_in, 2))
    ports = np.column_stack([balance * scaled_in, scaled_out.T / balance])
    ports = np.linalg.solve(np.eye(root.size) - SMOOTHING * state, ports)
    gramian = linalg.solve_continuous_lyapunov(state, -ports @ ports.T)
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return Balanced(state, ports, np.maximum(values[::-1], 0.0), vectors[:, ::-1])


def reduce_plant(plant: LinearPlant, order: int) -> ReducedPlant:
    """Balanced truncation that keeps the plant symmetric.

    Raises
    ------
    InputError
        The order is not between 1 and the plant's.
    """
    full = plant.heat_capacity.size
    if not 1 <= order <= full:
        raise InputError(f"order: {order} is not possible; the plant has {full} states, give 1 to {full}")
    form = balanced(plant)
    basis, root = form.vectors[:, :order], np.sqrt(plant.heat_capacity)
    still = root[:, None] * plant.A / root
    rate, modes = np.linalg.eigh(basis.T @ ((still + still.T) / 2) @ basis)
    slowest_first = np.argsort(-rate)
    rate, modes = rate[slowest_first], modes[:, slowest_first]
    # In the modes' coordinates one unit is a temperature profile: T = into z, z = back T.
    into = (basis @ modes) / root[:, None] * np.sqrt(plant.heat_capacity.sum())
    back = (basis @ modes).T * root / np.sqrt(plant.heat_capacity.sum())
    sign = np.where((plant.C @ into)[OUTPUTS.index("elongation")] < 0, -1.0, 1.0)
    into, back = into * sign, back * sign[:, None]
    reduced = ReducedPlant(
        A=np.diag(rate),
        A_speed=back @ plant.A_speed @ into,
        B=back @ plant.B,
        B_speed=back @ plant.B_speed,
        C=plant.C @ into,
        elongation_per_kelvin=plant.elongation_per_kelvin,
        link_loss=plant.link_loss(plant.B),
        link_loss_per_speed=plant.link_loss(plant.B_speed),
        error=ReductionError(np.nan, np.nan),
    )
    reduced = replace(reduced, C=fitted_rows(plant, reduced))
    return replace(reduced, error=reduction_error(plant, reduced))


def fitted_rows(plant: LinearPlant, reduced: ReducedPlant) -> Array:
    """Rows of the outputs by which the modes follow the plant's step responses best, shape (6, r).

    What truncation leaves out is an error that lasts: in a chain of links a tenth of a kelvin, by which
    thermometers contradict each other.
    """
    sizes = np.array([SIZES[name] for name in INPUTS])
    modes: list[Array] = []
    seen: list[Array] = []
    for speed in CHECKED_SPEEDS:
        for model, out, found in ((plant, plant.C, seen), (reduced, np.eye(reduced.order), modes)):
            state, into = model.at(speed)
            values, vectors = np.linalg.eig(state)
            gains = np.linalg.solve(vectors, into * sizes)
            for time in TIMES:
                found.append(np.real((out @ vectors * (np.expm1(values * time) / values)) @ gains))
    z, y = np.hstack(modes).T, np.hstack(seen).T
    return np.asarray(np.linalg.lstsq(z, y, rcond=None)[0].T)


def reduction_error(plant: LinearPlant, reduced: ReducedPlant) -> ReductionError:
    """Compare step responses of the reduced plant with those of the full one at several speeds."""
    sizes = np.array([SIZES[name] for name in INPUTS])
    steps = np.zeros(len(OUTPUTS))
    for speed in CHECKED_SPEEDS:
        parts = []
        for model in (plant, reduced):
            state, into = model.at(speed)
            values, vectors = np.linalg.eig(state)
            parts.append((values, np.linalg.solve(vectors, into * sizes), model.C @ vectors))
        for time in TIMES:
            full, small = ((out * (np.expm1(v * time) / v)) @ into for v, into, out in parts)
            steps = np.maximum(steps, np.abs(np.real(full - small)).max(axis=1))
    return ReductionError(float(steps[-1]), float(steps[:-1].max()))
