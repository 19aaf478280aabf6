"""A reproduction as a page that opens from disk without a network, and how its numbers read."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.paper.data import load_geometry, load_materials
from warmlink.orchestration.paper.figures import figures
from warmlink.orchestration.paper.results import Reproduction, Row
from warmlink.orchestration.report.page import Section, Table, versions, write_page

TITLE = "Temperature-Induced Deformation in a Mechanical System, reproduced"
HEADINGS = (
    "quantity",
    "measured",
    "predicted",
    "Eq. (4)",
    "corrected",
    "1-D link",
    "3-D FEA",
    "difference",
)
UNITS = {"um": "µm", "degC": "°C", "s": "s"}
#: A dash stands where a column has no such number.
NONE = "–"


def write_report(result: Reproduction, path: Path) -> None:
    """Write the page, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    drawn = figures(result)
    sections = [
        *(
            Section(
                f"Tables II and III, temperatures, times: {case} case",
                text,
                Table(HEADINGS, [_cells(row) for row in result.rows if row.case == case]),
            )
            for case, text in zip(result.cases, (_SOURCES, ""), strict=True)
        ),
        Section("Each disagreement", "\n".join(f"• {_name(r)}: {readable(r.note)}" for r in result.rows)),
        Section("What it comes to", "\n".join(f"• {readable(sentence)}" for sentence in result.findings)),
        *(
            Section(
                f"What was tried: {case} case", text, Table(_ATTEMPT_HEADINGS, _attempt_rows(result, case))
            )
            for case, text in zip(result.cases, (_TRIED, ""), strict=True)
        ),
        Section("The paper's statements", "\n".join(f"• {claim}" for claim in claims(result))),
        *(Section(heading, figure=figure) for heading, figure in drawn.items()),
        Section("Mesh convergence", _CONVERGENCE, _refinement_table(result)),
        Section("1-D link against 3-D FEA", _AGREEMENT, _agreement_table(result)),
        Section("Materials and geometry", _assumptions(), _material_table()),
        Section("Versions", table=versions()),
    ]
    with fresh_file(path) as partial:
        write_page(partial, TITLE, _lead(result), sections)


_ATTEMPT_HEADINGS = (
    "attempt", "base [°C]", "tip [°C]", "elongation [µm]", "effect [µm]", "left [µm]", "steady [s]",
)  # fmt: skip
_TRIED = (
    "3-D FEA on the paper's mesh, after an hour. Nothing is fitted to the measured elongation; the joint "
    "resistance is set once, from the link's measured temperature above the shaft in the moving case. The "
    "heater lag is a first order of 3 minutes. The effective length is that between the two holes. Base and "
    "tip are the points of the link above shaft and diode. Effect: against the model as described; left: "
    "above the measured elongation; steady: three time constants of the elongation."
)
_SOURCES = (
    "Measured and predicted: as printed by Poonyapak, Hayes and McDill. The 1-D link has its base held "
    "at the shaft's temperature, the 3-D FEA the outer surface of the shaft; both as the paper describes "
    "its cases, without radiation. Eq. (4), as printed and corrected, takes the shaft's temperature too. "
    "Difference: 3-D FEA minus measured, or minus predicted where nothing was measured."
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


def _cells(row: Row) -> list[str]:
    digits = 0 if row.unit == "s" else 1
    values = (row.measured, row.predicted, row.printed_eq4, row.corrected, row.link, row.fea)
    shown = [NONE if v is None else f"{v:.{digits}f}" for v in values]
    difference = NONE if row.difference is None else f"{row.difference:+.{digits}f}"
    if row.unit == "degC":
        difference += " K"
    if row.difference_percent is not None:
        difference += f" ({row.difference_percent:+.0f} %)"
    return [f"{row.quantity} [{UNITS[row.unit]}]", *shown, difference]


def _name(row: Row) -> str:
    return f"{row.case}: {row.quantity}"


def readable(text: str) -> str:
    """Write units with their signs."""
    return text.replace(" um", " µm").replace("degC", "°C")


def _attempt_rows(result: Reproduction, case: str) -> list[list[str]]:
    return [
        [
            a.name, f"{a.base:.1f}", f"{a.tip:.1f}", f"{a.elongation:.1f}", signed(a.effect),
            signed(a.left), f"{a.steady:.0f}",
        ]
        for a in result.attempts
        if a.case == case
    ]  # fmt: skip


def claims(result: Reproduction) -> list[str]:
    """Give the paper's statements as sentences that begin with whether they hold."""
    return [
        f"{'holds' if s.holds else 'does not hold'}: {s.claim} ({s.place}; {readable(s.figures)})"
        for s in result.statements
    ]


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
