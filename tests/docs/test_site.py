"""The site's reference is whole: every entry of every file, every command and option, every cause."""

from __future__ import annotations

import inspect
import re
import shlex
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import typer

import warmlink as wl
from tests.documented import DOCS, blocks, reference, results, texts
from warmlink.controllers.interface import SENSED
from warmlink.fmus.catalogue import catalogue as components
from warmlink.orchestration.cli import application, ours
from warmlink.orchestration.command_line.init import KINDS, kinds
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.replay.compare import COLUMNS as LOG_COLUMNS
from warmlink.orchestration.scenarios.duties.recorded import RECORDED
from warmlink.orchestration.studies.compare import COLUMNS
from warmlink.orchestration.system.units import parse_unit
from warmlink.orchestration.written.tables import json_schema

API = DOCS / "reference" / "api.md"


def entries(schema: dict[str, Any]) -> list[str]:
    tables = [schema, *schema.get("$defs", {}).values()]
    return sorted(name for table in tables for name in table.get("properties", ()))


@pytest.mark.parametrize("kind", kinds())
def test_every_entry_of_a_file_has_meaning_type_default_and_example(kind: str) -> None:
    page = reference.formats()[f"files/{kind}"]
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert sorted(row[0].strip("`") for row in rows) == entries(json_schema(kinds()[kind]))
    for row in rows:
        entry = dict(zip(reference.HEADS, row, strict=True))
        name, example = entry["entry"].strip("`"), entry["example"]
        assert name in example, name
        assert all(value for head, value in entry.items() if head != "unit or range"), name
        assert entry["unit or range"] or not re.search(r"\d [A-Za-z]", example), f"{name}: say its unit"
    assert not re.search(r"^## *$", page, re.MULTILINE)


def columns(name: str) -> dict[str, str]:
    """Units of the columns that the site describes, by name."""
    return {each.partition(" [")[0]: each.partition(" [")[2].rstrip("]") for each in results.said(name)}


def test_every_column_of_files_that_are_read_is_described() -> None:
    duty, run = columns("duty.csv"), columns("run.csv")
    assert duty.keys() == RECORDED.keys()
    for name, unit in RECORDED.items():
        assert parse_unit(duty[name]).exponents == parse_unit(unit).exponents
    inputs = {end.removeprefix("motor.") for end in rig("WarmupCell").externals if "motor." in end} - {
        "pad_mode"
    }
    assert run.keys() == {"time", *inputs, *SENSED, "elongation"}


def test_every_column_of_a_comparison_is_described() -> None:
    assert columns("compare.csv").keys() == set(COLUMNS)
    assert columns("logs.csv").keys() == set(LOG_COLUMNS)


def test_every_command_option_and_cause_is_there() -> None:
    page = reference.commands()
    assert re.findall(r"^## warmlink (\S+)$", page, re.MULTILINE) == list(ours())
    assert page.count("`--out ") >= 10
    causes = reference.causes()
    for cause in catalogue():
        assert f"| `{cause.name}` | {cause.sentence} |" in causes


def test_every_option_in_a_help_text_is_set_as_code() -> None:
    """A line broke after the dashes of one that was not."""
    told = re.sub(r"```.*?```|`[^`]*`", "", reference.commands(), flags=re.DOTALL)
    assert not re.findall(r"(?<![\w-])--[a-z]\S*", told)


def test_every_variable_of_the_components_is_there() -> None:
    page = reference.variables()
    for entry in components():
        for scalar in entry.component.scalars():
            assert f"| `{scalar.variable.name}` |" in page


def test_every_script_of_the_gallery_is_shown() -> None:
    shown = re.findall(r"^```\{gallery\} (\S+)$", (DOCS / "gallery.md").read_text("utf-8"), re.MULTILINE)
    scripts = [*(DOCS / "gallery").glob("*.py"), *(DOCS.parent / "examples").glob("*.py")]
    assert sorted(shown) == sorted(str(path.relative_to(DOCS.parent)) for path in scripts)
    pictured = [path for path in scripts if re.search(r"^figure = ", path.read_text("utf-8"), re.MULTILINE)]
    assert len(pictured) >= 12


def test_on_the_site_links_lead_to_its_pages() -> None:
    shown = generated()
    own = {page: texts.linked(page.read_text("utf-8"), page) for page in DOCS_PAGES}
    for page, text in {**shown, **own}.items():
        for target in re.findall(r"(?<!!)\[[^\]]+\]\((?!\w+:)([^)#\s]+)[^)]*\)", text):
            made = target.removeprefix("/generated/").removesuffix(".md")
            assert target.startswith("/"), f"{page} links to {target}, which the site does not show"
            assert made in generated() or (DOCS / target[1:]).is_file(), f"{page} links to {target}"
    theory = own[DOCS / "theory.md"]
    assert "[ThermalLink](/generated/components/ThermalLink.md)" in theory
    assert "[the theory](/theory.md)" in own[DOCS / "trust.md"]
    assert "[Commands](#commands)" not in own[texts.REFERENCE]


def test_each_page_that_is_made_from_code_has_a_heading_that_says_which_command_prints_it() -> None:
    text = texts.REFERENCE.read_text("utf-8")
    assert texts.made().keys() <= anchors(texts.REFERENCE)
    leading = set(
        re.findall(r"^#+ .*\n\n\[All of it\]\(/generated/(.*)\.md\)$", texts.adapted(texts.REFERENCE), re.M)
    )
    made = {*reference.pages()}
    components_alone = {page for page in made if page.startswith("components/")}
    assert leading == made - components_alone | {"components/index"}
    for line in re.findall(r"`warmlink ([a-z]+ [^`]+)`", text):
        name, *given = shlex.split(line)
        command = commands()[name]
        command.make_parser(command.context_class(command)).parse_args([*given])
        if name in ("schema", "init"):
            assert given == ["KIND"] or given[0] in {"schema": kinds(), "init": KINDS}[name], line


@cache
def commands() -> dict[str, Any]:
    """Every command as typer has it, by its name: what reads arguments."""
    group: Any = typer.main.get_command(application())
    found: dict[str, Any] = group.commands
    return found


@cache
def anchors(path: Path) -> set[str]:
    """Anchors of a Markdown file's headings, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ (.+)$", path.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", each.lower()).strip().replace(" ", "-") for each in headings}


@cache
def generated() -> dict[str, str]:
    """Pages that are made from the code and from texts of the checkout, by their names."""
    return {**texts.pages(), **reference.pages()}


RUN_BY_TESTS = {
    "docs/index.md": "docs/test_installation.py",
    "docs/cluster.md": "docs/test_cluster.py",
    "CONTRIBUTING.md": "test_contributing.py",
    "controllers/README.md": "orchestration/studies/test_own_law.py",
    "orchestration/diagnosis/README.md": "orchestration/diagnosis/causes/test_cause_catalogue.py",
    "docs/watch.md": "orchestration/watch/test_sources.py",
}
"""Tests of the texts whose blocks do not run when the site is built, or not all of them."""


def test_what_does_not_run_when_the_site_is_built_is_run_by_a_test() -> None:
    pages = [path for path in DOCS.rglob("*.md") if not {"generated", "decisions"} & {*path.parts}]
    shown = {str(path.relative_to(DOCS.parent)) for path in pages} | texts.SHOWN.keys()
    languages = ("sh", "python", "toml", "markdown")
    still = {name for name in shown if blocks((DOCS.parent / name).read_text("utf-8"), *languages)}
    assert still == RUN_BY_TESTS.keys()
    for name, test in RUN_BY_TESTS.items():
        assert Path(name).name in (DOCS.parent / "tests" / test).read_text("utf-8")
    # Templates, which their own test runs.
    made = {name for name, text in reference.pages().items() if blocks(text, *languages)}
    assert made <= {f"files/{kind}" for kind in kinds()}


NOT_OURS = {"generated", "out", "build", "dist", "node_modules"}
TEXTS = [
    path
    for path in sorted(DOCS.parent.rglob("*.md"))
    if not any(part in NOT_OURS or part.startswith(".") for part in path.relative_to(DOCS.parent).parts)
]
DOCS_PAGES = [
    path
    for path in TEXTS
    if path.is_relative_to(DOCS) and str(path.relative_to(DOCS.parent)) not in texts.SHOWN
]


@pytest.mark.parametrize("text", TEXTS, ids=lambda path: str(path.relative_to(DOCS.parent)))
def test_links_lead_somewhere_and_commands_can_be_given(text: Path) -> None:
    written = text.read_text("utf-8")
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", written):
        if "://" not in target:
            file = text.parent / target if target else text
            assert file.exists(), target
            assert not anchor or anchor in anchors(file), f"{target}#{anchor}"
    for line in re.findall(r"^(?:\.venv/bin/)?warmlink ([^|>\n]+)", written, re.MULTILINE):
        name, *given = shlex.split(line, comments=True)
        command = commands()[name]
        command.make_parser(command.context_class(command)).parse_args(given)
    for line in re.findall(r"^\|[^|]*\| `warmlink ([^`]+)`", written, re.MULTILINE):
        name, *given = shlex.split(line)
        command = commands()[name]
        command.make_parser(command.context_class(command)).parse_args(given)
    # What is not installed is there in the checkout alone.
    assert not re.search(r"python (-m benchmarks|examples/)", written) or "checkout" in written
    for name in re.findall(r"python -m benchmarks\.([a-z]\w+)", written):
        assert find_spec(f"benchmarks.{name}"), name
    for name in re.findall(r"`(\w+(?:/\w+)+\.py)`", written):
        made = text.name == "CONTRIBUTING.md"  # its recipes name files that the reader makes
        assert made or any((folder / name).is_file() for folder in (DOCS.parent, text.parent)), name


INSIDE = {
    "CONTRIBUTING.md": "its recipes add to the inside",
    "docs/theory.md": "computes the paper's expressions",
    "docs/gallery/equation_four.py": "draws the paper's expressions",
    "docs/gallery/modes.py": "shows what the design of an observer computes",
}
"""Texts and scripts that explain the inside, and import it; the reason of each."""

SHOWN_CODE = [
    *TEXTS,
    *(path for room in ("docs/gallery", "examples") for path in sorted((DOCS.parent / room).rglob("*.py"))),
]


def test_whoever_copies_from_texts_and_examples_needs_no_name_from_below_warmlink() -> None:
    imported = (
        r"^\s*(?:from|import) warmlink\.|^\s*from warmlink import .*\b(?:fmus|controllers|orchestration)\b"
    )
    found = {
        str(path.relative_to(DOCS.parent))
        for path in SHOWN_CODE
        if re.search(imported, path.read_text("utf-8"), re.MULTILINE)
    }
    assert found == INSIDE.keys()


def test_the_page_of_python_lists_every_public_name() -> None:
    listed = re.findall(r"^\.\. auto(?:function|class):: ([\w.]+)$", API.read_text("utf-8"), re.MULTILINE)
    assert {each.rpartition(".")[2] for each in listed} >= {*wl.__all__} - {"__version__"}


@pytest.mark.parametrize("name", [each for each in wl.__all__ if each.islower() and each != "__version__"])
def test_every_argument_of_the_interface_is_explained(name: str) -> None:
    said = re.findall(r"^(\w[\w, ]*)(?: : .*)?$", inspect.getdoc(getattr(wl, name)) or "", re.MULTILINE)
    explained = {argument for line in said for argument in line.split(", ")}
    assert set(inspect.signature(getattr(wl, name)).parameters) <= explained
