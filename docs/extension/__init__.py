"""What the site computes when it is built: blocks that run, pictures, and pages made from the code."""

from __future__ import annotations

import re
import shutil
import time
from itertools import zip_longest
from pathlib import Path
from typing import Any

from extension import kept, reference, texts


def setup(app: Any) -> dict[str, Any]:
    """Register the directives, and the pages that are written before Sphinx reads."""
    from extension.blocks import File, Gallery, Keys, Run

    app.add_directive("run", Run)
    app.add_directive("file", File)
    app.add_directive("gallery", Gallery)
    app.add_directive("keys", Keys)
    app.add_html_math_renderer("mathml", (_inline_math, None), (_block_math, None))
    app.connect("autodoc-process-docstring", _explain, priority=400)
    app.connect("builder-inited", _write_pages)
    app.connect("env-before-read-docs", _count_pages)
    app.connect("doctree-read", lambda app, tree: app.progress.read(app.env.docname))
    app.connect("source-read", _with_links_of_the_site)
    app.connect("build-finished", _write_assets)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def _explain(app: Any, what: str, name: str, given: Any, options: Any, lines: list[str]) -> None:
    """Give Sphinx what stands after the colon of an entry as its meaning, not as its type."""
    for i in reversed(range(len(lines))):
        found = re.fullmatch(r"(\w[\w, ]*) : (\S.*)", lines[i])
        if found:
            lines[i : i + 1] = [found[1], f"    {found[2]}"]


def _inline_math(writer: Any, node: Any, block: bool = False) -> None:
    """Formulas as MathML, which browsers draw by themselves."""
    from docutils import nodes
    from docutils.utils.math.latex2mathml import tex2mathml

    writer.body.append(tex2mathml(node.astext(), as_block=block))
    raise nodes.SkipNode


def _block_math(writer: Any, node: Any) -> None:
    _inline_math(writer, node, block=True)


def _write_pages(app: Any) -> None:
    home = Path(app.srcdir) / "generated"
    shutil.rmtree(home, ignore_errors=True)
    for name, text in {**texts.pages(), **reference.pages()}.items():
        path = home / f"{name}.md"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")


def _with_links_of_the_site(app: Any, name: str, content: list[str]) -> None:
    """Sources link to what stands in a checkout."""
    if not name.startswith("generated/"):
        content[0] = texts.linked(content[0], Path(app.srcdir) / f"{name}.md")


def _count_pages(app: Any, env: Any, names: list[str]) -> None:
    """What is shown of a build's progress, and the code's digest, before other processes read the pages."""
    app.began = time.time()
    own = [name for name in names if not name.startswith("generated/")]
    made = [name for name in names if name.startswith("generated/")]
    app.progress = kept.Progress.over(own)
    kept.code_digest()
    _build_fmus()
    # A process reads a few pages in sequence: of those that run blocks, each gets its share.
    mixed = zip_longest(own, made[::2], made[1::2])
    names[:] = [name for group in mixed for name in group if name is not None]


def _build_fmus() -> None:
    """Build, once for all pages, the FMUs that are not kept from before."""
    import warmlink as wl
    from warmlink.fmus.catalogue import catalogue

    kept.tell("FMUs of this version, kept or built")
    wl.fmu_files([entry.component.name for entry in catalogue()])


def _write_assets(app: Any, failure: Exception | None) -> None:
    """Plotly's library, which the pictures need, and the page to play with."""
    if failure is not None:
        return
    from plotly.offline import get_plotlyjs

    from extension.blocks import ROOT, notebook

    out = Path(app.outdir)
    (out / "notebooks").mkdir(exist_ok=True)
    for path in (*ROOT.glob("examples/*.py"), *ROOT.glob("docs/gallery/*.py")):
        text = notebook(path.read_text("utf-8"))
        (out / "notebooks" / f"{path.stem}.ipynb").write_text(text, "utf-8")
    (out / "_static" / "plotly.min.js").write_text(get_plotlyjs(), "utf-8")
    results = Path(app.doctreedir).parent / "blocks"
    live = kept.alone(results, "live", "live.html", lambda: {"page": _live(out)})
    (out / "live.html").write_text(live["page"], "utf-8")
    kept.forget(results, app.began)


def _live(out: Path) -> str:
    """The page to play with."""
    import warmlink as wl
    from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO

    page = out / "live.html"
    wl.live(DEFAULT_SCENARIO, ["lag", "observer"]).write(page)
    return page.read_text("utf-8")
