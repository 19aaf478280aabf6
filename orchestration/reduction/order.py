"""As few patterns as keep to a tolerance: balanced truncation with Gramians of the worst parameters.

The error of an output due to an input that is held over each second and stays below a peak is at most the
peak times the integral over time of the error's absolute impulse response (the norm that peaks induce: S.
Boyd and J. Doyle, Systems & Control Letters 9 (1987) 1-6), here taken from step responses at 1 s and at
growing times. It is computed between the reduced model and the part's own span, at sampled parameters. In
time scaled by heat capacity over conductivity it depends on ratios alone, and on 1 / conductivity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov, svd
from scipy.stats.qmc import LatinHypercube

from warmlink.fmus.errors import InputError
from warmlink.orchestration.reduction.subspace import DenseHeat, Range

Array = NDArray[np.float64]

SAFETY = 2.0
"""Factor on errors found at sampled parameters, which are not all that there are."""

SAMPLES = 16
"""Parameters at which the error is computed, beside the corners of the range."""

CARRIED = 0.5
"""Largest heat capacity of hub and tip, as a share of the part's."""

LOST = 1.0
"""W/K, largest conductance from hub and tip at the nominal conductivity."""

LARGEST_STEP = 1e6
"""s, up to which step responses are followed."""

SMALLEST_ORDER, LARGEST_ORDER, ORDER_STEP = 6, 60, 2


@dataclass(frozen=True)
class Demand:
    """What is asked of the reduced model.

    Attributes
    ----------
    displacement : largest error in m
    temperature : largest error in K
    heat_flow, tip_heat_flow : peaks in W
    ambient_change : peak in K; the surface's heat flux follows from it and the convection
    """

    displacement: float = 10e-9
    temperature: float = 5e-3
    heat_flow: float = 20.0
    tip_heat_flow: float = 5.0
    ambient_change: float = 15.0


@dataclass(frozen=True, eq=False)
class Reduced:
    """Matrices in n patterns: those of `DenseHeat` projected by `left` on `right`, both of shape (m, n)."""

    left: Array
    right: Array

    @property
    def order(self) -> int:
        """Number of patterns."""
        return int(self.right.shape[1])


@dataclass(frozen=True)
class Setting:
    """Cooling [1/m] and loss [m] over conductivity, storage [m3] over heat capacity, at base and tip."""

    cooling: tuple[float, ...]
    loss: tuple[float, float] = (0.0, 0.0)
    storage: tuple[float, float] = (0.0, 0.0)


class Responses:
    """Step responses of a part in its span, and the error of what it is reduced to.

    Parameters
    ----------
    heat : the part in its span
    within : the range
    demand : tolerances and peaks
    volume : of the part [m3]
    reach : from base to tool point [m], by which rotation is weighed
    """

    def __init__(self, heat: DenseHeat, within: Range, demand: Demand, volume: float, reach: float) -> None:
        self.heat, self.within = heat, within
        groups = len(heat.cooling)
        lowest = within.conductivity[0]
        flux = demand.ambient_change * within.convection[1] / 2
        self.peaks = np.array([demand.heat_flow, demand.tip_heat_flow, *[flux] * groups])
        expansion = within.material["expansion_coefficient"]
        per_metre = expansion / demand.displacement
        rest = len(heat.outputs) - 6
        self.weights = np.array([per_metre] * 3 + [per_metre * reach] * 3 + [1 / demand.temperature] * rest)
        self._scale = SAFETY * self.weights[:, None] * self.peaks / lowest
        times = np.concatenate([[0.0], np.geomspace(1.0, LARGEST_STEP, 160)])
        self._times = times * within.material["conductivity"] / within.capacity
        self.settings = self._sampled(groups, volume)

    def _sampled(self, groups: int, volume: float) -> list[Setting]:
        low, high = self.within.ratios
        corners = [Setting(ratios) for ratios in self.within.cooled(groups)]
        shares = LatinHypercube(groups + 4, rng=0).random(SAMPLES)
        loss, storage = LOST / self.within.material["conductivity"], CARRIED * volume
        for share in shares:
            cooling = tuple(low * (high / low) ** share[4:])
            held = share[:4] ** 2  # most carry and lose little
            corners.append(
                Setting(cooling, (loss * held[0], loss * held[1]), (storage * held[2], storage * held[3]))
            )
        return corners

    def dynamics(self, setting: Setting, model: Reduced | None = None) -> tuple[Array, Array, Array]:
        """Matrices A, B, C of dz/dt = A z + B u, y = C z in scaled time, without a model the part's own."""
        heat = self.heat
        decay = heat.conduction + np.tensordot(setting.cooling, heat.cooling, 1)
        mass = np.eye(len(decay))
        for i in range(2):
            load = np.outer(heat.loads[:, i], heat.loads[:, i])
            decay, mass = decay + setting.loss[i] * load, mass + setting.storage[i] * load
        loads, outputs = heat.loads, heat.outputs
        if model is not None:
            decay, mass = model.left.T @ decay @ model.right, model.left.T @ mass @ model.right
            loads, outputs = model.left.T @ loads, outputs @ model.right
        return np.asarray(-np.linalg.solve(mass, decay)), np.asarray(np.linalg.solve(mass, loads)), outputs

    def steps(self, setting: Setting, model: Reduced | None = None) -> Array:
        """Responses of outputs to steps of inputs, shape (outputs, inputs, times)."""
        a, b, c = self.dynamics(setting, model)
        rates, vectors = np.linalg.eig(a)
        grown = np.expm1(np.outer(rates, self._times)) / rates[:, None]
        return np.einsum("om,mt,mi->oit", c @ vectors, grown, np.linalg.solve(vectors, b)).real

    @cached_property
    def _exact(self) -> dict[Setting, Array]:
        return {setting: self.steps(setting) for setting in self.settings}

    def gains(self, setting: Setting, model: Reduced) -> Array:
        """Largest error of outputs for inputs of 1, times the conductivity, shape (outputs, inputs)."""
        error = self._exact[setting] - self.steps(setting, model)
        return np.abs(np.diff(error, axis=2)).sum(axis=2)

    def error(self, setting: Setting, model: Reduced) -> float:
        """Largest error, as a share of its tolerance, for inputs at their peaks one at a time."""
        return float((self.gains(setting, model) * self._scale).max())


@dataclass(frozen=True, eq=False)
class Chosen:
    """A reduced model within its tolerance, and how the error fell with the order on the way."""

    model: Reduced
    orders: Sequence[int]
    errors: Sequence[float]
    gains: Array

    @property
    def error(self) -> float:
        """Largest error of the model over its tolerance."""
        return min(self.errors)


def choose_order(responses: Responses, order: int | None = None) -> Chosen:
    """Reduce a part until its error at every sampled setting is within the tolerance.

    At each step of the greedy search, the Gramians of the worst setting are added to those that are balanced,
    and the order grows.

    Parameters
    ----------
    responses : of the part
    order : to take in place of the one that the tolerance asks for

    Raises
    ------
    InputError
        The tolerance is not met with any order up to `LARGEST_ORDER`.
    """
    from pymor.algorithms.greedy import weak_greedy

    search = _surrogate(responses, order)
    steps = (LARGEST_ORDER - SMALLEST_ORDER) // ORDER_STEP
    found = weak_greedy(
        search,
        responses.settings,
        atol=1.0 if order is None else 0.0,
        max_extensions=steps if order is None else 4,
    )
    errors = [float(each) for each in found["max_errs"]]
    if order is None and errors[-1] > 1:
        raise InputError(
            f"{LARGEST_ORDER} patterns leave an error {errors[-1]:.2g} times the tolerance; allow a larger "
            "--tolerance, or a narrower range of convection"
        )
    gains = np.max([responses.gains(setting, search.best) for setting in responses.settings], axis=0)
    return Chosen(search.best, search.orders[: len(errors)], errors, gains)


def _surrogate(responses: Responses, order: int | None) -> Any:
    """Search that pyMOR's greedy algorithm drives; pyMOR is imported only here."""
    from pymor.algorithms.greedy import WeakGreedySurrogate

    class Search(WeakGreedySurrogate):
        """Balanced truncation with the Gramians of the settings that were worst so far."""

        def __init__(self) -> None:
            middle = responses.settings[0]
            self._reach, self._seen = _gramians(responses, middle)
            self.model = _balanced(self._reach, self._seen, order or SMALLEST_ORDER)
            self.best, self.least = self.model, np.inf
            self.orders = [self.model.order]

        def evaluate(self, mus: Sequence[Setting], return_all_values: bool = False) -> Any:
            errors = np.array([responses.error(setting, self.model) for setting in mus])
            if return_all_values:
                return errors
            worst = int(np.argmax(errors))
            if errors[worst] < self.least:
                self.best, self.least = self.model, errors[worst]
            return errors[worst], mus[worst]

        def extend(self, mu: Setting) -> None:
            reach, seen = _gramians(responses, mu)
            self._reach, self._seen = self._reach + reach, self._seen + seen
            self.model = _balanced(self._reach, self._seen, order or self.model.order + ORDER_STEP)
            self.orders.append(self.model.order)

    return Search()


def _gramians(responses: Responses, setting: Setting) -> tuple[Array, Array]:
    """Gramians of what the inputs reach and what the outputs see."""
    a, b, c = responses.dynamics(setting)
    driven, weighed = b * responses.peaks, c * responses.weights[:, None]
    return solve_continuous_lyapunov(a, -driven @ driven.T), solve_continuous_lyapunov(
        a.T, -weighed.T @ weighed
    )


def _balanced(reach: Array, seen: Array, order: int) -> Reduced:
    """Directions that are reached and seen most (B. C. Moore, IEEE Trans. Autom. Control 26 (1981) 17)."""
    roots = []
    for gramian in (reach, seen):
        u, s, _ = svd((gramian + gramian.T) / 2)
        roots.append(u * np.sqrt(s))
    left, values, right = svd(roots[1].T @ roots[0])
    scale = np.sqrt(values[:order])
    return Reduced(left=roots[1] @ left[:, :order] / scale, right=roots[0] @ right[:order].T / scale)


def separated(model: Reduced, conduction: Array, volume: float) -> tuple[Reduced, Array]:
    """Reduced model in patterns that conduction couples at most in pairs, and conduction between these.

    Parameters
    ----------
    model : to be transformed
    conduction : its matrix, shape (n, n)
    volume : of the part [m3]; amplitudes become about as large as temperatures in K
    """
    rates, vectors = np.linalg.eig(conduction)
    basis = np.where(rates.imag < 0, vectors.imag, vectors.real)
    scale = np.sqrt(volume) / np.linalg.norm(model.right @ basis, axis=0)
    basis, blocks = basis * scale, np.diag(rates.real)
    for i in np.flatnonzero(rates.imag > 0):  # its conjugate follows
        # K (a + ib) = (p + iq)(a + ib), the second column being -b.
        blocks[i, i + 1] = -rates.imag[i] * scale[i + 1] / scale[i]
        blocks[i + 1, i] = rates.imag[i] * scale[i] / scale[i + 1]
    return Reduced(left=model.left @ np.linalg.inv(basis).T, right=model.right @ basis), blocks
