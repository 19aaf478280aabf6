"""The site's reference is whole: every entry of every file, every command and option, every cause."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from extension import reference, texts  # noqa: E402
from warmlink.orchestration.cli import COMMANDS  # noqa: E402
from warmlink.orchestration.command_line.schema import kinds  # noqa: E402
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue  # noqa: E402
from warmlink.orchestration.scenarios.written import json_schema  # noqa: E402


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


def test_every_command_option_and_cause_is_there() -> None:
    page = reference.commands()
    assert re.findall(r"^## warmlink (\S+)$", page, re.MULTILINE) == list(COMMANDS)
    assert page.count("`--out ") >= 10
    for cause in catalogue():
        assert f"| `{cause.name}` | {cause.sentence} |" in reference.causes()


def test_every_script_of_the_gallery_is_shown() -> None:
    shown = re.findall(r"^```\{gallery\} (\S+)$", (DOCS / "gallery.md").read_text("utf-8"), re.MULTILINE)
    scripts = [*(DOCS / "gallery").glob("*.py"), *(DOCS.parent / "examples").glob("*.py")]
    assert sorted(shown) == sorted(str(path.relative_to(DOCS.parent)) for path in scripts)
    pictured = [path for path in scripts if re.search(r"^figure = ", path.read_text("utf-8"), re.MULTILINE)]
    assert len(pictured) >= 12


def test_links_in_texts_of_the_checkout_lead_somewhere() -> None:
    pages = texts.pages()
    known = {*pages, *reference.pages()}
    for page, text in pages.items():
        for target in re.findall(r"\(/generated/([^)]+)\.md\)", text):
            assert target in known, f"{page} links to {target}"
