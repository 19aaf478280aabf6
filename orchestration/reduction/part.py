"""From a part's file to the model of a reduced link and its FMU, with what is known of its errors.

Where two thermometers tell most of the tool point follows from the covariance of an observer that reads them:
the steady Kalman filter of motor and reduced link at rest, which does not know the heat that a design of a
controller takes for unknown (`Unknown`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_continuous_are

from warmlink.controllers.design.gains import Unknown
from warmlink.controllers.design.plant import INPUTS, Plant, plant_model
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component.join import join
from warmlink.fmus.files import write_archive
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.plant import WIRES
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.equations import STORED, ReducedModel, stored
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.reduction.elements import Elements, Heat, Use
from warmlink.orchestration.reduction.order import (
    SAFETY,
    PartResponses,
    Range,
    Tried,
    separated,
    span,
    volume,
)
from warmlink.orchestration.reduction.solid import SOLIDS, read_solid

COARSER = (2.0, 2**0.5)
"""Sizes of elements of the coarser meshes, as multiples."""

HEAT_FLOW, TIMES = 5.0, (60.0, 600.0, 3600.0)
"""W, of a step, and s after it, at which elongations on several meshes are compared."""

LEAST_ORDER, LARGEST_ORDER = 1.0, 4.0
"""Between which an observed order of convergence is believed."""

NOISE, SAMPLE_TIME = 0.1, 1.0
"""K (1 sigma) and s, of a reading of a thermometer."""

MODES = 12
"""Slowest modes of motor and link, which the filter is made of."""


class MeshError(NamedTuple):
    """What the mesh leaves of an error in the elongation (Richardson's extrapolation).

    Numbers of temperatures, coarsest mesh first; `elongation` at `TIMES` after a step of `HEAT_FLOW`, shape
    (meshes, times) [m]; estimated `error` of the finest mesh, (times,) [m]; `order` of convergence, if seen.
    """

    unknowns: Sequence[int]
    elongation: Array
    error: Array
    order: float | None

    @property
    def share(self) -> float:
        """Error as a share of the elongation, at the worst of the times."""
        return float((self.error / np.abs(self.elongation[-1])).max())

    @property
    def observed(self) -> str:
        """The observed order in words."""
        return "no order observed" if self.order is None else f"observed order {self.order:.2g}"


@dataclass(frozen=True, eq=False)
class Part:
    """A reduced part, and the errors found on the way.

    `patterns`, shape (N, m), span its responses, and `dense` is the part in them; `search` are bases of that
    span that were tried, `basis`, shape (m, order), gives the model's patterns.
    """

    elements: Elements
    within: Range
    patterns: Array
    dense: Heat
    search: Sequence[Tried]
    basis: Array
    mesh: MeshError
    model: ReducedModel

    @property
    def error(self) -> float:
        """Estimated error over its tolerance."""
        return min(tried.error for tried in self.search)

    @property
    def size(self) -> str:
        """Numbers of elements and unknowns in words."""
        count, elements = len(self.patterns), self.elements.solid.mesh.nelements
        return f"{elements} tetrahedra, {count} temperatures, {3 * count} displacements"


def reduce_part(
    path: Path,
    use: Use,
    within: Range,
    *,
    unit: str | None = None,
    size: float | None = None,
    order: int | None = None,
    progress: Progress = unseen,
) -> Part:
    """Reduce a part for a range; InputError where it cannot be read, used so, or reduced to the tolerance.

    Parameters
    ----------
    path, unit, size : as of `read_solid`
    order : number of patterns in place of what the tolerances ask for
    progress : told what is being done, and about which share of the work is done
    """
    progress("meshing", 0.0)
    solid = read_solid(path, unit, size)
    progress(f"finite elements, {solid.mesh.nelements} tetrahedra", 0.05)
    elements = Elements(solid, use)
    progress(f"responses of {len(elements.heat.loads)} temperatures", 0.15)
    patterns = span(elements.heat, within)
    dense = elements.heat.onto(patterns)
    progress("choosing the order", 0.4)
    search = PartResponses(dense, within).choose(order)
    progress("coarser meshes", 0.5)
    coarser = [elements.linear()]
    if path.suffix.lower() in SOLIDS:
        coarser = [Elements(read_solid(path, None, solid.size, ratio), use).heat for ratio in COARSER]
    counts = [len(each.loads) for each in (*coarser, elements.heat)]
    mesh = _mesh_error(counts, [*(each.onto(span(each, within)) for each in coarser), dense], within)
    best = min(search, key=lambda tried: tried.error)
    basis, conduction = separated(best.basis, dense)
    initial = (patterns @ basis).T @ (elements.heat.mass @ elements.rises()) / volume(dense)
    small = dense.onto(basis)
    model = ReducedModel(
        material=within.material,
        volume=volume(dense),
        conduction=conduction,
        cooling=np.array(small.cooling),
        loads=small.loads,
        outputs=small.outputs,
        reach=small.reach,
        initial=initial,
        error_gain=_error_gain(best.gains, len(small.cooling)),
        discretisation=mesh.share,
        conductivity_range=within.conductivity,
        convection_range=within.convection,
    )
    return Part(elements, within, patterns, dense, search, basis, mesh, model)


def write_fmu(model: ReducedModel, about: str, target: Path) -> list[str]:
    """Write the FMU of a reduced link, which holds the model too, and return what its checks found wrong.

    Its documentation ends with what is said `about` the part, in Markdown.
    """
    component = reduced_link(target.stem, model)
    entry = Entry(component, "warmlink.fmus.reduced_link.component", remarks=about)
    files = native_fmu_files(entry, "2.0", compilers(platforms_named(None)))
    with fresh_file(target) as scratch:
        write_archive(scratch, {**files, STORED: stored(model)})
    return [f"{each.name}: {each.detail}" for each in check_fmu(target) if each.verdict == "fail"]


def warmed(heat: Heat, within: Range) -> Array:
    """Amplitudes at `TIMES` after a step of `HEAT_FLOW` into a cold part in its span, shape (m, times)."""
    convection = float(np.sqrt(within.convection[0] * within.convection[1]))
    decay = within.material["conductivity"] * heat.conduction + convection * sum(heat.cooling)
    rates, modes = np.linalg.eigh(decay / within.capacity)
    grown = -np.expm1(-np.outer(rates, TIMES)) / rates[:, None]
    return np.asarray(modes @ (grown * (modes.T @ heat.loads[:, :1]))) * HEAT_FLOW / within.capacity


def _mesh_error(counts: list[int], meshes: list[Heat], within: Range) -> MeshError:
    """Error of the last mesh, from the number of temperatures and the part in its span, coarsest mesh first.

    With two meshes, or differences that do not fall, the error is taken for the largest difference.
    """
    reach = meshes[-1].reach
    along = within.material["expansion_coefficient"] * reach / np.linalg.norm(reach)
    found = np.array([along @ heat.outputs[:3] @ warmed(heat, within) for heat in meshes])
    steps = np.diff(found, axis=0)
    error, order, ratio = np.abs(steps).max(axis=0), None, COARSER[1]
    if len(meshes) > 2 and (fall := float(steps[-2, -1] / steps[-1, -1])) > 1:
        order = float(np.log(fall) / np.log(ratio))
        if order >= LEAST_ORDER:
            error = np.abs(steps[-1]) / (ratio ** min(order, LARGEST_ORDER) - 1)
    return MeshError(counts, found, error, order)


def _error_gain(gains: Array, groups: int) -> Array:
    """Errors of displacement, rotation and temperature as in `ReducedModel.error_gain`, made safe."""
    whole = np.linalg.norm(gains[:6].reshape(2, 3, -1), axis=1)
    kinds = SAFETY * np.vstack([whole, gains[6:].max(axis=0)])
    loads, profiles = kinds[:, : 2 + groups], kinds[:, 2 + groups :].reshape(3, groups, -1)
    return np.column_stack([loads, np.maximum(loads[:, 2:], profiles.max(axis=2))])


def tool_error(model: ReducedModel) -> Callable[[Array], float]:
    """Error of the tool point in m (1 sigma), for sensors whose readings are these rows times the modes."""
    joined = join("Plant", {"motor": MOTOR, "link": reduced_link("Link", model)}, WIRES)
    plant = plant_model(Plant(joined, {}, ("motor",), ("link",), {}, {"link.elongation": 1.0}))
    root = np.sqrt(plant.heat_capacity)
    rates, modes = np.linalg.eigh(root[:, None] * plant.A / root)
    slowest = np.argsort(-rates)[:MODES]
    rates, modes = rates[slowest], modes[:, slowest]
    heat = Unknown()
    size = np.array([heat.shaft_heat, heat.link_heat])
    time = np.array([heat.shaft_heat_time, heat.link_heat_time])
    heats = plant.B[:, [INPUTS.index("shaft_heat"), INPUTS.index("link_heat")]]
    state = np.diag([*rates, *(-1 / time)])
    state[:-2, -2:] = (modes.T * root) @ heats
    driven = np.diag([*np.zeros(len(rates)), *(2 * size**2 / time)])
    # From the link's patterns to the modes, and to the unknown heat that no row sees.
    link = np.pad((modes / root[:, None])[-model.order :], ((0, 0), (0, 2)))
    tool = model.material["expansion_coefficient"] * model.outputs[:3] @ link

    def error(rows: Array) -> float:
        noise = NOISE**2 * SAMPLE_TIME * np.eye(len(rows))
        covariance = solve_continuous_are(state.T, (rows @ link).T, driven, noise)
        return float(np.sqrt(np.trace(tool @ covariance @ tool.T)))

    return error


def best_pair(error: Callable[[Array], float], rows: Array) -> tuple[list[int], float]:
    """Numbers of the two places with the least error, and that error, one exchanged until none helps.

    `error` is as of `tool_error`, `rows` are for each place where a thermometer may sit, shape (n, order).
    """
    chosen, least = [0, 0], np.inf
    while True:
        before = least
        for i in range(2):
            errors = [error(rows[[chosen[1 - i], k]]) for k in range(len(rows))]
            chosen[i], least = int(np.argmin(errors)), min(errors)
        if least > 0.999 * before:
            return chosen, least
