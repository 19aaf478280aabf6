"""An example of a part: a link of the paper's size with a bore, a rib and a tool's seat, as a STEP file."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.reduction.solid import gmsh_session

LENGTH, WIDTH, THICKNESS = 330.2, 25.4, 6.35
"""mm, those of Poonyapak, Hayes and McDill."""

BORE_AT, BORE = 25.4, 6.0
"""mm from the proximal end, and radius, of the shaft's bore."""

RIB_FROM, RIB_LENGTH, RIB_WIDTH, RIB_HEIGHT = 60.0, 220.0, 3.0, 8.0
"""mm; on one side alone, so that the link bends as it warms up."""

HEAT_FACE = "25.4, 6, 0 mm"
TOOL_POINT = "330.2, 0, 0 mm"


def ribbed_link(path: Path) -> None:
    """Write the part as a STEP file in mm; its middle plane is z = 0, its length lies along x."""
    import shutil
    import tempfile

    with tempfile.TemporaryDirectory() as work, gmsh_session(path) as gmsh:
        build = gmsh.model.occ
        plate = build.addBox(0, -WIDTH / 2, -THICKNESS / 2, LENGTH, WIDTH, THICKNESS)
        bore = build.addCylinder(BORE_AT, 0, -THICKNESS, 0, 0, 2 * THICKNESS, BORE)
        rib = build.addBox(RIB_FROM, -RIB_WIDTH / 2, THICKNESS / 2, RIB_LENGTH, RIB_WIDTH, RIB_HEIGHT)
        bored, _ = build.cut([(3, plate)], [(3, bore)])
        build.fuse(bored, [(3, rib)])
        build.synchronize()
        written = Path(work) / "part.step"  # gmsh tells the format by the name
        gmsh.write(str(written))
        shutil.copyfile(written, path)
