"""As few patterns as keep to a tolerance: those that heat inputs reach most, at the worst parameters.

The patterns are orthogonal, and conduction and cooling symmetric, so that the reduced model is stable for all
parameters (Galerkin projection: A. C. Antoulas, *Approximation of Large-Scale Dynamical Systems*, SIAM 2005).

The error of an output due to an input that is held over each second and stays below a peak is at most the
peak times the integral over time of the error's absolute impulse response (the norm that peaks induce: S.
Boyd and J. Doyle, Systems & Control Letters 9 (1987) 1-6), here taken from step responses at 1 s and at
growing times. It is computed between the reduced model and the part's own span, at sampled parameters. In
time scaled by heat capacity over conductivity it depends on ratios alone, and on 1 / conductivity.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.stats.qmc import LatinHypercube

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.elements import Heat
from warmlink.orchestration.reduction.subspace import Range

SAFETY = 1.5
"""Factor on errors found at sampled parameters, which are not all that there are."""

SAMPLES = 32
"""Parameters at which the error is computed, beside the corners of the range."""

TIP_HEAT_FLOW, AMBIENT_CHANGE = 5.0, 15.0
"""W and K, peaks; from the second follow the surface's heat flux, by the convection, and that which a change
of convection brings to a warm part."""

CARRIED = 0.5
"""Largest heat capacity of hub and tip, as a share of the part's."""

LOST = 1.0
"""W/K, largest conductance from hub and tip at the nominal conductivity."""

LARGEST_STEP = 1e6
"""s, up to which step responses are followed."""

SMOOTHING = 10.0
"""s over which inputs are smoothed before patterns are chosen: what passes sooner moves no tool point."""

WARMING = (0.0, 1e-4, 1e-3, 1e-2)
"""1/s, inverse times for which a part has been heated when its convection changes."""

SMALLEST_ORDER, LARGEST_ORDER, ORDER_STEP = 6, 60, 2

TRIED = 5
"""Bases that are tried where the order is given."""

Setting = tuple[Array, Array]
"""What conducts and cools, over the conductivity, and what stores, over the heat capacity, both (m, m)."""


class Tried(NamedTuple):
    """A basis of a part's span and its errors, for inputs one at a time.

    Attributes
    ----------
    basis : orthonormal, shape (m, n)
    gains : largest error of each output for each load of 1, times the conductivity, shape (14, loads)
    error : largest error over its tolerance, with inputs at their peaks
    worst : setting at which it is largest
    """

    basis: Array
    gains: Array
    error: float
    worst: Setting

    @property
    def order(self) -> int:
        """Number of patterns."""
        return self.basis.shape[1]


class Responses:
    """Step responses of a part in its span, and the error of what it is reduced to.

    Parameters
    ----------
    heat : the part in its span
    within : the range; rotation is weighed by the distance from base to tool point
    """

    def __init__(self, heat: Heat, within: Range) -> None:
        self.heat, self._per_second = heat, within.per_second
        self._loads = np.column_stack([heat.loads, *_changes_of_cooling(heat, within)])
        flux = AMBIENT_CHANGE * within.convection[1] / 2
        fluxes = [flux] * (self._loads.shape[1] - 2)
        self._peaks = np.array([within.heat_flow, TIP_HEAT_FLOW, *fluxes])
        weights = np.full(len(heat.outputs), 1 / within.temperature)
        weights[:6] = within.material["expansion_coefficient"] / within.displacement
        weights[3:6] *= np.linalg.norm(heat.reach)
        self._scale = SAFETY * weights[:, None] * self._peaks / within.conductivity[0]
        self._times = self._per_second * np.concatenate([[0.0], np.geomspace(1.0, LARGEST_STEP, 160)])
        self._settings = list(_settings(heat, within))
        self._exact = [self._steps(*eigh(*setting)) for setting in self._settings]

    def choose(self, order: int | None = None) -> list[Tried]:
        """Bases that were tried until the error at every sampled setting was within the tolerance.

        A greedy search: at each step the Gramian of the worst setting is added, and the order grows.

        Parameters
        ----------
        order : to take in place of the one that the tolerance asks for

        Raises
        ------
        InputError
            The tolerance is not met with any order up to `LARGEST_ORDER`.
        """
        orders = range(SMALLEST_ORDER, LARGEST_ORDER + 1, ORDER_STEP) if order is None else [order] * TRIED
        gramian = self._gramian(self._settings[0])
        found: list[Tried] = []
        for size in orders:
            found.append(self._tried(_leading(gramian, self.heat.integrals, size)))
            if order is None and found[-1].error <= 1:
                return found
            gramian = gramian + self._gramian(found[-1].worst)
        if order is None:
            raise InputError(
                f"{LARGEST_ORDER} patterns leave an error {found[-1].error:.2g} times the tolerance; allow a "
                "larger --tolerance, or a narrower range of convection"
            )
        return found

    def _tried(self, basis: Array) -> Tried:
        gains = []
        for (decay, mass), exact in zip(self._settings, self._exact, strict=True):
            rates, modes = eigh(basis.T @ decay @ basis, basis.T @ mass @ basis)
            gains.append(np.abs(np.diff(exact - self._steps(rates, basis @ modes), axis=2)).sum(axis=2))
        errors = (np.array(gains) * self._scale).max(axis=(1, 2))
        return Tried(basis, np.max(gains, axis=0), errors.max(), self._settings[int(np.argmax(errors))])

    def _steps(self, rates: Array, modes: Array) -> Array:
        """Responses to steps of inputs by modes and their decay, shape (outputs, inputs, times)."""
        grown = -np.expm1(-np.outer(rates, self._times)) / rates[:, None]
        seen, driven = self.heat.outputs @ modes, modes.T @ self._loads
        return np.einsum("om,mt,mi->oit", seen, grown, driven, optimize=True)

    def _gramian(self, setting: Setting) -> Array:
        """What inputs at their peaks reach, shape (m, m): a controllability Gramian of smoothed inputs."""
        rates, modes = eigh(*setting)
        smoothed = 1 + SMOOTHING * self._per_second * rates
        driven = modes.T @ (self._loads * self._peaks) / smoothed[:, None]
        return np.asarray(modes @ (driven @ driven.T / np.add.outer(rates, rates)) @ modes.T)


def _settings(heat: Heat, within: Range) -> Iterator[Setting]:
    """Yield the corners of the range, and samples of what is cooled, lost and carried."""

    def setting(cooling: Sequence[float], loss: Array, storage: Array) -> Setting:
        ends = heat.loads[:, :2]
        decay = heat.conduction + np.tensordot(cooling, heat.cooling, 1) + (ends * loss) @ ends.T
        return decay, np.eye(len(decay)) + (ends * storage) @ ends.T

    groups, (low, high) = len(heat.cooling), within.ratios
    for ratios in within.cooled(groups):
        yield setting(ratios, np.zeros(2), np.zeros(2))
    for share in LatinHypercube(groups + 4, rng=0).random(SAMPLES):
        held = share[:4] ** 2  # most carry and lose little
        loss = LOST / within.material["conductivity"] * held[:2]
        yield setting(low * (high / low) ** share[4:], loss, CARRIED * volume(heat) * held[2:])


def _changes_of_cooling(heat: Heat, within: Range) -> Iterator[Array]:
    """Yield what a change of each surface's convection by 1 W/(m2.K) is to a warm part, shape (m, profiles).

    Flux over the surface in the profile of temperatures that heat at the base, or the tip, has brought about,
    from shortly to long after it began, for 1 K at that end.
    """
    cooled = heat.conduction + float(np.sqrt(np.prod(within.ratios))) * sum(heat.cooling)
    ends, stored = heat.loads[:, :2], np.eye(len(cooled)) / within.per_second
    profiles = [np.linalg.solve(cooled + rate * stored, ends) for rate in WARMING]
    reached = np.column_stack([each / np.sum(ends * each, axis=0) for each in profiles])
    for cooling in heat.cooling:
        yield cooling @ reached


def _leading(gramian: Array, uniform: Array, order: int) -> Array:
    """Direction of uniform temperature, and those beside it of which the Gramian holds most."""
    size = len(uniform)
    whole = uniform / np.linalg.norm(uniform)
    beside = np.eye(size) - np.outer(whole, whole)
    _, directions = eigh(beside @ gramian @ beside, subset_by_index=(size - order + 1, size - 1))
    return np.column_stack([whole, directions])


def separated(basis: Array, heat: Heat) -> tuple[Array, Array]:
    """Basis in which conduction couples no two patterns, and conduction of each.

    Parameters
    ----------
    basis : shape (m, n), orthonormal
    heat : the part in its span; the mean square of each pattern over it becomes 1

    Returns
    -------
    patterns, conduction
        Shape (m, n), the uniform temperature first, and shape (n,) [m].
    """
    rates, directions = eigh(basis.T @ heat.conduction @ basis)
    patterns = np.sqrt(volume(heat)) * basis @ directions
    rates[0] = 0.0  # of the uniform temperature, which rounding might let grow
    patterns[:, 0] *= np.sign(patterns[:, 0] @ heat.integrals)
    return patterns, volume(heat) * rates


def volume(heat: Heat) -> float:
    """Volume of a part in its span [m3]: there its integrals are also the amplitudes of 1 K everywhere."""
    return float(heat.integrals @ heat.integrals)
