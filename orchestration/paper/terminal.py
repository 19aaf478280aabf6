"""A reproduction in the terminal, laid out for 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from warmlink.orchestration.paper.presentation import NONE, UNITS, claims, readable, signed
from warmlink.orchestration.paper.results import Reproduction, Row

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

#: In two lines, so that a row with its name and unit fits on one of 80 columns.
_NUMBERS = (
    "paper\nmeas.", "paper\npred.", "Eq.(4)\nprint.", "Eq.(4)\ncorr.", "1-D\nlink", "3-D\nFEA",
    "FEA -\npaper", "in\n%",
)  # fmt: skip
_ATTEMPTS = (
    "base\n[°C]", "tip\n[°C]", "elongation\n[µm]", "effect\n[µm]", "left\n[µm]", "steady\n[s]",
)  # fmt: skip
_LEGEND = (
    "meas., pred.: as printed by the paper; Eq.(4) as printed and corrected; FEA minus measured, or minus "
    "predicted where nothing was measured."
)
_TRIED = (
    "3-D FEA on the paper's mesh, after 1 h. Effect: on the elongation, against the model as described; "
    "left: above the measured elongation; steady: three time constants of the elongation."
)


def terminal_table(result: Reproduction) -> RenderableType:
    """Rows, their sentences, the attempts, the paper's statements and the findings, for a `rich` console."""
    from rich.console import Group

    cases = list(result.cases)
    rows = {case: [_numbers(row) for row in result.rows if row.case == case] for case in cases}
    tried = {
        case: [
            (
                a.name, f"{a.base:.1f}", f"{a.tip:.1f}", f"{a.elongation:.1f}", signed(a.effect),
                signed(a.left), f"{a.steady:.0f}",
            )
            for a in result.attempts
            if a.case == case
        ]
        for case in cases
    }  # fmt: skip
    notes = (f"{row.case}, {row.quantity}: {readable(row.note)}" for row in result.rows)
    return Group(
        _heading("The paper's numbers and ours"),
        _by_case(_NUMBERS, rows),
        _small(_LEGEND),
        _heading("Each disagreement"),
        _list(notes),
        _heading("What was tried"),
        _by_case(_ATTEMPTS, tried),
        _small(_TRIED),
        _heading("The paper's statements"),
        _list(claims(result)),
        _heading("What it comes to"),
        _list(readable(sentence) for sentence in result.findings),
    )


def _numbers(row: Row) -> list[str]:
    digits = 0 if row.unit == "s" else 1
    values = (row.measured, row.predicted, row.printed_eq4, row.corrected, row.link, row.fea)
    difference, percent = row.difference, row.difference_percent
    kelvin = " K" if row.unit == "degC" else ""
    return [
        f"{row.quantity} [{UNITS[row.unit]}]",
        *(NONE if v is None else f"{v:.{digits}f}" for v in values),
        NONE if difference is None else f"{difference:+.{digits}f}{kelvin}",
        NONE if percent is None else f"{percent:+.0f}",
    ]


def _by_case(headings: Sequence[str], rows: Mapping[str, Sequence[Sequence[str]]]) -> Table:
    """A table with a stretch for each case under its name."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=0, show_edge=False)
    table.add_column("", no_wrap=True)
    for heading in headings:
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for case, lines in rows.items():
        table.add_row(f"[bold]{case} case[/]")
        for line in lines:
            table.add_row(*map(escape, line))
    return table


def _heading(text: str) -> RenderableType:
    from rich.text import Text

    return Text(f"\n{text}\n", style="bold")


def _small(text: str) -> RenderableType:
    from rich.text import Text

    return Text(text, style="dim")


def _list(sentences: Iterable[str]) -> RenderableType:
    """Sentences with a hanging indent."""
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 1, 0, 0))
    for sentence in sentences:
        grid.add_row("•", Text(sentence))
    return grid
