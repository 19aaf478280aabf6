"""A reproduction as a page that opens from disk without a network, and in a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.paper.data import load_geometry, load_materials
from warmlink.orchestration.paper.figures import figures
from warmlink.orchestration.paper.results import Reproduction, Row
from warmlink.orchestration.report.page import Section, Table, versions, write_page

if TYPE_CHECKING:
    from rich.console import RenderableType

TITLE = "Temperature-Induced Deformation in a Mechanical System, reproduced"
#: In two lines, so that a row with its name and unit fits on one of 80 columns.
_NUMBERS = (
    "", "paper\nmeas.", "paper\npred.", "Eq.(4)\nprint.", "Eq.(4)\ncorr.", "1-D\nlink", "3-D\nFEA",
    "FEA -\npaper", "in\n%",
)  # fmt: skip
_ATTEMPTS = (
    "", "base\n[°C]", "tip\n[°C]", "elongation\n[µm]", "effect\n[µm]", "left\n[µm]", "steady\n[s]",
)  # fmt: skip
UNITS = {"um": "µm", "degC": "°C", "s": "s"}
#: A dash stands where a column has no such number.
NONE = "–"
BULLET = "• "


def write_report(result: Reproduction, path: Path) -> None:
    """Write the page, whole or not at all."""
    sections = [
        *_answers(result),
        *(Section(heading, figure=figure) for heading, figure in figures(result).items()),
        Section("Mesh convergence", _CONVERGENCE, _refinement_table(result)),
        Section("1-D link against 3-D FEA", _AGREEMENT, _agreement_table(result)),
        Section("Materials and geometry", _assumptions(), _material_table()),
        Section("Versions", table=versions()),
    ]
    with fresh_file(path) as partial:
        write_page(partial, TITLE, _lead(result), sections)


def terminal(result: Reproduction) -> RenderableType:
    """Tables and sentences for a `rich` console."""
    from rich.console import Group
    from rich.text import Text

    shown: list[RenderableType] = []
    for section in _answers(result):
        shown.append(Text(f"\n{section.heading}\n", style="bold"))
        if section.table is not None:
            shown.append(_aligned(section.table))
        if section.text:
            shown.append(_hanging(section.text.splitlines()))
    return Group(*shown)


def _answers(result: Reproduction) -> list[Section]:
    """What both page and terminal show."""
    numbers = {case: [_numbers(row) for row in result.rows if row.case == case] for case in result.cases}
    attempts = {
        case: [
            (
                a.name, f"{a.base:.1f}", f"{a.tip:.1f}", f"{a.elongation:.1f}", signed(a.effect),
                signed(a.left), f"{a.steady:.0f}",
            )
            for a in result.attempts
            if a.case == case
        ]
        for case in result.cases
    }  # fmt: skip
    statements = [
        f"{'holds' if s.holds else 'does not hold'}: {s.claim} ({s.place}; {readable(s.figures)})"
        for s in result.statements
    ]
    return [
        *_by_case("The paper's numbers and ours", _SOURCES, _NUMBERS, numbers),
        _sentences("Each disagreement", [f"{r.case}, {r.quantity}: {readable(r.note)}" for r in result.rows]),
        *_by_case("What was tried", _TRIED, _ATTEMPTS, attempts),
        _sentences("The paper's statements", statements),
        _sentences("What it comes to", [readable(sentence) for sentence in result.findings]),
    ]


def _by_case(
    heading: str, text: str, headings: Sequence[str], rows: Mapping[str, Sequence[Sequence[str]]]
) -> list[Section]:
    """A table for each case; the first one is explained."""
    sections = [Section(f"{heading}: {case} case", table=Table(headings, rows[case])) for case in rows]
    return [replace(sections[0], text=text), *sections[1:]]


def _sentences(heading: str, sentences: Sequence[str]) -> Section:
    return Section(heading, "\n".join(BULLET + sentence for sentence in sentences))


def _numbers(row: Row) -> Sequence[str]:
    digits = 0 if row.unit == "s" else 1
    values = (row.measured, row.predicted, row.printed_eq4, row.corrected, row.link, row.fea)
    kelvin = " K" if row.unit == "degC" else ""
    percent = row.difference_percent
    return [
        f"{row.quantity} [{UNITS[row.unit]}]",
        *(NONE if v is None else f"{v:.{digits}f}" for v in values),
        f"{row.difference:+.{digits}f}{kelvin}",
        NONE if percent is None else f"{percent:+.0f}",
    ]


def _aligned(table: Table) -> RenderableType:
    from rich import box
    from rich.markup import escape
    from rich.table import Table as RichTable

    shown = RichTable(box=box.SIMPLE_HEAD, padding=0, show_edge=False)
    for i, heading in enumerate(table.headings):
        shown.add_column(escape(heading), justify="right" if i else "left", no_wrap=True)
    for row in table.rows:
        shown.add_row(*map(escape, row))
    return shown


def _hanging(lines: Sequence[str]) -> RenderableType:
    """Sentences that begin with a bullet, with a hanging indent; others pale."""
    from rich.table import Table as RichTable
    from rich.text import Text

    grid = RichTable.grid()
    for line in lines:
        listed = line.startswith(BULLET)
        grid.add_row(BULLET if listed else "", Text(line.removeprefix(BULLET), style="" if listed else "dim"))
    return grid


def readable(text: str) -> str:
    """Write units with their signs."""
    return text.replace(" um", " µm").replace("degC", "°C")


_TRIED = (
    "3-D FEA on the paper's mesh, after an hour. Nothing is fitted to the measured elongation; the joint "
    "resistance is set once, from the link's measured temperature above the shaft in the moving case. The "
    "heater lag is a first order of 3 minutes. The effective length is that between the two holes. Base and "
    "tip are the points of the link above shaft and diode. Effect: against the model as described; left: "
    "above the measured elongation; steady: three time constants of the elongation."
)
_SOURCES = (
    "Tables II and III, temperatures and times of Poonyapak, Hayes and McDill: measured and predicted as "
    "printed. The 1-D link has its base held "
    "at the shaft's temperature, the 3-D FEA the outer surface of the shaft; both as the paper describes "
    "its cases, without radiation. Eq. (4), as printed and corrected, takes the shaft's temperature too. "
    "FEA - paper: minus measured, or minus predicted where nothing was measured."
)
_CONVERGENCE = (
    "Moving case after an hour, 8-node elements throughout. The link alone, heated over a whole section, "
    "converges with order 2. In the assembly the held surface ends at the edge of the link, where the heat "
    "flow is singular, so that it converges more slowly."
)

_AGREEMENT = (
    "Largest difference over an hour, 1-D minus 3-D; the elongation relative to its largest value. The "
    "paper's cases hold a temperature, the duty cycles give the heat flow that motor and link exchange. With "
    "the same boundary conditions, the link alone, both agree. With shaft and diode the difference under a "
    "given heat flow is the heat that the shaft stores, which the cell counts in the motor. Where the shaft "
    "stores none, the holes are left, which is little. At a held temperature the base differs at first, "
    "while the rim of the shaft's hole warms."
)


def _refinement_table(result: Reproduction) -> Table:
    rows = [[r.body, str(r.refinement), f"{r.tip:.4f}", f"{r.elongation:.4f}"] for r in result.refinements]
    return Table(("body", "refinement", "tip [°C]", "elongation [µm]"), rows)


def _agreement_table(result: Reproduction) -> Table:
    rows = [
        [f"{a.run}: {a.body}", *(signed(value, 2) for value in (a.base, a.tip, a.elongation))]
        for a in result.agreements
    ]
    return Table(("run: 3-D body", "base [K]", "tip [K]", "elongation [%]"), rows)


def _material_table() -> Table:
    materials = load_materials()
    columns = (materials.link, materials.shaft, materials.diode)
    properties = (
        ("thermal conductivity [W/(m K)]", "conductivity"),
        ("density [kg/m³]", "density"),
        ("specific heat [J/(kg K)]", "specific_heat"),
        ("Young's modulus [Pa]", "youngs_modulus"),
        ("Poisson's ratio", "poissons_ratio"),
        ("expansion coefficient [1/K]", "expansion_coefficient"),
        ("emissivity", "emissivity"),
    )
    rows = [[label, *(f"{getattr(m, name):.4g}" for m in columns)] for label, name in properties]
    return Table(("property", *(m.name for m in columns)), rows)


def _assumptions() -> str:
    g = load_geometry()
    assumed = ", ".join(f"{name.replace('_', ' ')} {getattr(g, name) * 1e3:.4g} mm" for name in g.assumed)
    return f"Properties: Table I. Not given in the paper and assumed here: {assumed}."


def _lead(result: Reproduction) -> str:
    parts = [
        f"{r.case} case {r.measured:.1f} µm measured, {r.fea:.1f} µm by 3-D FEA as described"
        for r in result.rows
        if r.place.startswith("Table") and r.measured is not None
    ]
    return (
        f"Elongation after an hour: {'; '.join(parts)}. "
        "Radiation and a joint resistance account for "
        f"{_explained(result, 'stationary'):.0f} % and {_explained(result, 'moving'):.0f} % "
        "of the difference; not all of the rest could be explained."
    )


def _explained(result: Reproduction, case: str) -> float:
    """Share [%] of the difference to the measurement that radiation and joint resistance take away."""
    by = {a.name: a for a in result.attempts if a.case == case}
    return -100 * by["radiation and joint resistance"].effect / by["as described"].left


def signed(value: float, digits: int = 1) -> str:
    """Write so many digits and a sign, without a negative zero."""
    return f"{round(value, digits) + 0.0:+.{digits}f}"
