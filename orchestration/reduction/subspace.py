"""A part's heat in the span of its responses: small, and for all purposes as exact as its elements.

Responses of the temperatures to every load, and of the adjoint equations to every output, at several rates
and convection coefficients (rational Krylov spaces: A. C. Antoulas, C. A. Beattie and S. Gugercin,
*Interpolatory Methods for Model Reduction*, SIAM 2020). What hub and tip carry and lose is a change of rank
one along a load that is there, whose responses lie in the same span.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.forms import symmetric_factor
from warmlink.orchestration.reduction.elements import Heat
from warmlink.orchestration.scenarios.quantity import in_si
from warmlink.orchestration.scenarios.settings import materials

RATES = np.geomspace(2e-5, 16.0, 9)
"""1/s, at which responses are taken: from half a day to well below the second after which bounds hold."""

LEAST_SHARE = 1e-7
"""Singular value, as a share of the largest, below which a direction is dropped."""


@dataclass(frozen=True, eq=False)
class Range:
    """What a reduced link is made for, in SI units.

    Attributes
    ----------
    material : nominal `conductivity`, `density`, `specific_heat`, `expansion_coefficient`
    conductivity, convection : lowest and highest; the convection holds radiation too
    displacement, temperature : largest errors in m and K
    heat_flow : peak at the base in W
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
        """Nominal conductivity over heat capacity in m2/s: what a second is in scaled time."""
        return self.material["conductivity"] / self.capacity

    @property
    def ratios(self) -> tuple[float, float]:
        """Lowest and highest ratio of convection and conductivity in 1/m; patterns depend on it alone."""
        return self.convection[0] / self.conductivity[1], self.convection[1] / self.conductivity[0]

    def cooled(self, groups: int) -> Sequence[tuple[float, ...]]:
        """Ratios of each group at which responses are taken: together, and each beside the others."""
        low, high = self.ratios
        together = ((ratio,) * groups for ratio in (float(np.sqrt(low * high)), low, high))
        alone = (tuple(high if i == g else low for i in range(groups)) for g in range(groups))
        return list(dict.fromkeys([*together, *alone]))


def range_of(material: str, conductivity: tuple[float, float] | None = None, **rest: Any) -> Range:
    """Range about a material by its name; the conductivity is 25 % about the material's where none is given.

    Raises
    ------
    InputError
        There is no such material.
    """
    if material not in materials():
        raise InputError(f"--material {material}: no such material; {instead(material, materials())}")
    known = materials()[material]
    values = {each.name: in_si(known[each.name], each.unit) for each in LINK.parameters if each.name in known}
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
    mass = NumpyMatrixOperator(heat.mass)
    uniform = np.ones_like(heat.integrals)
    vectors = NumpyVectorSpace.from_numpy(np.column_stack([uniform, *_responses(heat, within)]))
    vectors.scal(1 / vectors.norm(mass))
    found, _ = pod(vectors, product=mass, rtol=LEAST_SHARE, orth_tol=np.inf)
    return np.asarray(shifted_chol_qr(found, product=mass).to_numpy())  # not one by one, as pod would


def _responses(heat: Heat, within: Range) -> Iterator[Array]:
    """Yield the responses at each rate and convection, shape (N, loads and outputs)."""
    driving = np.column_stack([heat.loads, heat.outputs.T])
    for ratios in within.cooled(len(heat.cooling)):
        cooled = heat.conduction + sum(ratio * each for ratio, each in zip(ratios, heat.cooling, strict=True))
        for rate in RATES:
            yield symmetric_factor(rate / within.per_second * heat.mass + cooled).solve(driving)
