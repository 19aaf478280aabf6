"""A thermal link FMU from a solid, with a bound of its error."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from warmlink.fmus.arguments import argument, count_given, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import several
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.reduction.elements import Use
from warmlink.orchestration.reduction.order import LARGEST_ORDER, range_of
from warmlink.orchestration.reduction.part import Part, reduce_part, write_fmu
from warmlink.orchestration.report.reduction import remarks, write_report
from warmlink.orchestration.text_files import demand_file
from warmlink.orchestration.written.quantities import positive


@dataclass(frozen=True, repr=False)
class Reduced(Answer):
    """A solid reduced to a link; `name` is that of its file."""

    name: str
    part: Part

    def summary(self) -> str:
        """Mesh, order and errors."""
        part = self.part
        error, growth = 1e9 * part.mesh.error[-1], 1e6 * part.mesh.elongation[-1, -1]
        return (
            f"mesh   {part.size}\n"
            f"order  {part.model.order}, estimated error {100 * part.error:.0f} % of its tolerance\n"
            f"mesh's error  {error:.2g} nm of {growth:.4g} µm after an hour ({part.mesh.observed})"
        )

    def to_dict(self) -> dict[str, object]:
        """The figures, for JSON."""
        part = self.part
        return {
            "tetrahedra": part.elements.solid.mesh.nelements,
            "temperatures": len(part.patterns),
            "order": part.model.order,
            "error_over_tolerance": part.error,
            "mesh_order": part.mesh.order,
            "mesh_error_nm": (1e9 * part.mesh.error).tolist(),
            "mesh_error_share": part.mesh.share,
        }

    def write_fmu(self, path: str | Path) -> list[str]:
        """Write the FMU, with the connectors of ThermalLink, and give what its checks found wrong.

        InputError if the path is no name of an FMU, or cannot be written.
        """
        return write_fmu(self.part.model, remarks(self.part, self.name), fmu_path(path))

    def write_page(self, path: str | Path) -> None:
        """Write a page: the part as it warms up and bends, and where thermometers tell most of it."""
        with fresh_file(Path(path)) as scratch:
            write_report(self.part, self.name, scratch)


def fmu_path(path: str | Path) -> Path:
    """Path of an FMU to be written; InputError if its name is no name of a model."""
    target = Path(path)
    if target.suffix != ".fmu" or not re.fullmatch(r"[A-Za-z]\w*", target.stem, re.ASCII):
        raise InputError(f"{target}: names no FMU; give letters, digits and _ before .fmu, as MyLink.fmu")
    return target


def reduce(
    part: str | Path,
    heat_faces: Sequence[str] | str,
    tool_point: str,
    *,
    tool_faces: Sequence[str] | str = (),
    cooled: Sequence[str] | str = (),
    sensor_points: Sequence[str] | str = (),
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
) -> Reduced:
    """Make a thermal link of a solid, by finite elements, with a bound of the reduction's error.

    Parameters
    ----------
    part : a STEP file with one solid, or a mesh (.msh, .inp)
    heat_faces : faces that heat enters: `"#3"`, a name, or a point on it, `"25, 6, 0 mm"`
    tool_point : the tool point, `"330, 0, 0 mm"`
    tool_faces : faces that carry the tool; the one nearest to the tool point by default
    cooled : groups of faces that lose heat, each as `"#1; #4"`; all but the heated ones by default
    sensor_points : places of up to eight thermometers, `"100, 0, 3 mm"`
    material : as in a scenario
    poissons_ratio : of the material
    convection : range of convection and radiation together, with its unit
    conductivity : range; 25 % about the material's by default
    tolerance, temperature_tolerance : largest errors of the tool point and of temperatures, with units
    heat_flow : largest heat flow, for which the tolerance holds
    order : number of patterns, whatever the tolerance
    mesh_size : size of the elements, `"4 mm"`
    unit : unit of a mesh's lengths; a STEP file says its own

    Raises
    ------
    InputError
        If the part cannot be read, used so, or reduced to the tolerance.

    Examples
    --------
    >>> part = wl.reduce("bracket.step", "0, 0, 0 mm", "330, 0, 0 mm")
    >>> part.write_fmu("MyLink.fmu")
    """
    path = path_given("part", part)
    size = None if mesh_size is None else positive(mesh_size, "m", argument("mesh_size"))
    demand_file(path, "give a STEP file or a mesh")
    if not heat_faces or not tool_point:
        needed = f"{argument('heat_faces')} and {argument('tool_point')}"
        raise InputError(f"{needed}: both are needed; warmlink reduce PART --list-faces shows the faces")
    if order is not None:
        order = count_given("order", order, 2, LARGEST_ORDER, "patterns")
    if not 0 <= poissons_ratio < 0.5:
        raise InputError(f"{argument('poissons_ratio', poissons_ratio)}: give a number from 0 to below 0.5")
    use = Use(
        several(heat_faces),
        tool_point,
        several(tool_faces),
        several(cooled),
        several(sensor_points),
        poissons_ratio,
    )
    within = range_of(
        material,
        None if conductivity is None else _ends("conductivity", conductivity, "W/(m.K)"),
        convection=_ends("convection", convection, "W/(m2.K)"),
        displacement=positive(tolerance, "m", argument("tolerance")),
        temperature=positive(temperature_tolerance, "K", argument("temperature_tolerance")),
        heat_flow=positive(heat_flow, "W", argument("heat_flow")),
    )
    with spinner(f"Reducing {path.name}") as progress:
        return Reduced(
            path.name, reduce_part(path, use, within, unit=unit, size=size, order=order, progress=progress)
        )


def _ends(name: str, text: str, unit: str) -> tuple[float, float]:
    """Ends of a range as `2 .. 60 W/(m2.K)`."""
    low, dots, rest = text.partition("..")
    high, given = re.match(r"\s*[-+0-9.eE]+", rest), argument(name, text)
    if not dots or high is None:
        raise InputError(f'{given}: is no range; write it as "2 .. 60 {unit}"')
    ends = (
        positive(f"{low.strip()}{rest[high.end() :]}", unit, argument(name)),
        positive(rest.strip(), unit, argument(name)),
    )
    if not ends[0] < ends[1]:
        raise InputError(f"{given}: ends below where it begins; exchange the two")
    return ends
