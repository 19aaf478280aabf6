"""A part's heat by as few patterns as keep to a tolerance, in two steps.

First the span of its responses, for all purposes as exact as its elements: of the temperatures to every load,
and of the adjoint equations to every output, at several rates and convection coefficients (rational Krylov
spaces: A. C. Antoulas, C. A. Beattie and S. Gugercin, *Interpolatory Methods for Model Reduction*, SIAM
2020). What hub and tip carry and lose, a change of rank one along a load, leads to nothing else.

Then the directions in that span which heat inputs reach most, at the worst parameters. The error of an output
due to an input that is held over each second and stays below a peak is at most the peak times the integral
over time of the error's absolute impulse response (the norm that peaks induce: S. Boyd and J. Doyle, Systems
& Control Letters 9 (1987) 1-6), here taken from step responses at 1 s and at growing times, between model and
span. In time scaled by heat capacity over conductivity it depends on ratios alone, and on 1 / conductivity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.stats.qmc import LatinHypercube

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import symmetric_factor
from warmlink.orchestration.reduction.elements import Heat
from warmlink.orchestration.scenarios.scenario import materials
from warmlink.orchestration.written.quantities import quantity

RATES = np.geomspace(2e-5, 16.0, 9)
"""1/s, at which responses are taken: from half a day to well below the second after which bounds hold."""

LEAST_SHARE = 1e-7
"""Singular value, as a share of the largest, below which a direction is dropped."""

SAFETY, SAMPLES = 1.5, 32
"""Factor on errors, which are found at so many sampled parameters, beside the corners of the range."""

TIP_HEAT_FLOW, AMBIENT_CHANGE = 5.0, 15.0
"""W and K, peaks; the second gives the surfaces' heat flux, and that of a change of their convection."""

CARRIED, LOST = 0.5, 1.0
"""Largest heat capacity of hub and tip, as a share of the part's, and conductance from them, in W/K at the
nominal conductivity."""

STEPS = np.concatenate([[0.0], np.geomspace(1.0, 1e6, 160)])
"""s, at which step responses are compared."""

SMOOTHING = 10.0
"""s over which inputs are smoothed before patterns are chosen: what passes sooner moves no tool point."""

WARMING = (0.0, 1e-4, 1e-3, 1e-2)
"""1/s, inverse times for which a part has been heated when its convection changes."""

SMALLEST_ORDER, LARGEST_ORDER, ORDER_STEP, TRIED = 6, 60, 2, 5
"""Orders that are searched, and how many bases are tried where the order is given."""


@dataclass(frozen=True, eq=False)
class Range:
    """What a reduced link is made for, in SI units.

    Nominal values of its `material`; lowest and highest `conductivity`, and `convection`, which holds
    radiation too; largest errors of `displacement` and `temperature`; peak of the `heat_flow` at the base.
    """

    material: dict[str, float]
    conductivity: tuple[float, float]
    convection: tuple[float, float] = (2.0, 60.0)
    displacement: float = 10e-9
    temperature: float = 5e-3
    heat_flow: float = 20.0

    @property
    def capacity(self) -> float:
        """Heat capacity in J/(m3.K)."""
        return self.material["density"] * self.material["specific_heat"]

    @property
    def per_second(self) -> float:
        """What a second is in scaled time: nominal conductivity over heat capacity in m2/s."""
        return self.material["conductivity"] / self.capacity

    @property
    def ratios(self) -> tuple[float, float]:
        """Lowest and highest ratio of convection and conductivity in 1/m; patterns depend on it alone."""
        return self.convection[0] / self.conductivity[1], self.convection[1] / self.conductivity[0]

    def corners(self, groups: int) -> list[tuple[float, ...]]:
        """Ratios of each group: in the middle, low, high, and each high beside the others."""
        low, high = self.ratios
        together = [(ratio,) * groups for ratio in (float(np.sqrt(low * high)), low, high)]
        alone = (tuple(high if i == g else low for i in range(groups)) for g in range(groups))
        return list(dict.fromkeys([*together, *alone]))


def range_of(material: str, conductivity: tuple[float, float] | None = None, **rest: Any) -> Range:
    """Range about a material by its name; the conductivity is 25 % about the material's where none is given.

    InputError if there is no such material.
    """
    if material not in materials():
        raise InputError(
            f"{argument('material', material)}: no such material; {instead(material, materials())}"
        )
    known = materials()[material]
    values = {p.name: quantity(known[p.name], p.unit) for p in LINK.parameters if p.name in known}
    nominal = values["conductivity"]
    return Range(values, conductivity or (0.75 * nominal, 1.25 * nominal), **rest)


def span(heat: Heat, within: Range) -> Array:
    """Patterns that span a part's responses in a range, shape (N, m); with them the mass is the identity."""
    from pymor.algorithms.chol_qr import shifted_chol_qr
    from pymor.algorithms.pod import pod
    from pymor.core.logger import set_log_levels
    from pymor.operators.numpy import NumpyMatrixOperator
    from pymor.vectorarrays.numpy import NumpyVectorSpace

    set_log_levels({"pymor": "WARNING"})
    mass, driving = NumpyMatrixOperator(heat.mass), np.column_stack([heat.loads, heat.outputs.T])
    found = [np.ones((len(driving), 1))]
    for ratios in within.corners(len(heat.cooling)):
        cooled = heat.conduction + sum(ratio * each for ratio, each in zip(ratios, heat.cooling, strict=True))
        for rate in RATES:
            found.append(symmetric_factor(rate / within.per_second * heat.mass + cooled).solve(driving))
    vectors = NumpyVectorSpace.from_numpy(np.hstack(found))
    vectors.scal(1 / vectors.norm(mass))
    kept, _ = pod(vectors, product=mass, rtol=LEAST_SHARE, orth_tol=np.inf)
    return np.asarray(shifted_chol_qr(kept, product=mass).to_numpy())  # not one by one, as pod would


class Tried(NamedTuple):
    """An orthonormal basis of a part's span, shape (m, n), and its errors for inputs one at a time.

    `gains` are the largest of each output for each load of 1, times the conductivity, shape (14, loads);
    `error` is the largest over its tolerance, with inputs at their peaks, in the setting numbered `worst`.
    """

    basis: Array
    gains: Array
    error: float
    worst: int


class PartResponses:
    """Step responses of a part, and the error of its reduction within a range of conditions."""

    def __init__(self, heat: Heat, within: Range) -> None:
        self.heat, self._per_second = heat, within.per_second
        self._loads = np.column_stack([heat.loads, *_changes_of_cooling(heat, within)])
        self._peaks = np.full(self._loads.shape[1], AMBIENT_CHANGE * within.convection[1] / 2)
        self._peaks[:2] = within.heat_flow, TIP_HEAT_FLOW
        weights = np.full(len(heat.outputs), 1 / within.temperature)
        weights[:6] = within.material["expansion_coefficient"] / within.displacement
        weights[3:6] *= np.linalg.norm(heat.reach)  # rotation, by the distance from base to tool point
        self._scale = SAFETY * weights[:, None] * self._peaks / within.conductivity[0]
        self._settings = list(_settings(heat, within))
        self._exact = [self._steps(*eigh(*setting)) for setting in self._settings]

    def choose(self, order: int | None = None) -> list[Tried]:
        """Bases that were tried until the error at every sampled setting was within the tolerance.

        A greedy search: each time the Gramian of the worst setting is added, and the order grows, unless it
        is given. InputError where no order up to `LARGEST_ORDER` does, or the span has fewer patterns.
        """
        most = min(LARGEST_ORDER, len(self.heat.integrals))
        if order is not None and order > most:
            raise InputError(
                f"{argument('order', order)}: on this mesh there are {most} patterns; give no more"
            )
        orders = range(SMALLEST_ORDER, most + 1, ORDER_STEP) if order is None else [order] * TRIED
        gramian = self._gramian(0)
        found: list[Tried] = []
        for size in orders:
            found.append(self._tried(_leading(gramian, self.heat.integrals, size)))
            if order is None and found[-1].error <= 1:
                return found
            gramian = gramian + self._gramian(found[-1].worst)
        if order is None:
            raise InputError(
                f"{orders[-1]} patterns leave an error {found[-1].error:.2g} times the tolerance; allow a "
                f"larger {argument('tolerance')}, or a narrower range of convection"
            )
        return found

    def _tried(self, basis: Array) -> Tried:
        gains = []
        for (decay, mass), exact in zip(self._settings, self._exact, strict=True):
            rates, modes = eigh(basis.T @ decay @ basis, basis.T @ mass @ basis)
            gains.append(np.abs(np.diff(exact - self._steps(rates, basis @ modes), axis=2)).sum(axis=2))
        errors = (np.array(gains) * self._scale).max(axis=(1, 2))
        return Tried(basis, np.max(gains, axis=0), float(errors.max()), int(np.argmax(errors)))

    def _steps(self, rates: Array, modes: Array) -> Array:
        """Responses to steps of inputs by modes and their decay, shape (outputs, inputs, times)."""
        grown = -np.expm1(-np.outer(rates, self._per_second * STEPS)) / rates[:, None]
        seen, driven = self.heat.outputs @ modes, modes.T @ self._loads
        return np.einsum("om,mt,mi->oit", seen, grown, driven, optimize=True)

    def _gramian(self, setting: int) -> Array:
        """What inputs at their peaks reach, shape (m, m): a controllability Gramian of smoothed inputs."""
        rates, modes = eigh(*self._settings[setting])
        smoothed = 1 + SMOOTHING * self._per_second * rates
        driven = modes.T @ (self._loads * self._peaks) / smoothed[:, None]
        return np.asarray(modes @ (driven @ driven.T / np.add.outer(rates, rates)) @ modes.T)


def _settings(heat: Heat, within: Range) -> Iterator[tuple[Array, Array]]:
    """Yield what conducts and cools, over the conductivity, and what stores, over the heat capacity, (m, m).

    At the corners of the range, and at samples of what is cooled, lost and carried.
    """
    groups, ends, (low, high) = len(heat.cooling), heat.loads[:, :2], within.ratios
    samples = LatinHypercube(groups + 4, rng=0).random(SAMPLES)
    largest = np.repeat([LOST / within.material["conductivity"], CARRIED * volume(heat)], 2)
    held = largest * samples[:, :4] ** 2  # most lose and carry little
    corners = [(np.zeros(4), each) for each in within.corners(groups)]
    for taken, cooling in [*corners, *zip(held, low * (high / low) ** samples[:, 4:], strict=True)]:
        decay = heat.conduction + np.tensordot(cooling, heat.cooling, 1) + (ends * taken[:2]) @ ends.T
        yield decay, np.eye(len(decay)) + (ends * taken[2:]) @ ends.T


def _changes_of_cooling(heat: Heat, within: Range) -> Iterator[Array]:
    """Yield what a change of each surface's convection by 1 W/(m2.K) is to a warm part, shape (m, profiles).

    Profiles are those that heat at either end brings about, early and late, for 1 K at that end.
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
    """Patterns of a basis that conduction does not couple, shape (m, n), and the conduction of each, (n,).

    The first is 1 everywhere in the part, and the mean square of each over it is 1.
    """
    rates, directions = eigh(basis.T @ heat.conduction @ basis)
    patterns = np.sqrt(volume(heat)) * basis @ directions
    rates[0] = 0.0  # of the uniform temperature, which rounding might let grow
    patterns[:, 0] *= np.sign(patterns[:, 0] @ heat.integrals)
    return patterns, volume(heat) * rates


def volume(heat: Heat) -> float:
    """Volume of a part in its span [m3]: there its integrals are also the amplitudes of 1 K everywhere."""
    return float(heat.integrals @ heat.integrals)
