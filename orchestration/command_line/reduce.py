"""`warmlink reduce`: a thermal link FMU from a solid, with a bound of its error."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import FAILED, answer, answer_json, print_table
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.shell import command
from warmlink.orchestration.text_files import demand_file

COMMANDS = ("reduce",)


def reduce(
    part: Path,
    *,
    heat_face: list[str] | None = None,
    tool_point: str | None = None,
    tool_face: list[str] | None = None,
    cooled: list[str] | None = None,
    sensor: list[str] | None = None,
    material: str = "aluminium_6061",
    poissons_ratio: float = 0.33,
    convection: str = "2 .. 60 W/(m2.K)",
    conductivity: str | None = None,
    tolerance: str = "10 nm",
    temperature_tolerance: str = "0.005 K",
    heat_flow: str = "20 W",
    order: int | None = None,
    mesh_size: str | None = None,
    unit: str | None = None,
    example: bool = False,
    list_faces: bool = False,
    out: Path | None = None,
    report: bool = True,
    json: bool = False,
) -> None:
    """Make a thermal link FMU from a solid, by finite elements, with a bound of the reduction's error.

    It has the connectors of ThermalLink, and gives displacement and rotation of the tool point besides.

    Example: `warmlink reduce link.step --heat-face "25, 6, 0 mm" --tool-point "330, 0, 0 mm"`

    Parameters
    ----------
    part : A STEP file with one solid, or a mesh (.msh, .inp).
    heat_face : Face that heat enters: "#3", a name, or a point on it, "25, 6, 0 mm". Repeatable.
    tool_point : The tool point, "330, 0, 0 mm".
    tool_face : Face that carries the tool. Default: the one nearest to the tool point.
    cooled : Faces that lose heat, as a group: "#1; #4". Repeat it for groups with factors of their own.
        Default: all but the heated ones.
    sensor : Place of a thermometer, "100, 0, 3 mm"; up to eight. Default: base, middle, tip, ...
    material : As in a scenario (`warmlink list`).
    poissons_ratio : Of the material.
    convection : Range of convection and radiation together.
    conductivity : Range, "120 .. 200 W/(m.K)". Default: 25 % about the material's.
    tolerance : Largest error of the tool point.
    temperature_tolerance : Largest error of temperatures.
    heat_flow : Largest heat flow, for which the tolerance holds.
    order : Number of patterns, whatever the tolerance.
    mesh_size : Size of the elements, "4 mm".
    unit : Unit of a mesh's lengths; a STEP file says its own.
    example : Write an example, a ribbed and bored link, as PART, and stop.
    list_faces : Show the faces, with a picture in PART_faces.html, and stop.
    out : FMU to write. Default: PART.fmu.
    report : Write a page beside the FMU, as PART.html.
    """
    from warmlink.orchestration.products.reduce import fmu_path
    from warmlink.orchestration.products.reduce import reduce as reduce_solid

    if example:
        _write_example(part)
        return
    if list_faces:
        _list(part, unit, mesh_size, json)
        return
    demand_file(part, "give a STEP file or a mesh")
    target = fmu_path(out or part.with_suffix(".fmu"))
    found = reduce_solid(
        part,
        heat_face or (),
        tool_point or "",
        tool_faces=tool_face or (),
        cooled=cooled or (),
        sensor_points=sensor or (),
        material=material,
        poissons_ratio=poissons_ratio,
        convection=convection,
        conductivity=conductivity,
        tolerance=tolerance,
        temperature_tolerance=temperature_tolerance,
        heat_flow=heat_flow,
        order=order,
        mesh_size=mesh_size,
        unit=unit,
    )
    page = target.with_suffix(".html")
    with spinner(f"Writing {target.name}") as progress:
        progress("building and checking the FMU", 0.0)
        failed = found.write_fmu(target)
        if report:
            progress("where thermometers tell most", 0.5)
            found.write_page(page)
    if json:
        answer_json({**found.to_dict(), "fmu": str(target), "failed_checks": failed})
    else:
        answer(found.summary())
        if report:
            answer(f"page   {page}")
        answer(f"FMU    {target}    {'; '.join(failed) or 'all checks passed'}")
    if failed:
        raise SystemExit(FAILED)


def _write_example(part: Path) -> None:
    from warmlink.orchestration.reduction.solid import HEAT_FACE, SOLIDS, TOOL_POINT, ribbed_link

    if part.suffix.lower() not in SOLIDS:
        raise InputError(f"{part}: is no STEP file; give a name that ends in .step")
    with fresh_file(part) as scratch:
        ribbed_link(scratch)
    words = part, "--heat-face", HEAT_FACE, "--tool-point", TOOL_POINT
    answer(f"part  {part}    {command('warmlink', 'reduce', *words)}")


def _list(part: Path, unit: str | None, mesh_size: str | None, json: bool) -> None:
    from warmlink.orchestration.reduction.solid import read_solid
    from warmlink.orchestration.report.reduction import in_mm, write_faces
    from warmlink.orchestration.written.quantities import positive

    size = None if mesh_size is None else positive(mesh_size, "m", "--mesh-size")
    demand_file(part, "give a STEP file or a mesh")
    solid = read_solid(part, unit, size)
    page = part.with_name(f"{part.stem}_faces.html")
    with fresh_file(page) as scratch:
        write_faces(solid, part.name, scratch)
    if json:
        names = ("number", "name", "area")
        answer_json([{**{n: getattr(f, n) for n in names}, "centre": f.centre.tolist()} for f in solid.faces])
        return
    rows = [(f"#{f.number}", f.name, f"{1e6 * f.area:.4g}", in_mm(f.centre[None])) for f in solid.faces]
    print_table(str(part), ("face", "name", "area [mm2]", "centre [mm]"), rows)
    answer(f"picture  {page}")
