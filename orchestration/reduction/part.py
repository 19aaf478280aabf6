"""From a part's file to the model of a reduced link, with what is known of its errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.reduced_link.model import ReducedModel
from warmlink.fmus.thermal_link.equations import SENSORS
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.elements import Elements, Heat, Task, linear_temperatures
from warmlink.orchestration.reduction.mesh_error import MeshError, mesh_error
from warmlink.orchestration.reduction.order import SAFETY, Chosen, Demand, Responses, choose_order, separated
from warmlink.orchestration.reduction.solid import SOLIDS, Solid, point, read_solid
from warmlink.orchestration.reduction.subspace import Range, span
from warmlink.orchestration.scenarios.quantity import in_si
from warmlink.orchestration.scenarios.scenario import materials

PROPERTIES = {
    "conductivity": "W/(m.K)",
    "density": "kg/m3",
    "specific_heat": "J/(kg.K)",
    "expansion_coefficient": "1/K",
}
"""Units of a material's properties."""

COARSER = (2.0, 2**0.5)
"""Sizes of elements of the coarser meshes, as multiples."""


@dataclass(frozen=True)
class Wanted:
    """How a part is used, in the words of the command (see `Solid.chosen` and `point`).

    Attributes
    ----------
    heated : faces that heat enters
    tool_point : the tool point
    tool : faces that carry the tool; the one nearest to the tool point where there are none
    cooled : groups of faces, those of a group parted by `;`; all but the heated faces where there are none
    sensors : places of up to eight thermometers; the others as ThermalLink's between base and tool point
    unit : of a mesh's lengths
    size : of the elements in m
    poissons_ratio : of the material
    order : number of patterns in place of what the tolerance asks for
    """

    heated: Sequence[str]
    tool_point: str
    tool: Sequence[str] = ()
    cooled: Sequence[str] = ()
    sensors: Sequence[str] = ()
    unit: str | None = None
    size: float | None = None
    poissons_ratio: float = 0.33
    order: int | None = None


@dataclass(frozen=True, eq=False)
class Part:
    """A reduced part: its mesh, its full matrices, the reduced model, and the errors found on the way.

    Attributes
    ----------
    patterns, dense : the span of its responses, shape (N, m), and the part in it
    search, chosen : bases that were tried, and the best of them
    basis : patterns of the model in that span, shape (m, order)
    """

    solid: Solid
    task: Task
    elements: Elements
    within: Range
    demand: Demand
    patterns: Array
    dense: Heat
    search: Sequence[Chosen]
    chosen: Chosen
    mesh: MeshError
    basis: Array
    model: ReducedModel

    @property
    def heat(self) -> Heat:
        """Matrices of the part in all its temperatures."""
        return self.elements.heat


def reduce_part(
    path: Path,
    wanted: Wanted,
    within: Range,
    demand: Demand,
    doing: Callable[[str], None] = lambda what: None,
) -> Part:
    """Reduce a part.

    Parameters
    ----------
    path : STEP file or mesh
    wanted : faces, points, mesh
    within : material, and the range of parameters
    demand : tolerances and largest inputs
    doing : told what is being done

    Raises
    ------
    InputError
        The part cannot be read, a face does not exist, or the tolerance cannot be met.
    """
    doing("meshing")
    solid = read_solid(path, wanted.unit, wanted.size)
    task = task_on(solid, wanted)
    doing(f"finite elements, {solid.mesh.nelements} tetrahedra")
    elements = Elements(solid, task)
    heat = elements.heat
    doing(f"responses of {heat.unknowns} temperatures")
    patterns = span(heat, within)
    dense = heat.onto(patterns)
    responses = Responses(dense, within, demand)
    doing("choosing the order")
    search = choose_order(responses, wanted.order)
    chosen = min(search, key=lambda tried: tried.error)
    doing("coarser meshes")
    if path.suffix.lower() in SOLIDS:
        coarser = [read_solid(path, None, solid.size, ratio) for ratio in COARSER]
        coarse = [Elements(each, task_on(each, wanted)).heat for each in coarser]
    else:
        coarse = [linear_temperatures(heat, solid)]
    meshes = [(each.unknowns, each.onto(span(each, within))) for each in coarse]
    error = mesh_error([*meshes, (heat.unknowns, dense)], within, COARSER[1])
    basis, conduction = separated(chosen.basis, dense)
    small = dense.onto(basis)
    volume = float(heat.integrals.sum())
    model = ReducedModel(
        material=within.material,
        volume=volume,
        conduction=conduction,
        cooling=np.array(small.cooling),
        base_row=small.outputs[-2],
        tip_row=small.outputs[-1],
        sensor_rows=small.outputs[6:-2],
        surface_rows=small.loads[:, 2:].T,
        area=heat.loads[:, 2:].sum(axis=0),
        displacement_rows=small.outputs[:3],
        rotation_rows=small.outputs[3:6],
        reach=heat.reach,
        initial_rows=(patterns @ basis).T @ (heat.mass @ _rises(elements, task)) / volume,
        error_gain=_error_gain(SAFETY * chosen.gains, len(dense.cooling)),
        discretisation=error.share,
        conductivity_range=within.conductivity,
        convection_range=within.convection,
    )
    return Part(solid, task, elements, within, demand, patterns, dense, search, chosen, error, basis, model)


def _error_gain(gains: Array, groups: int) -> Array:
    """Errors of displacement, rotation and temperature as in `ReducedModel.error_gain`."""
    kinds = np.array(
        [np.linalg.norm(gains[:3], axis=0), np.linalg.norm(gains[3:6], axis=0), gains[6:].max(axis=0)]
    )
    inputs, profiles = kinds[:, : 2 + groups], kinds[:, 2 + groups :].reshape(3, groups, -1)
    return np.column_stack([inputs, np.maximum(inputs[:, 2:], profiles.max(axis=2))])


def range_of(
    material: str,
    convection: tuple[float, float] = (2.0, 60.0),
    conductivity: tuple[float, float] | None = None,
) -> Range:
    """Range about a material by its name; the conductivity is 25 % about the material's where none is given.

    Raises
    ------
    InputError
        There is no such material.
    """
    if material not in materials():
        raise InputError(f"--material {material}: no such material; {instead(material, materials())}")
    values = {name: in_si(materials()[material][name], unit) for name, unit in PROPERTIES.items()}
    nominal = values["conductivity"]
    return Range(values, conductivity or (0.75 * nominal, 1.25 * nominal), convection)


def task_on(solid: Solid, wanted: Wanted) -> Task:
    """Faces and points on a mesh; raises InputError where a face does not exist or is used twice."""
    heated = solid.chosen(wanted.heated, "--heat-face")
    place = point(wanted.tool_point, "--tool-point")
    tool = solid.chosen(wanted.tool, "--tool-face") if wanted.tool else (solid.nearest(place),)
    if set(tool) & set(heated):
        raise InputError(
            f"--tool-point {wanted.tool_point}: lies on the heated face, to which motion is relative; "
            "give a point on another face, or --tool-face"
        )
    groups = [solid.chosen(text.split(";"), "--cooled") for text in wanted.cooled]
    twice = [face for group in groups for face in group]
    if len(set(twice)) < len(twice):
        raise InputError(f"--cooled: face #{max(twice, key=twice.count).number} is named twice; name it once")
    if len(wanted.sensors) > SENSORS:
        raise InputError(f"--sensor: {len(wanted.sensors)} are given; a link has {SENSORS}")
    areas = np.array([face.area for face in heated])
    base = np.average([face.centre for face in heated], axis=0, weights=areas)
    shares = np.array([0.0, 0.5, 1.0, *(np.arange(1, SENSORS - 2) / (SENSORS - 2))])
    sensors = base + shares[:, None] * (place - base)
    for i, text in enumerate(wanted.sensors):
        sensors[i] = point(text, "--sensor")
    return Task(
        heated,
        tool,
        groups or [[face for face in solid.faces if face not in heated]],
        place,
        sensors,
        wanted.poissons_ratio,
    )


def _rises(elements: Elements, task: Task) -> Array:
    """Temperatures for a rise of 1 K at each sensor, linear between them along the link, shape (N, 8)."""
    along = elements.heat.reach / np.linalg.norm(elements.heat.reach)
    places, sensors = along @ elements.places, task.sensors @ along
    order = np.argsort(sensors, kind="stable")
    found = np.zeros((len(places), SENSORS))
    for i, unit in zip(order, np.eye(SENSORS), strict=True):
        found[:, i] = np.interp(places, sensors[order], unit)
    return found
