"""A reproduction as a page that opens from disk without a network, and in a terminal of 80 columns."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS
from warmlink.orchestration.paper.figures import figures
from warmlink.orchestration.paper.reproduce import PaperRow, Reproduction
from warmlink.orchestration.paper.tried import TriedModel
from warmlink.orchestration.report.page import PageTable, Section, write_page

if TYPE_CHECKING:
    from rich.console import RenderableType

TITLE = "Temperature-Induced Deformation in a Mechanical System, reproduced"

# In two lines, so that a row with its name and unit fits on one of 80 columns.
_NUMBERS = (
    "", "paper\nmeas.", "paper\npred.", "Eq.(4)\nprint.", "Eq.(4)\ncorr.", "1-D\nlink", "3-D\nFEA",
    "FEA -\npaper", "in\n%",
)  # fmt: skip
_ATTEMPTS = (
    "", "base\n[°C]", "tip\n[°C]", "elongation\n[µm]", "effect\n[µm]", "left\n[µm]", "steady\n[s]",
)  # fmt: skip

UNITS = {"um": "µm", "degC": "°C", "s": "s"}

NONE = "–"
"""Stands where a column has no such number."""

BULLET = "• "


def write_report(result: Reproduction, path: Path) -> None:
    """Write the page, whole or not at all."""
    refined = [[r.body, str(r.refinement), f"{r.tip:.4f}", f"{r.elongation:.4f}"] for r in result.refinements]
    agreed = [
        [f"{a.run}: {a.body}", *(signed(value, 2) for value in (a.base, a.tip, a.elongation))]
        for a in result.agreements
    ]
    meshes = PageTable(("body", "refinement", "tip [°C]", "elongation [µm]"), refined)
    compared = PageTable(("run: 3-D body", "base [K]", "tip [K]", "elongation [%]"), agreed)
    sections = [
        *_answers(result),
        *(Section(heading, figure=figure) for heading, figure in figures(result).items()),
        Section("Mesh convergence", _CONVERGENCE, meshes),
        Section("1-D link against 3-D FEA", _AGREEMENT, compared),
        _materials(),
    ]
    with fresh_file(path) as partial:
        write_page(partial, TITLE, _lead(result), sections)


def terminal(result: Reproduction) -> RenderableType:
    """Tables and sentences for a `rich` console; sentences with a bullet have a hanging indent."""
    from rich import box
    from rich.console import Group
    from rich.markup import escape
    from rich.table import Table as RichTable
    from rich.text import Text

    shown: list[RenderableType] = []
    for section in _answers(result):
        shown.append(Text(f"\n{section.heading}\n", style="bold"))
        if section.table is not None:
            table = RichTable(box=box.SIMPLE_HEAD, padding=0, show_edge=False)
            for i, heading in enumerate(section.table.headings):
                table.add_column(escape(heading), justify="right" if i else "left", no_wrap=True)
            for row in section.table.rows:
                table.add_row(*map(escape, row))
            shown.append(table)
        grid = RichTable.grid()
        for line in section.text.splitlines():
            listed = line.startswith(BULLET)
            text = Text(line.removeprefix(BULLET), style="" if listed else "dim")
            grid.add_row(BULLET if listed else "", text)
        if section.text:
            shown.append(grid)
    return Group(*shown)


def _answers(result: Reproduction) -> list[Section]:
    """What both page and terminal show: tables, the first of its kind explained, and sentences."""
    numbers, tried = [], []
    for first, case in enumerate(result.cases):
        rows = [_numbers(row) for row in result.rows if row.case == case]
        attempts = [_attempt(each) for each in result.attempts if each.case == case]
        texts = ("", "") if first else (_SOURCES, _TRIED)
        numbers.append(
            Section(f"The paper's numbers and ours: {case} case", texts[0], PageTable(_NUMBERS, rows))
        )
        tried.append(Section(f"What was tried: {case} case", texts[1], PageTable(_ATTEMPTS, attempts)))
    held = ((f"{'holds' if s.holds else 'does not hold'}: {s.claim}", s) for s in result.statements)
    disagreements, *others = (
        Section(heading, "\n".join(BULLET + readable(each) for each in sentences))
        for heading, sentences in (
            ("Each disagreement", [f"{r.case}, {r.quantity}: {r.note}" for r in result.rows]),
            ("The paper's statements", [f"{said} ({s.place}; {s.figures})" for said, s in held]),
            ("What it comes to", result.findings),
        )
    )
    return [*numbers, disagreements, *tried, *others]


def _numbers(row: PaperRow) -> list[str]:
    digits, percent = 0 if row.unit == "s" else 1, row.difference_percent
    values = (row.measured, row.predicted, row.printed_eq4, row.corrected, row.link, row.fea)
    return [
        f"{row.quantity} [{UNITS[row.unit]}]",
        *(NONE if v is None else f"{v:.{digits}f}" for v in values),
        f"{row.difference:+.{digits}f}{' K' if row.unit == 'degC' else ''}",
        NONE if percent is None else f"{percent:+.0f}",
    ]


def _attempt(a: TriedModel) -> list[str]:
    plain = (f"{value:.1f}" for value in (a.base, a.tip, a.elongation))
    return [a.name, *plain, signed(a.effect), signed(a.left), f"{a.steady:.0f}"]


def readable(text: str) -> str:
    """Write units with their signs."""
    return text.replace(" um", " µm").replace("degC", "°C")


def signed(value: float, digits: int = 1) -> str:
    """Write so many digits and a sign, without a negative zero."""
    return f"{round(value, digits) + 0.0:+.{digits}f}"


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


def _materials() -> Section:
    properties = {
        "thermal conductivity [W/(m K)]": "conductivity",
        "density [kg/m³]": "density",
        "specific heat [J/(kg K)]": "specific_heat",
        "Young's modulus [Pa]": "youngs_modulus",
        "Poisson's ratio": "poissons_ratio",
        "expansion coefficient [1/K]": "expansion_coefficient",
        "emissivity": "emissivity",
    }
    held = MATERIALS.values()
    rows = [[label, *(f"{getattr(m, name):.4g}" for m in held)] for label, name in properties.items()]
    lengths = {name.replace("_", " "): 1e3 * getattr(GEOMETRY, name) for name in GEOMETRY.assumed}
    assumed = ", ".join(f"{name} {length:.4g} mm" for name, length in lengths.items())
    text = f"Properties: Table I. Not given in the paper and assumed here: {assumed}."
    return Section("Materials and geometry", text, PageTable(("property", *(m.name for m in held)), rows))


def _lead(result: Reproduction) -> str:
    parts = [
        f"{r.case} case {r.measured:.1f} µm measured, {r.fea:.1f} µm by 3-D FEA as described"
        for r in result.rows
        if r.place.startswith("Table") and r.measured is not None
    ]
    by = {(a.case, a.name): a for a in result.attempts}
    still, moving = (
        -100 * by[case, "radiation and joint resistance"].effect / by[case, "as described"].left
        for case in ("stationary", "moving")
    )
    return (
        f"Elongation after an hour: {'; '.join(parts)}. "
        f"Radiation and a joint resistance account for {still:.0f} % and {moving:.0f} % "
        "of the difference; not all of the rest could be explained."
    )
