"""One HTML page that opens from disk without a network: text, tables and plots."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from typing import Any

PACKAGES = ("warmlink", "fmpy", "pythonfmu", "casadi", "numpy", "scipy", "plotly")


@dataclass(frozen=True)
class Table:
    """Rows of text under headings; the first column is read as names, the others as figures."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """A part of the page: heading, sentences, a table, a plotly figure; what is None is left out."""

    heading: str
    text: str = ""
    table: Table | None = None
    figure: Any = None


def write_page(path: Path, title: str, lead: str, sections: Sequence[Section]) -> None:
    """Write the page; `lead` is the answer in a sentence or two.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    from jinja2 import Environment, select_autoescape
    from plotly.offline import get_plotlyjs

    source = (resources.files("warmlink.orchestration.report") / "page.html.j2").read_text("utf-8")
    template = Environment(autoescape=select_autoescape(default=True)).from_string(source)
    drawn = [(section, _drawing(section.figure, i)) for i, section in enumerate(sections)]
    html = template.render(
        title=title,
        lead=lead,
        sections=drawn,
        script=get_plotlyjs() if any(figure for _, figure in drawn) else "",
    )
    path.write_text(html, encoding="utf-8")


def versions() -> Table:
    """Versions of what a result depends on."""
    rows = [("Python", platform.python_version()), ("machine", f"{platform.system()} {platform.machine()}")]
    for package in PACKAGES:
        try:
            rows.append((package, metadata.version(package)))
        except metadata.PackageNotFoundError:
            continue
    return Table(("software", "version"), rows)


def _drawing(figure: Any, index: int) -> str | None:
    if figure is None:
        return None
    return str(
        figure.to_html(
            full_html=False,
            include_plotlyjs=False,
            div_id=f"figure-{index}",
            config={"displaylogo": False, "responsive": True},
        )
    )
