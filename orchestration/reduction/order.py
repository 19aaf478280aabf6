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
from dataclasses import dataclass

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


@dataclass(frozen=True)
class Demand:
    """What is asked of the reduced model.

    Attributes
    ----------
    displacement : largest error in m
    temperature : largest error in K
    heat_flow, tip_heat_flow : peaks in W
    ambient_change : peak in K; the surface's heat flux follows from it and the convection, and so does the
        flux that a change of convection brings to a warm part
    """

    displacement: float = 10e-9
    temperature: float = 5e-3
    heat_flow: float = 20.0
    tip_heat_flow: float = 5.0
    ambient_change: float = 15.0


Setting = tuple[Array, Array]
"""What conducts and cools, over the conductivity, and what stores, over the heat capacity, both (m, m)."""


class Responses:
    """Step responses of a part in its span, and the error of what it is reduced to.

    Parameters
    ----------
    heat : the part in its span
    within : the range
    demand : tolerances and peaks; rotation is weighed by the distance from base to tool point
    """

    def __init__(self, heat: Heat, within: Range, demand: Demand) -> None:
        self.heat, reach = heat, float(np.linalg.norm(heat.reach))
        self.loads = np.column_stack([heat.loads, *_changes_of_cooling(heat, within)])
        flux = demand.ambient_change * within.convection[1] / 2
        fluxes = self.loads.shape[1] - 2
        self.peaks = np.array([demand.heat_flow, demand.tip_heat_flow, *[flux] * fluxes])
        per_metre = within.material["expansion_coefficient"] / demand.displacement
        rest = len(heat.outputs) - 6
        weights = np.array([per_metre] * 3 + [per_metre * reach] * 3 + [1 / demand.temperature] * rest)
        self._scale = SAFETY * weights[:, None] * self.peaks / within.conductivity[0]
        self._per_second = within.material["conductivity"] / within.capacity
        self._times = self._per_second * np.concatenate([[0.0], np.geomspace(1.0, LARGEST_STEP, 160)])
        self.settings = list(_settings(heat, within))
        self._exact = [self.steps(setting) for setting in self.settings]

    def modes(self, setting: Setting, basis: Array | None = None) -> tuple[Array, Array]:
        """Rates of decay in scaled time, shape (n,), and modes, in the part's span or in a basis of it."""
        decay, mass = setting
        if basis is None:
            return eigh(decay, mass)
        rates, modes = eigh(basis.T @ decay @ basis, basis.T @ mass @ basis)
        return rates, basis @ modes

    def steps(self, setting: Setting, basis: Array | None = None) -> Array:
        """Responses of outputs to steps of inputs, shape (outputs, inputs, times)."""
        rates, modes = self.modes(setting, basis)
        grown = -np.expm1(-np.outer(rates, self._times)) / rates[:, None]
        return np.einsum(
            "om,mt,mi->oit", self.heat.outputs @ modes, grown, modes.T @ self.loads, optimize=True
        )

    def errors(self, basis: Array) -> tuple[Array, Array]:
        """Error of a basis at all settings, for inputs one at a time.

        Returns
        -------
        gains, errors
            Largest error of outputs for loads of 1, times the conductivity, shape (settings, outputs, loads);
            and the largest for inputs at their peaks, as a share of its tolerance, shape (settings,).
        """
        gains = np.array(
            [
                np.abs(np.diff(exact - self.steps(setting, basis), axis=2)).sum(axis=2)
                for setting, exact in zip(self.settings, self._exact, strict=True)
            ]
        )
        return gains, (gains * self._scale).max(axis=(1, 2))

    def gramian(self, setting: Setting) -> Array:
        """What inputs at their peaks reach, shape (m, m): a controllability Gramian of smoothed inputs."""
        rates, modes = self.modes(setting)
        smoothed = 1 + SMOOTHING * self._per_second * rates
        driven = modes.T @ (self.loads * self.peaks) / smoothed[:, None]
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
        yield setting(low * (high / low) ** share[4:], loss, CARRIED * _volume(heat) * held[2:])


def _changes_of_cooling(heat: Heat, within: Range) -> Iterator[Array]:
    """Yield what a change of each surface's convection by 1 W/(m2.K) is to a warm part, shape (m, profiles).

    Flux over the surface in the profile of temperatures that heat at the base, or the tip, has brought about,
    from shortly to long after it began, for 1 K at that end.
    """
    ratio = float(np.sqrt(np.prod(within.ratios)))
    cooled = heat.conduction + ratio * sum(heat.cooling)
    scaled = within.capacity / within.material["conductivity"]
    profiles = [
        np.linalg.solve(cooled + rate * scaled * np.eye(len(cooled)), heat.loads[:, :2]) for rate in WARMING
    ]
    reached = np.column_stack([each / np.sum(heat.loads[:, :2] * each, axis=0) for each in profiles])
    for cooling in heat.cooling:
        yield cooling @ reached


@dataclass(frozen=True, eq=False)
class Chosen:
    """A basis of the part's span, and its errors.

    Attributes
    ----------
    basis : shape (m, n), orthonormal
    gains : of `Responses.errors`, the largest at all settings
    error : largest error over its tolerance
    """

    basis: Array
    gains: Array
    error: float

    @property
    def order(self) -> int:
        """Number of patterns."""
        return self.basis.shape[1]


def choose_order(responses: Responses, order: int | None = None) -> list[Chosen]:
    """Bases that were tried until the error at every sampled setting was within the tolerance.

    A greedy search: at each step the Gramian of the worst setting is added, and the order grows.

    Parameters
    ----------
    responses : of the part
    order : to take in place of the one that the tolerance asks for

    Raises
    ------
    InputError
        The tolerance is not met with any order up to `LARGEST_ORDER`.
    """
    orders = range(SMALLEST_ORDER, LARGEST_ORDER + 1, ORDER_STEP) if order is None else [order] * TRIED
    gramian = responses.gramian(responses.settings[0])
    tried: list[Chosen] = []
    for size in orders:
        basis = _leading(gramian, responses.heat.integrals, size)
        gains, found = responses.errors(basis)
        tried.append(Chosen(basis, gains.max(axis=0), float(found.max())))
        if order is None and tried[-1].error <= 1:
            break
        gramian = gramian + responses.gramian(responses.settings[int(np.argmax(found))])
    if order is None and tried[-1].error > 1:
        raise InputError(
            f"{LARGEST_ORDER} patterns leave an error {tried[-1].error:.2g} times the tolerance; allow a "
            "larger --tolerance, or a narrower range of convection"
        )
    return tried


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
    volume = _volume(heat)
    patterns = np.sqrt(volume) * basis @ directions
    conduction = volume * rates
    conduction[0] = 0.0  # of the uniform temperature, which rounding might let grow
    patterns[:, 0] *= np.sign(patterns[:, 0] @ heat.integrals)
    return patterns, conduction


def _volume(heat: Heat) -> float:
    """Volume of a part in its span [m3]: there its integrals are also the amplitudes of 1 K everywhere."""
    return float(heat.integrals @ heat.integrals)
