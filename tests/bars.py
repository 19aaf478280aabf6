"""A straight bar of finite elements, whose closed forms are known."""

import numpy as np

from warmlink.orchestration.finite_elements.body import Body, Material, Support, mean_at, scikit_fem


def bar(
    size: tuple[float, float, float],
    elements: tuple[int, int, int],
    material: Material,
) -> Body:
    """Build a straight bar, heated and fixed at x = 0, cooled on every other face.

    Parameters
    ----------
    size : length, width, thickness [m], from the origin along x, y and z
    elements : number of elements along x, y and z
    material : the bar's material

    Returns
    -------
    Body with the probes `base` and `tip`, the mid points of the end faces.
    """
    skfem = scikit_fem()
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, s, n + 1) for s, n in zip(size, elements, strict=True)))
    mesh = mesh.with_subdomains({"link": np.arange(mesh.nelements)})
    end = mesh.facets_satisfying(lambda x: x[0] == 0.0, boundaries_only=True)
    free = np.setdiff1d(mesh.boundary_facets(), end)
    y, z = np.array([0.0, size[1]]), np.array([0.0, size[2]])
    base, tip = (
        mean_at(mesh, np.array([np.full(4, x), np.tile(y, 2), np.repeat(z, 2)])) for x in (0.0, size[0])
    )
    return Body(
        mesh=mesh.with_boundaries({"heated": end, "cooled": free}),
        materials={"link": material},
        probes={"base": base, "tip": tip},
        origin=base,
        target=tip,
        supports=(Support("heated"),),
    )
