"""The FMU of a reduced part, and what its documentation says of mesh, order and errors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.packaging.archive import write_archive
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.model import STORED, stored
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.reduction.order import AMBIENT_CHANGE, SAFETY, TIP_HEAT_FLOW
from warmlink.orchestration.reduction.part import HEAT_FLOW, TIMES, Part


class Fact(NamedTuple):
    """What is known of a part: a heading, sentences, and headings and rows of a table."""

    heading: str
    text: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


def write_fmu(part: Part, name: str, target: Path) -> list[str]:
    """Write the FMU of a reduced part, whose file is called `name`, and return what its checks found wrong.

    Beside the compiled link it holds the model, so that whatever needs its equations finds them.
    """
    about = [f"## This part: {name}"]
    for heading, text, headings, rows in facts(part):
        lines = [headings, ["---"] * len(headings), *rows]
        about += [f"### {heading}", text, "\n".join(f"| {' | '.join(line)} |" for line in lines)]
    component = reduced_link(target.stem, part.model)
    entry = Entry(component, "warmlink.fmus.reduced_link.component", remarks="\n\n".join(about))
    files = native_fmu_files(entry, "2.0", compilers(platforms_named(None)))
    with fresh_file(target) as scratch:
        write_archive(scratch, {**files, STORED: stored(part.model)})
    return [f"{each.name}: {each.detail}" for each in check_fmu(target) if each.verdict == "fail"]


def facts(part: Part) -> list[Fact]:
    """What the documentation of a part's FMU says, and so does its page."""
    within, mesh, (heated, tool, *cooled) = part.within, part.mesh, part.elements.faces
    use = {"heated": heated, "tool": tool}
    use |= {f"cooled, `convection_factor[{i}]`": group for i, group in enumerate(cooled, 1)}
    met = "not met: the order was given" if part.error > 1 else "met"
    ranges = {"conductivity [W/(m.K)]": within.conductivity, "convection [W/(m2.K)]": within.convection}
    return [
        Fact(
            "Faces",
            f"Mesh: {part.size}. Thermometers [mm]: {in_mm(part.elements.sensors)}",
            ("use", "faces"),
            [(name, ", ".join(face.label for face in faces)) for name, faces in use.items()],
        ),
        Fact(
            "Range",
            f"Convection holds linearised radiation too. Tolerance ({met}): {1e9 * within.displacement:g} nm "
            f"and {1e3 * within.temperature:g} mK for {within.heat_flow:g} W at the base, "
            f"{TIP_HEAT_FLOW:g} W at the tip or surroundings {AMBIENT_CHANGE:g} K warmer, one at a time. The "
            f"bounds contain a factor of safety of {SAFETY:g}.",
            ("of", "from", "to"),
            [(name, f"{low:.4g}", f"{high:.4g}") for name, (low, high) in ranges.items()],
        ),
        Fact(
            "Error against order",
            f"Order {part.model.order}, reduced from {len(part.dense.loads)} patterns that span the "
            "responses. Largest estimated error of displacement, rotation and temperatures over its "
            "tolerance, as the search went:",
            ("order", "error / tolerance"),
            [(str(tried.order), f"{tried.error:.3g}") for tried in part.search],
        ),
        Fact(
            "Mesh",
            f"Elongation [µm] after a step of {HEAT_FLOW:g} W on meshes of so many temperatures, the one in "
            f"use last ({mesh.observed}), and its estimated error [nm]. For a mesh file the first line is "
            "that of temperatures that are linear in each tetrahedron.",
            ("temperatures", *(f"{time:g} s" for time in TIMES)),
            [
                *(
                    (str(count), *(f"{1e6 * each:.4f}" for each in row))
                    for count, row in zip(mesh.unknowns, mesh.elongation, strict=True)
                ),
                ("error [nm]", *(f"{1e9 * each:.2g}" for each in mesh.error)),
            ],
        ),
    ]


def in_mm(places: Array) -> str:
    """Places, shape (n, 3) [m], in mm as text."""
    return "; ".join(", ".join(f"{x:.4g}" for x in place) for place in 1e3 * places.round(8) + 0.0)
