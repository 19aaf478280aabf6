"""Texts of the checkout as pages of the site, with links that hold there."""

from __future__ import annotations

import os
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]

SHOWN = {
    "CONTRIBUTING.md": "contributing",
    "CHANGELOG.md": "changelog",
    "controllers/README.md": "controllers",
    "orchestration/diagnosis/README.md": "diagnosis",
    "docs/compatibility.md": "compatibility",
    "fmus/reduced_link/README.md": "reduced-link",
    **{
        str(path.relative_to(ROOT)): f"decisions/{'index' if path.stem == 'README' else path.stem}"
        for path in sorted((ROOT / "docs" / "decisions").glob("*.md"))
    },
}
"""Page by the text that it shows."""

_LINK = re.compile(r"\[([^\]]+)\]\(([^)#\s]+)(#[^)\s]*)?\)")


def pages() -> dict[str, str]:
    """Text of each page by its name; the page of decisions lists the others."""
    found = {page: adapted(ROOT / source, page) for source, page in SHOWN.items()}
    of_its_own = "The FMU's own documentation lists them, as they depend on the part."
    found["reduced-link"] = found["reduced-link"].replace("<!-- variables -->", of_its_own)
    others = [page.partition("/")[2] for page in SHOWN.values() if page.startswith("decisions/")]
    listed = "\n".join(page for page in others if page != "index")
    found["decisions/index"] += f"\n```{{toctree}}\n:hidden:\n{listed}\n```\n"
    return found


def adapted(source: Path, page: str, components: dict[Path, str] | None = None) -> str:
    """Text of a Markdown file as the page `generated/PAGE`; a link to what is no page becomes its name."""

    def link(found: re.Match[str]) -> str:
        text, target = found[1], found[2]
        if "://" in target:
            return found[0]
        path = Path(os.path.normpath(source.parent / target)).relative_to(ROOT)
        shown = SHOWN.get(str(path)) or (components or component_pages()).get(path)
        return f"[{text}](/generated/{shown}.md)" if shown else text

    fenced = re.split(r"(^```.*?^```$)", source.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("```") else _LINK.sub(link, part) for part in fenced)


def component_pages() -> dict[Path, str]:
    """Page of each component by the path of its README and of its folder."""
    from warmlink.fmus.catalogue import catalogue

    found = {}
    for entry in catalogue():
        readme = Path(*entry.module.split(".")[1:-1], "README.md")
        found[readme] = found[readme.parent] = f"components/{entry.component.name}"
    return found
