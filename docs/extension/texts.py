"""Links of texts: the checkout's files in the sources, the site's pages where the site is built."""

from __future__ import annotations

import os
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"

SHOWN = {
    "CONTRIBUTING.md": "contributing",
    "CHANGELOG.md": "changelog",
    "controllers/README.md": "controllers",
    "orchestration/diagnosis/README.md": "diagnosis",
    "docs/compatibility.md": "compatibility",
    "fmus/reduced_link/README.md": "reduced-link",
    **{
        str(path.relative_to(ROOT)): f"decisions/{'index' if path.stem == 'README' else path.stem}"
        for path in sorted((DOCS / "decisions").glob("*.md"))
    },
}
"""Page by the text that it shows."""

REFERENCE = DOCS / "reference" / "index.md"
"""Says which command prints what a page that is made from the code shows, under a heading for each page."""

_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)#\s]*)(#[^)\s]*)?\)")


def pages() -> dict[str, str]:
    """Text of each page by its name; the page of decisions lists the others."""
    found = {page: adapted(ROOT / source) for source, page in SHOWN.items()}
    of_its_own = "The FMU's own documentation lists them, as they depend on the part."
    found["reduced-link"] = found["reduced-link"].replace("<!-- variables -->", of_its_own)
    others = [page.partition("/")[2] for page in SHOWN.values() if page.startswith("decisions/")]
    listed = "\n".join(page for page in others if page != "index")
    found["decisions/index"] += f"\n```{{toctree}}\n:hidden:\n{listed}\n```\n"
    return found


def adapted(source: Path) -> str:
    """Text of a Markdown file with the links of the site."""
    return linked(source.read_text("utf-8"), source)


def linked(text: str, source: Path) -> str:
    """A text that stands in a file, with links to pages of the site; one to what is no page becomes its name.

    The headings of the reference lead to the pages that are made from the code.
    """

    def link(found: re.Match[str]) -> str:
        name, target, anchor = found[1], found[2], found[3] or ""
        if "://" in target or not target:
            return found[0]
        page = page_of(Path(os.path.normpath(source.parent / target)), anchor)
        return f"[{name}]({page})" if page else name

    fenced = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    text = "".join(part if part.startswith("```") else _LINK.sub(link, part) for part in fenced)
    if source != REFERENCE:
        return text
    for anchor, page in made().items():
        heading = re.compile(f"^(#+ {anchor.replace('-', ' ')})$", re.IGNORECASE | re.MULTILINE)
        text = heading.sub(f"\\1\n\n[All of it](/generated/{page}.md)\n", text)
    return text


def page_of(path: Path, anchor: str = "") -> str:
    """Where the site shows a file of the checkout, from the site's root; empty if it does not."""
    if path == REFERENCE and anchor.removeprefix("#") in made():
        return f"/generated/{made()[anchor.removeprefix('#')]}.md"
    name = path.relative_to(ROOT)
    shown = SHOWN.get(str(name)) or SHOWN.get(str(name / "README.md")) or component_pages().get(name)
    if shown:
        return f"/generated/{shown}.md{anchor}"
    is_page = path.suffix == ".md" and path.is_file() and path.is_relative_to(DOCS)
    return f"/{path.relative_to(DOCS)}{anchor}" if is_page else ""


@cache
def made() -> dict[str, str]:
    """Page that is made from the code, by the anchor of its heading in the reference."""
    from warmlink.orchestration.command_line.init import kinds

    alone = {name: name for name in ("commands", "names", "causes", "variables")}
    return {
        **alone,
        "components": "components/index",
        **{f"{kind}-file": f"files/{kind}" for kind in kinds()},
    }


@cache
def component_pages() -> dict[Path, str]:
    """Page of each component by the path of its README and of its folder."""
    from warmlink.fmus.catalogue import catalogue

    found = {}
    for entry in catalogue():
        readme = Path(*entry.module.split(".")[1:-1], "README.md")
        found[readme] = found[readme.parent] = f"components/{entry.component.name}"
    return found
