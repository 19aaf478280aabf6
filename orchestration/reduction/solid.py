"""A part from a STEP file or a mesh: tetrahedra, and the faces that its surface consists of."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.fmus.names import instead
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.reduction.places import nearest
from warmlink.orchestration.text_files import demand_file
from warmlink.orchestration.written.quantities import quantity

Integers = NDArray[np.int64]

SOLIDS, MESHES = (".step", ".stp"), (".msh", ".inp")

AROUND = 24.0
"""Elements around a bore, whose size they would otherwise change from mesh to mesh."""

EDGE_ANGLE = 30.0
"""degrees between the normals of neighbouring facets, above which an edge of a mesh parts two faces."""

MOST_TETRAHEDRA = 1_000_000

SMALLEST, LARGEST = 0.02, 5.0
"""m, between which a link's largest extent is believed."""

HEAT_FACE, TOOL_POINT = "25.4, 6, 0 mm", "330.2, 0, 0 mm"
"""Of the example."""

_COORDINATE = re.compile(r"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*)")
"""A number and its unit, which may be missing."""


@dataclass(frozen=True, eq=False)
class Face:
    """A face of the part: its number and name, the mesh's facets on it, area [m2] and centre [m]."""

    number: int
    name: str
    facets: Integers
    area: float
    centre: Array

    @property
    def label(self) -> str:
        """Number and name."""
        return f"#{self.number} {self.name}".strip()


@dataclass(frozen=True)
class Solid:
    """Tetrahedra (`skfem.MeshTet`, in m), the faces of their surface, and the size of elements [m]."""

    mesh: Any
    faces: Sequence[Face]
    size: float = 0.0

    def nearest(self, place: Array) -> Face:
        """Face nearest to a point [m]."""
        corners = self.mesh.p[:, self.mesh.facets]
        return min(self.faces, key=lambda face: nearest(place, corners[:, :, face.facets])[0])

    def chosen(self, texts: Sequence[str], name: str) -> list[Face]:
        """Faces by `#NUMBER`, by name, or by a point `x, y, z UNIT` that they are nearest to.

        InputError if there is no such face; `name` is that of the argument.
        """
        found: list[Face] = []
        for text in map(str.strip, texts):
            if "," in text:
                found.append(self.nearest(point(text, name)))
                continue
            named = [face for face in self.faces if text and text in (f"#{face.number}", face.name)]
            if not named:
                numbers, names = zip(*((f"#{face.number}", face.name) for face in self.faces), strict=True)
                known = instead(text, [*numbers, *sorted({*names} - {""})], "or give a point on it")
                shows = "warmlink reduce PART --list-faces shows them"
                raise InputError(f"{argument(name, text)}: no such face; {known} ({shows})")
            found += named
        return list(dict.fromkeys(found))


def point(text: str, name: str) -> Array:
    """Point in m from `x, y, z UNIT`, or `x UNIT, y UNIT, z UNIT`, of the argument of a name.

    InputError if it is not three lengths.
    """
    parts = [_COORDINATE.fullmatch(part.strip()) for part in text.split(",")]
    units = [part[2] for part in parts if part is not None]
    if len(units) != 3 or len(units) != len(parts) or not units[-1]:
        raise InputError(f'{argument(name, text)}: is no point; write it with its unit, as "25.4, 0, 3 mm"')
    where = argument(name, text)
    return np.array([quantity(f"{part[1]} {part[2] or units[-1]}", "m", where) for part in parts if part])


def read_solid(path: Path, unit: str | None = None, size: float | None = None, coarser: float = 1.0) -> Solid:
    """Mesh of a part; InputError if its file does not hold exactly one closed solid of plausible size.

    The file is STEP, or a mesh of tetrahedra (.msh, .inp), whose `unit` is said. Elements have a `size` [m],
    by default the thickness of thin walls; `coarser` is a factor on all sizes, those around bores included.
    """
    demand_file(path, "give a STEP file or a mesh")
    if path.suffix.lower() in SOLIDS:
        if unit is not None:
            raise InputError(f"{argument('unit', unit)}: a STEP file says its unit; leave it out")
        solid = _from_step(path, size, coarser)
    elif path.suffix.lower() in MESHES:
        if unit is None:
            raise InputError(
                f"{path}: a mesh does not say its unit; give {argument('unit', 'mm')}, or another one"
            )
        solid = _from_mesh(path, quantity(f"1 {unit}", "m", argument("unit", unit)))
    else:
        raise InputError(f"{path}: is neither STEP nor mesh; give a file {', '.join((*SOLIDS, *MESHES))}")
    extent = float(np.ptp(solid.mesh.p, axis=1).max())
    if not SMALLEST <= extent <= LARGEST:
        raise InputError(
            f"{path}: the part is {extent:.3g} m long, where links have {SMALLEST:g} to {LARGEST:g} m; check "
            "its unit: a part in millimetres that is read in inches is 25 times too long"
        )
    return solid


def _library(name: str) -> ModuleType:
    try:
        return import_module(name)
    except (ImportError, OSError) as fault:  # gmsh also wants libraries of the system
        raise MissingExtraError(f"reduce ({fault})", "cad") from None


@contextmanager
def gmsh_session(path: Path) -> Iterator[Any]:
    """Start gmsh and end it; what it refuses is said in one sentence, and what it prints is not shown."""
    gmsh = _library("gmsh")
    gmsh.initialize(interruptible=False)
    shown = os.dup(1)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        yield gmsh
    except InputError:
        raise
    except Exception as fault:  # gmsh raises nothing more special
        raise InputError(
            f"{path}: is broken ({' '.join(str(fault).split())}); export it from the CAD system anew"
        ) from None
    finally:
        gmsh.finalize()
        os.dup2(shown, 1)
        os.close(shown)


def _from_step(path: Path, size: float | None, coarser: float) -> Solid:
    with gmsh_session(path) as gmsh, TemporaryDirectory() as work:
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        bodies, surfaces = gmsh.model.getEntities(3), gmsh.model.getEntities(2)
        _one_body(path, len(bodies), f"{len(surfaces)} faces that close no solid")
        volume, *areas = (gmsh.model.occ.getMass(*each) for each in (*bodies, *surfaces))
        size = size or 2e-3 * volume / sum(areas)  # the thickness of a thin wall
        count = 8e-9 * volume / (coarser * size) ** 3
        if count > MOST_TETRAHEDRA:
            raise InputError(
                f"{argument('mesh_size')}: elements of {1e3 * size:.3g} mm would be about {count:.1g} in the "
                f"part's {1e-3 * volume:.3g} cm3; give larger ones"
            )
        for dimension, tag in (*bodies, *surfaces):
            gmsh.model.addPhysicalGroup(dimension, [tag], name=str(tag) if dimension == 2 else "body")
        options = {
            "MeshSizeMax": 1e3 * coarser * size,
            "MeshSizeFromCurvature": AROUND / coarser,
            "Binary": 1,
        }
        for name, value in {**options, "Algorithm3D": 10}.items():  # HXT, whose tetrahedra are the least flat
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.model.mesh.generate(3)
        written = Path(work) / "part.msh"
        gmsh.write(str(written))
        mesh = _tetrahedra(written, 1e-3)
        names = {tag: gmsh.model.getEntityName(2, tag).rpartition("/")[2] for _, tag in surfaces}
    return Solid(mesh, [_face(mesh, tag, names[tag], mesh.boundaries[str(tag)]) for tag in names], size)


def _from_mesh(path: Path, scale: float) -> Solid:
    mesh = _tetrahedra(path, scale)
    inner = mesh.f2t[:, mesh.f2t[1] >= 0]
    _one_body(path, len(np.unique(_connected(inner[0], inner[1], mesh.nelements))), "no tetrahedra")
    named = mesh.boundaries or {}
    for one, other in combinations(named, 2):
        if np.intersect1d(named[one], named[other]).size:
            told = f"the groups {one} and {other} share triangles, of which each lies on one face"
            raise InputError(f"{path}: {told}; leave one of the groups out")
    rest = np.setdiff1d(mesh.boundary_facets(), np.concatenate([[], *named.values()])).astype(np.int64)
    faces = [*named.items(), *(("", patch) for patch in _patches(mesh, rest))]
    return Solid(mesh, [_face(mesh, i, name, facets) for i, (name, facets) in enumerate(faces, 1)])


def _tetrahedra(path: Path, scale: float) -> Any:
    """The `skfem.MeshTet` in a file, of its corners alone; groups of triangles become its boundaries."""
    meshio, convert = _library("meshio"), _library("skfem.io.meshio")
    try:
        held = meshio.read(path)
    except (Exception, SystemExit):  # meshio raises what its readers raise, and ends the process for some
        raise InputError(f"{path}: is broken, or no mesh; write it anew as .msh 4.1 or .inp") from None
    linear = {"tetra10": ("tetra", 4), "triangle6": ("triangle", 3)}
    blocks = [(*linear.get(block.type, (block.type, None)), block.data) for block in held.cells]
    cells = [(kind, data[:, :corners]) for kind, corners, data in blocks]
    others = [block.type for block in held.cells if block.dim == 3 and block.type not in ("tetra", "tetra10")]
    if others:
        raise InputError(f"{path}: holds cells of the type {others[0]}; mesh the whole solid with tetrahedra")
    if "tetra" not in dict(cells):
        raise InputError(f"{path}: holds no tetrahedra, as a shell does; mesh the solid with tetrahedra")
    straight = meshio.Mesh(scale * held.points.astype(float), cells, cell_sets=held.cell_sets)
    places = len(straight.points) ** np.arange(3)  # one number for each triangle, by its corners
    each_face = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    faces = np.sort(straight.cells_dict["tetra"][:, each_face].astype(np.int64)) @ places
    numbers, shared = np.unique(faces, return_counts=True)
    for name, members in straight.cell_sets_dict.items():
        if "triangle" not in members or name.startswith("gmsh:"):
            continue
        triangles = straight.cells_dict["triangle"][members["triangle"]].astype(np.int64)
        if not np.isin(np.sort(triangles) @ places, numbers[shared == 1]).all():
            told = f"the group {name} has triangles that are none of the part's surface, as those of a plane"
            raise InputError(f"{path}: {told} through it or beside it; take them out of the group")
    mesh = convert.from_meshio(straight, force_meshio_type="tetra", ignore_orientation=True)
    return mesh.remove_unused_nodes()


def _one_body(path: Path, bodies: int, otherwise: str) -> None:
    if bodies == 0:
        raise InputError(f"{path}: holds {otherwise}, an open solid or a shell; close it in the CAD system")
    if bodies > 1:
        raise InputError(f"{path}: holds {bodies} bodies; unite them, or export the link alone")


def _face(mesh: Any, number: int, name: str, facets: Integers) -> Face:
    corners = mesh.p[:, mesh.facets[:, facets]]
    area = np.linalg.norm(_normals(corners), axis=0) / 2
    return Face(number, name, facets, float(area.sum()), corners.mean(axis=1) @ area / area.sum())


def _patches(mesh: Any, facets: Integers) -> list[Integers]:
    """Boundary facets of an `skfem.MeshTet`, parted into faces at sharp edges."""
    normals = _normals(mesh.p[:, mesh.facets[:, facets]])
    normals /= np.linalg.norm(normals, axis=0)
    edges = mesh.f2e[:, facets].ravel()
    order = np.argsort(edges, kind="stable")
    shared = np.flatnonzero(np.diff(edges[order]) == 0)
    a, b = order[shared] % len(facets), order[shared + 1] % len(facets)
    # Corners are in no particular order, so that normals point either way.
    smooth = np.abs(np.sum(normals[:, a] * normals[:, b], axis=0)) > np.cos(np.radians(EDGE_ANGLE))
    patch = _connected(a[smooth], b[smooth], len(facets))
    return [facets[patch == i] for i in np.unique(patch)]


def _connected(a: Integers, b: Integers, count: int) -> Integers:
    """Connected-component labels, from 0, of a graph of so many nodes with the edges a[i]-b[i]."""
    joined = coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1])


def _normals(corners: Array) -> Array:
    """Normals of triangles, shape (3, n) [m2], twice as long as their area, for corners, (3, 3, n) [m]."""
    first, second, third = np.moveaxis(corners, 1, 0)
    return np.cross(second - first, third - first, axis=0)


def ribbed_link(path: Path) -> None:
    """Write an example as a STEP file in mm: the link of Poonyapak, Hayes and McDill with a bore and a rib.

    Its middle plane is z = 0, its length lies along x. The rib is on one side alone, so that it bends.
    """
    with TemporaryDirectory() as work, gmsh_session(path) as gmsh:
        build = gmsh.model.occ
        plate = build.addBox(0, -12.7, -3.175, 330.2, 25.4, 6.35)
        bore = build.addCylinder(25.4, 0, -6.35, 0, 0, 12.7, 6)
        rib = build.addBox(60, -1.5, 3.175, 220, 3, 8)
        bored, _ = build.cut([(3, plate)], [(3, bore)])
        build.fuse(bored, [(3, rib)])
        build.synchronize()
        written = Path(work) / "part.step"  # gmsh tells the format by the name
        gmsh.write(str(written))
        shutil.copyfile(written, path)
