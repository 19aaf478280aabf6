"""One HTML page that opens from disk without a network: text, tables and plots.

The plots and the library that draws them are compressed; the browser unpacks them.
"""

from __future__ import annotations

import base64
import platform
import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.safe_text import printable, printable_json

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

MANY = 60
"""Rows of a table from which on a page shows them only once it is asked to."""

PACKAGES = ("warmlink", "fmpy", "pythonfmu", "casadi", "numpy", "scipy", "plotly")


@dataclass(frozen=True)
class PageTable:
    """Rows of text under headings; the first column is read as names, the others as figures."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """A part of the page: heading, sentences, a table, a plotly figure, and a warning in red before them.

    What is None or empty is left out. `beside` is a figure at the right of the first one, or below it on a
    narrow page. `page` is the file of another page beside this one, which is shown within.
    """

    heading: str
    text: str = ""
    table: PageTable | None = None
    figure: Any = None
    beside: Any = None
    warning: str = ""
    page: str = ""

    def markdown(self) -> str:
        """Heading, sentences and table in Markdown."""
        told = [f"### {self.heading}", self.text]
        if self.table is not None:
            lines = [self.table.headings, ["---"] * len(self.table.headings), *self.table.rows]
            told.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
        return "\n\n".join(told)


def unwrapped(text: str) -> str:
    """Text whose lines end where a page's do; those of a file end where its writer broke them."""
    return "\n\n".join(" ".join(each.split()) for each in re.split(r"\n\s*\n", text.strip()))


def write_page(path: Path, title: str, lead: str, sections: Sequence[Section]) -> None:
    """Write the page, which ends with the versions of software; `lead` is the answer in a sentence or two."""
    shown = [*sections, Section("Versions", table=_versions())]
    html = rendered("page.html.j2", title=title, lead=lead, sections=shown, packed=_packed(sections))
    path.write_text(html, encoding="utf-8")


def rendered(template: str, **content: Any) -> str:
    """Page of a template in this folder, which may include others of it."""
    return _environment().get_template(template).render(content)


@cache
def _environment() -> Environment:
    """What turns templates into pages; it keeps them compiled, which takes longer than to fill them in."""
    from jinja2 import Environment, PackageLoader, select_autoescape

    loader = PackageLoader("warmlink.orchestration", "report")
    escaping = select_autoescape(default=True)
    environment = Environment(loader=loader, autoescape=escaping, finalize=_printable)
    environment.filters |= {"with_code": _with_code, "breakable": _breakable}
    environment.globals["many"] = MANY
    return environment


def _printable(value: object) -> object:
    """Give what stands in a page, without marks that turn the direction of writing."""
    return type(value)(printable(value)) if isinstance(value, str) else value


def _with_code(text: object) -> Markup:
    """Text in which what stands between backticks is shown as code."""
    from markupsafe import Markup, escape

    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def _breakable(text: object) -> Markup:
    """The same of a name, which a narrow page may break before a part of it rather than anywhere."""
    from markupsafe import Markup

    shown = _with_code(text)
    return shown if "<" in shown else Markup(re.sub(r"(?<=\w)([._])(?=[a-z])", r"\1<wbr>", str(shown)))


def _versions() -> PageTable:
    rows = [("Python", platform.python_version()), ("machine", f"{platform.system()} {platform.machine()}")]
    for package in PACKAGES:
        try:
            rows.append((package, metadata.version(package)))
        except metadata.PackageNotFoundError:
            continue
    return PageTable(("software", "version"), rows)


def _packed(sections: Sequence[Section]) -> str:
    """Plotly's library and the figures by the number of their section, compressed; empty without figures."""
    from plotly.offline import get_plotlyjs

    figures = {
        f"{i}-{place}": figure
        for i, each in enumerate(sections, 1)
        for place, figure in enumerate((each.figure, each.beside), 1)
        if figure is not None
    }
    drawn = [f'"{place}":{printable_json(figure.to_json())}' for place, figure in figures.items()]
    if not drawn:
        return ""
    library, script = get_plotlyjs().encode(), f"\nconst figures = {{{','.join(drawn)}}};".encode()
    # The library, nearly all of the page, is compressed once and kept: what follows continues its stream.
    rest = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    begun = kept("plotly", metadata.version("plotly"), lambda: _begun(library))
    checksum = zlib.adler32(script, zlib.adler32(library)).to_bytes(4, "big")
    return base64.b64encode(begun + rest.compress(script) + rest.flush() + checksum).decode()


def _begun(content: bytes) -> bytes:
    """The beginning of a compressed stream, which does not end with its content."""
    begun = zlib.compressobj()
    return begun.compress(content) + begun.flush(zlib.Z_FULL_FLUSH)
