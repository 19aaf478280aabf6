"""`warmlink reduce`: a thermal link FMU from a solid, with a bound of its error."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import FAILED, answer, answer_json, print_table, spinner
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.shell import command
from warmlink.orchestration.text_files import is_file

if TYPE_CHECKING:
    from warmlink.orchestration.reduction.part import Part


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
    from warmlink.orchestration.reduction.elements import Use
    from warmlink.orchestration.reduction.order import LARGEST_ORDER, range_of
    from warmlink.orchestration.reduction.part import reduce_part, write_fmu
    from warmlink.orchestration.report.reduction import remarks, write_report
    from warmlink.orchestration.scenarios.entries import positive

    size = None if mesh_size is None else positive(mesh_size, "m", "--mesh-size")
    if example:
        _write_example(part)
        return
    if not is_file(part):
        raise InputError(f"{part}: no such file; give a STEP file or a mesh")
    if list_faces:
        _list(part, unit, size, json)
        return
    target = out or part.with_suffix(".fmu")
    if target.suffix != ".fmu" or not re.fullmatch(r"[A-Za-z]\w*", target.stem, re.ASCII):
        raise InputError(
            f"--out {target}: names no FMU; give letters, digits and _ before .fmu, as MyLink.fmu"
        )
    if not heat_face or tool_point is None:
        raise InputError("--heat-face and --tool-point: both are needed; --list-faces shows the faces")
    if order is not None and not 2 <= order <= LARGEST_ORDER:
        raise InputError(f"--order {order}: give a number from 2 to {LARGEST_ORDER}")
    if not 0 <= poissons_ratio < 0.5:
        raise InputError(f"--poissons-ratio {poissons_ratio:g}: give a number from 0 to below 0.5")
    use = Use(heat_face, tool_point, tool_face or (), cooled or (), sensor or (), poissons_ratio)
    within = range_of(
        material,
        None if conductivity is None else _ends(conductivity, "W/(m.K)", "--conductivity"),
        convection=_ends(convection, "W/(m2.K)", "--convection"),
        displacement=positive(tolerance, "m", "--tolerance"),
        temperature=positive(temperature_tolerance, "K", "--temperature-tolerance"),
        heat_flow=positive(heat_flow, "W", "--heat-flow"),
    )
    with spinner("reducing") as doing:
        found = reduce_part(part, use, within, unit=unit, size=size, order=order, doing=doing)
        doing("building and checking the FMU")
        failed = write_fmu(found.model, remarks(found, part.name), target)
        page = target.with_suffix(".html")
        if report:
            doing("where thermometers tell most")
            with fresh_file(page) as scratch:
                write_report(found, part.name, scratch)
    if json:
        answer_json({**_figures(found), "fmu": str(target), "failed_checks": failed})
    else:
        error, growth = 1e9 * found.mesh.error[-1], 1e6 * found.mesh.elongation[-1, -1]
        answer(f"mesh   {found.size}")
        answer(f"order  {found.model.order}, estimated error {100 * found.error:.0f} % of its tolerance")
        answer(f"mesh's error  {error:.2g} nm of {growth:.4g} µm after an hour ({found.mesh.observed})")
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


def _list(part: Path, unit: str | None, size: float | None, json: bool) -> None:
    from warmlink.orchestration.reduction.solid import read_solid
    from warmlink.orchestration.report.reduction import in_mm, write_faces

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


def _ends(text: str, unit: str, option: str) -> tuple[float, float]:
    """Ends of a range as `2 .. 60 W/(m2.K)`."""
    from warmlink.orchestration.scenarios.entries import positive

    low, dots, rest = text.partition("..")
    high = re.match(r"\s*[-+0-9.eE]+", rest)
    if not dots or high is None:
        raise InputError(f'{option} {text}: is no range; write it as "2 .. 60 {unit}"')
    ends = positive(f"{low.strip()}{rest[high.end() :]}", unit, option), positive(rest.strip(), unit, option)
    if not ends[0] < ends[1]:
        raise InputError(f"{option} {text}: ends below where it begins; exchange the two")
    return ends


def _figures(part: Part) -> dict[str, object]:
    return {
        "tetrahedra": part.elements.solid.mesh.nelements,
        "temperatures": len(part.patterns),
        "order": part.model.order,
        "error_over_tolerance": part.error,
        "mesh_order": part.mesh.order,
        "mesh_error_nm": (1e9 * part.mesh.error).tolist(),
        "mesh_error_share": part.mesh.share,
    }
