"""Parts drawn for tests, and what a part's bar is."""

from pathlib import Path
from typing import Any

from warmlink.orchestration.reduction.solid import gmsh_session

LENGTH, WIDTH, THICKNESS = 330.2, 25.4, 6.35
"""mm, the nominal link's."""


def drawn(path: Path, draw: Any, mesh: float | None = None, groups: tuple[tuple[int, str], ...] = ()) -> Path:
    """Write what `draw(gmsh.model.occ)` draws; with an element size in mm, as a mesh with named faces."""
    with gmsh_session(path) as gmsh:
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        if mesh is not None:
            for number, name in groups:
                gmsh.model.addPhysicalGroup(2, [number], name=name)
            gmsh.model.addPhysicalGroup(3, [1], name="body")
            gmsh.option.setNumber("Mesh.MeshSizeMax", mesh)
            gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
    return path


def bar(path: Path, **mesh: Any) -> Path:
    """The nominal link without holes, along x from the origin."""
    return drawn(path, lambda occ: occ.addBox(0, 0, 0, LENGTH, WIDTH, THICKNESS), **mesh)
