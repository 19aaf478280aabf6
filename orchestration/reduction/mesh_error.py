"""What the mesh leaves of an error in the elongation, from coarser meshes (Richardson's extrapolation)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.elements import Heat
from warmlink.orchestration.reduction.subspace import Range

TIMES = (60.0, 600.0, 3600.0)
"""s after a step of heat flow, at which elongations are compared."""

HEAT_FLOW = 5.0
"""W, of the step."""

LEAST_ORDER, LARGEST_ORDER = 1.0, 4.0
"""Between which an observed order is believed."""


@dataclass(frozen=True, eq=False)
class MeshError:
    """Elongation on several meshes, and what follows from it.

    Attributes
    ----------
    unknowns : temperatures on each mesh, coarsest first
    elongation : at `TIMES` after a step of `HEAT_FLOW`, shape (meshes, times) [m]
    order : observed order of convergence; None where the differences do not fall as they would with one
    error : estimated error of the finest mesh, shape (times,) [m]
    """

    unknowns: Sequence[int]
    elongation: Array
    order: float | None
    error: Array

    @property
    def share(self) -> float:
        """Error as a share of the elongation, at the worst of the times."""
        return float((self.error / np.abs(self.elongation[-1])).max())

    @property
    def observed(self) -> str:
        """The observed order in words."""
        return "no order observed" if self.order is None else f"observed order {self.order:.2g}"

    @property
    def sentence(self) -> str:
        """What `table` shows."""
        return (
            f"Elongation [µm] after a step of {HEAT_FLOW:g} W on meshes of so many temperatures, the one in "
            f"use last ({self.observed}), and its estimated error [nm]. For a mesh file the first line is "
            "that of temperatures that are linear in each tetrahedron."
        )

    @property
    def table(self) -> tuple[list[str], list[list[str]]]:
        """Headings and rows of the elongation on each mesh."""
        rows = [
            [str(n), *(f"{1e6 * each:.4f}" for each in row)]
            for n, row in zip(self.unknowns, self.elongation, strict=True)
        ]
        rows.append(["error [nm]", *(f"{1e9 * each:.2g}" for each in self.error)])
        return ["temperatures", *(f"{time:g} s" for time in TIMES)], rows


def mesh_error(meshes: Sequence[tuple[int, Heat]], within: Range, ratio: float) -> MeshError:
    """Compare elongations on meshes of one part.

    With two meshes, or differences that do not fall, the error is taken for the largest difference.

    Parameters
    ----------
    meshes : number of temperatures, and the part in their span; coarsest first, the last being in use
    within : material and range; convection is its geometric mean
    ratio : of the sizes of elements of the last two meshes
    """
    reach = meshes[-1][1].reach
    along = within.material["expansion_coefficient"] * reach / np.linalg.norm(reach)
    found = np.array([along @ heat.outputs[:3] @ warmed(heat, within) for _, heat in meshes])
    steps = np.diff(found, axis=0)
    error, order = np.abs(steps).max(axis=0), None
    if len(meshes) > 2:
        fall = float(steps[-2, -1] / steps[-1, -1])
        order = float(np.log(fall) / np.log(ratio)) if fall > 1 else None
        if order is not None and order >= LEAST_ORDER:
            error = np.abs(steps[-1]) / (ratio ** min(order, LARGEST_ORDER) - 1)
    return MeshError([n for n, _ in meshes], found, order, error)


def warmed(heat: Heat, within: Range) -> Array:
    """Amplitudes at `TIMES` after a step of `HEAT_FLOW` into a cold part, shape (m, times)."""
    material = within.material
    convection = float(np.sqrt(within.convection[0] * within.convection[1]))
    decay = material["conductivity"] * heat.conduction + convection * sum(heat.cooling)
    rates, modes = np.linalg.eigh(decay / within.capacity)
    grown = -np.expm1(-np.outer(rates, TIMES)) / rates[:, None]
    return np.asarray(modes @ (grown * (modes.T @ heat.loads[:, :1]))) * HEAT_FLOW / within.capacity
