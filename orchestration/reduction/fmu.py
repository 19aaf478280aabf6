"""The FMU of a reduced part, and what its documentation says of mesh, order and errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.packaging.archive import write_archive
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.model import STORED, stored
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.reduction.order import SAFETY
from warmlink.orchestration.reduction.part import Part


def write_fmu(part: Part, name: str, target: Path) -> list[str]:
    """Write the FMU of a reduced part, whose file is called `name`, and return what its checks found wrong.

    Beside the compiled link it holds the model, so that whatever needs its equations finds them.
    """
    component = reduced_link(target.stem, part.model)
    entry = Entry(component, "warmlink.fmus.reduced_link.component", remarks=_remarks(part, name))
    files = native_fmu_files(entry, "2.0", compilers(platforms_named(None)))
    with fresh_file(target) as scratch:
        write_archive(scratch, {**files, STORED: stored(part.model)})
    return [f"{each.name}: {each.detail}" for each in check_fmu(target) if each.verdict == "fail"]


def _remarks(part: Part, name: str) -> str:
    """Section on a part in Markdown."""
    task, within, demand = part.task, part.within, part.demand
    met = "not met: the order was given" if part.chosen.error > 1 else "met"
    faces = {"heated": task.heated, "tool": task.tool}
    faces |= {f"cooled, `convection_factor[{i}]`": group for i, group in enumerate(task.cooled, 1)}
    conductivity, convection = (
        f"{low:.4g} to {high:.4g}" for low, high in (within.conductivity, within.convection)
    )
    sensors = "; ".join(", ".join(f"{1e3 * x:.4g}" for x in place) for place in task.sensors.round(9))
    return "\n\n".join(
        [
            f"## This part: {name}",
            f"Mesh: {part.solid.mesh.nelements} tetrahedra, {part.heat.unknowns} temperatures, "
            f"{3 * part.heat.unknowns} displacements.",
            _table(("use", "faces"), ((use, ", ".join(f.label for f in of)) for use, of in faces.items())),
            f"Range: conductivity {conductivity} W/(m.K); convection and linearised radiation "
            f"{convection} W/(m2.K). Tolerance ({met}): {1e9 * demand.displacement:g} nm and "
            f"{1e3 * demand.temperature:g} mK for {demand.heat_flow:g} W at the base, "
            f"{demand.tip_heat_flow:g} W at the tip or surroundings {demand.ambient_change:g} K warmer, one "
            f"at a time. The bounds contain a factor of safety of {SAFETY:g}.",
            f"Order {part.model.order}, reduced from {len(part.dense.loads)} patterns that span the "
            "responses. Estimated error over its tolerance against order, as the search went:",
            _table(
                ("order", "error / tolerance"),
                ((str(tried.order), f"{tried.error:.3g}") for tried in part.search),
            ),
            part.mesh.sentence,
            _table(*part.mesh.table),
            f"Thermometers [mm]: {sensors}",
        ]
    )


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
