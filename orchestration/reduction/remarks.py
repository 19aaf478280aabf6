"""What the documentation of a reduced link says of its mesh, its order and its errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from warmlink.orchestration.reduction.mesh_error import HEAT_FLOW, TIMES, MeshError
from warmlink.orchestration.reduction.order import SAFETY
from warmlink.orchestration.reduction.part import Part


def remarks(part: Part, name: str) -> str:
    """Section on a part in Markdown."""
    mesh, chosen, within, demand = part.mesh, part.chosen, part.within, part.demand
    met = "not met: the order was given" if chosen.error > 1 else "met"
    faces = {
        "heated": part.task.heated,
        "tool": part.task.tool,
        **{f"cooled, `convection_factor[{i}]`": group for i, group in enumerate(part.task.cooled, 1)},
    }
    return "\n\n".join(
        [
            f"## This part: {name}",
            f"Mesh: {part.solid.mesh.nelements} tetrahedra, {part.heat.unknowns} temperatures, "
            f"{3 * part.heat.unknowns} displacements.",
            _table(
                ("use", "faces"),
                (
                    (use, ", ".join(_named(face.number, face.name) for face in each))
                    for use, each in faces.items()
                ),
            ),
            f"Range: conductivity {_span(within.conductivity)} W/(m.K); convection and linearised radiation "
            f"{_span(within.convection)} W/(m2.K). Tolerance ({met}): {1e9 * demand.displacement:g} nm and "
            f"{1e3 * demand.temperature:g} mK for {demand.heat_flow:g} W at the base, "
            f"{demand.tip_heat_flow:g} W at the tip or surroundings {demand.ambient_change:g} K warmer, one "
            f"at a time. The bounds contain a factor of safety of {SAFETY:g}.",
            f"Order {part.model.order}, reduced from {part.span} patterns that span the responses. Estimated "
            "error over its tolerance against order, as the search went:",
            _table(
                ("order", "error / tolerance"),
                ((str(n), f"{error:.3g}") for n, error in zip(chosen.orders, chosen.errors, strict=True)),
            ),
            mesh_sentence(mesh),
            _table(*mesh_table(mesh)),
            "Thermometers [mm]: "
            + "; ".join(
                ", ".join(f"{1e3 * x:.4g}" for x in place) for place in np.round(part.task.sensors, 9)
            ),
        ]
    )


def mesh_sentence(mesh: MeshError) -> str:
    """What `mesh_table` shows."""
    order = "no order observed" if mesh.order is None else f"observed order {mesh.order:.2g}"
    return (
        f"Elongation [µm] after a step of {HEAT_FLOW:g} W on meshes of so many temperatures, the one in use "
        f"last ({order}), and its estimated error [nm]. For a mesh file the first line is that of "
        "temperatures that are linear in each tetrahedron."
    )


def mesh_table(mesh: MeshError) -> tuple[list[str], list[list[str]]]:
    """Headings and rows of the elongation on each mesh."""
    rows = [
        [str(n), *(f"{1e6 * each:.4f}" for each in row)]
        for n, row in zip(mesh.unknowns, mesh.elongation, strict=True)
    ]
    rows.append(["error [nm]", *(f"{1e9 * each:.2g}" for each in mesh.error)])
    return ["temperatures", *(f"{time:g} s" for time in TIMES)], rows


def _named(number: int, name: str) -> str:
    return f"#{number} {name}".strip()


def _span(ends: tuple[float, float]) -> str:
    return f"{ends[0]:.4g} to {ends[1]:.4g}"


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
