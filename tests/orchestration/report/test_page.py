"""A page of a result: its text, and that nothing in it is taken for HTML."""

from __future__ import annotations

from pathlib import Path

from warmlink.orchestration.report.page import PageTable, Section, write_page


def test_what_stands_between_backticks_is_shown_as_code(tmp_path: Path) -> None:
    table = PageTable(("use", "faces"), [("cooled, `convection_factor[1]`", "#1 <b>")])
    path = tmp_path / "page.html"
    write_page(
        path, "Title", "As `run` says.", [Section("Heading", "See `warmlink design <x>`; 1 < 2.", table)]
    )
    html = path.read_text("utf-8")
    assert "As <code>run</code> says." in html
    assert "See <code>warmlink design &lt;x&gt;</code>; 1 &lt; 2." in html
    assert "<td>cooled, <code>convection_factor[1]</code></td><td>#1 &lt;b&gt;</td>" in html
