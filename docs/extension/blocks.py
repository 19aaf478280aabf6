"""Directives whose content runs when the site is built, and is shown with what came of it.

`run sh` and `run python` run in a folder of the page, one block after another; `file NAME` writes a file
there. A Plotly figure that a block calls `figure` is drawn. A block that fails fails the build. Results are
kept from build to build: see kept.py.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import re
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from extension import results
from extension.kept import Content, Page, alone
from extension.reference import markdown_table
from warmlink.orchestration.report.figures import styled

ROOT = Path(__file__).parents[2]

LOG = logging.getLogger(__name__)
"""A warning fails the build, once everything has been tried."""


_PAGES: dict[str, Page] = {}


class Block(SphinxDirective):
    """A block that belongs to the place of its page."""

    has_content = True
    required_arguments = 1

    @property
    def out(self) -> Path:
        """Folder of all that the site is built in."""
        return Path(self.env.doctreedir).absolute().parent

    @property
    def page(self) -> Page:
        """Where this page's blocks run."""
        name = self.env.docname
        if name not in _PAGES:
            _PAGES[name] = Page(self.out / "doctrees" / "blocks" / name, self.out / "blocks")
        return _PAGES[name]

    @property
    def where(self) -> str:
        """Page and line of this block."""
        return f"{self.env.docname}:{self.lineno}"

    @property
    def up(self) -> str:
        """Way from this page to the first one's folder."""
        return "../" * self.env.docname.count("/")

    def shown(self, text: str, language: str, css: str = "") -> nodes.Node:
        """Text as a block of code."""
        return nodes.literal_block(text, text, language=language, classes=[css] if css else [])

    def nodes_of(self, came: Content) -> list[nodes.Node]:
        """What Python printed, and its figure; `static/figures.js` draws it in the colours of the page."""
        found = [self.shown(came["printed"], "text", "output")] if came["printed"] else []
        if came.get("figure"):
            content = came["figure"].replace("</", "<\\/")
            html = (
                f'<script src="{self.up}_static/plotly.min.js" defer></script>'
                f'<div class="figure-scroll"><div class="drawn" style="min-height:{came["height"]}px;'
                f'min-width:{came["width"]}px">'
                f'<script type="application/json">{content}</script></div></div>'
            )
            found.append(nodes.raw("", html, format="html"))
        return found


def in_python(source: str, name: str, names: dict[str, Any], folder: Path) -> Content:
    """Run Python in a folder; give what it printed, and its figure in the reports' look."""
    printed, failed = io.StringIO(), False
    before = Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(printed):
            exec(compile(ast.parse(source), name, "exec"), names)
    except Exception:
        failed = True
        LOG.warning("%s: %s", name, traceback.format_exc())
    finally:
        os.chdir(before)
    came = {"printed": printed.getvalue().rstrip(), "failed": failed}
    figure = names.pop("figure", None)
    if figure is None:
        return came
    if figure.layout.meta is None:  # made by plotly alone
        styled(figure, figure.layout.height or 360)
    sizes = {"height": figure.layout.height or 360, "width": figure.layout.meta or 10}
    return {**came, "figure": figure.to_json(), **sizes}


class Run(Block):
    """Commands or Python that run; `:refused:` where exit code 2 and its sentence are what is shown."""

    option_spec: ClassVar = {"refused": directives.flag, "hide-output": directives.flag}

    def run(self) -> list[nodes.Node]:
        """Run the block."""
        source, kind, page = "\n".join(self.content), self.arguments[0], self.page
        said = f"{source}\n{kind} {sorted(self.options)}"
        if kind == "python":
            came = page.result(
                said, self.where, lambda: in_python(source, self.where, page.names, page.folder)
            )
            return [self.shown(source, "python"), *self.nodes_of(came)]
        came = page.result(said, self.where, lambda: self._in_shell(source))
        nothing = not came["printed"] or "hide-output" in self.options
        return [
            self.shown(source, "sh"),
            *([] if nothing else [self.shown(came["printed"], "text", "output")]),
        ]

    def _in_shell(self, source: str) -> Content:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", source],
            cwd=self.page.folder,
            env={**os.environ, "PATH": path, "COLUMNS": "100"},
            capture_output=True,
            text=True,
        )
        wanted = 2 if "refused" in self.options else 0
        failed = done.returncode != wanted
        if failed:
            told = f"{source}\n{done.stderr}{done.stdout}"
            LOG.warning("%s: exit code %s: %s", self.where, done.returncode, told)
        came = (done.stderr if wanted else done.stdout).replace(str(self.page.folder), "/home/you")
        printed = re.sub(r"[ \t]+$", "", came, flags=re.MULTILINE).rstrip()
        return {"printed": printed, "failed": failed}


class File(Block):
    """A file that the reader writes; `:from:` takes its text from the checkout."""

    option_spec: ClassVar = {"from": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """Write it, and show it under its name."""
        name, text = self.arguments[0], "\n".join(self.content)
        if "from" in self.options:
            path = ROOT / self.options["from"]
            self.env.note_dependency(str(path))
            text = path.read_text("utf-8").rstrip()
        file = self.page.folder / name
        self.page.before_the_next(f"{name}\n{text}", lambda: file.write_text(text + "\n", "utf-8"))
        caption = nodes.paragraph("", "", nodes.literal(name, name), classes=["file-name"])
        return [
            caption,
            self.shown(text, {"py": "python", "toml": "toml"}.get(name.rpartition(".")[2], "text")),
        ]


class Keys(Block):
    """Table of the keys of a JSON file, or columns of a table, with examples from the given files."""

    has_content = False
    optional_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Make the table."""
        name, paths = self.arguments[0], " ".join(self.arguments[1:]).split()
        files = [self.page.folder / path for path in paths]
        came = self.page.result(
            f"{name} {paths}",
            self.where,
            lambda: {"contents": [results.content_of(file) for file in files]},
        )
        contents = came["contents"]
        rows, missing = results.rows(name, contents)
        unknown = [key for content in contents for key in results.undescribed(name, content)]
        for told, keys in (("no example in results.toml", missing), ("not in results.toml", unknown)):
            if keys:
                LOG.warning("%s: %s: %s: %s", self.env.docname, name, told, ", ".join(keys))
        heads = ("key" if name.endswith(".json") else "column", *results.HEADS)
        return self.parse_text_to_nodes(markdown_table(heads, rows))


class Gallery(Block):
    """A script with a docstring, run: its title, what it says, its picture, what it prints, and its code."""

    def run(self) -> list[nodes.Node]:
        """Run the script of the given path in the checkout."""
        path = ROOT / self.arguments[0]
        self.env.note_dependency(str(path))
        source = path.read_text("utf-8")
        title, about, code = parts_of(source)
        names = {"__name__": "__main__", "__file__": str(path)}
        where = f"{self.env.docname}: {self.arguments[0]}"
        folder = self.page.folder
        came = alone(self.page.kept, source, where, lambda: in_python(source, str(path), names, folder))
        found = self.nodes_of(came)
        section = nodes.section(ids=[nodes.make_id(title)], names=[nodes.fully_normalize_name(title)])
        section += nodes.title(title, title.rstrip("."))
        section += self.parse_text_to_nodes(" ".join(about.split()))
        section += [each for each in found if isinstance(each, nodes.raw)]
        printed = [each for each in found if not isinstance(each, nodes.raw)]
        for each in printed:
            each["classes"].append("wrapped")
        section += printed
        section += nodes.raw("", f"<details><summary>{path.relative_to(ROOT)}</summary>", format="html")
        section += self.shown(code, "python")
        link = f'<a href="{self.up}notebooks/{path.stem}.ipynb" download>The same as a notebook</a>'
        section += nodes.raw("", f"{link}</details>", format="html")
        return [section]


def parts_of(source: str) -> tuple[str, str, str]:
    """Title, what follows it in the docstring, and code of a script."""
    title, _, about = (ast.get_docstring(ast.parse(source)) or "").partition("\n\n")
    return title, about, source.split('"""', 2)[2].strip()


def notebook(source: str) -> str:
    """A script as a Jupyter notebook."""
    title, about, code = parts_of(source)
    shown = f"{code}\nfigure.show()" if re.search(r"^figure = ", code, re.MULTILINE) else code
    cells: list[dict[str, Any]] = [
        {"cell_type": "markdown", "metadata": {}, "source": f"# {title}\n\n{about}"},
        {"cell_type": "code", "metadata": {}, "source": shown, "execution_count": None, "outputs": []},
    ]
    return json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 4}, indent=1)
