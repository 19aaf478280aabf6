"""A page of a result: its text, and that nothing in it is taken for HTML."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.report.closed_loop import _changed
from warmlink.orchestration.report.page import MANY, PageTable, Section, unwrapped, write_page


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


def test_lines_of_a_file_end_where_those_of_the_page_do() -> None:
    text = "\nBack and forth, the demands of the\npaper's case.\n\nSecond\nparagraph.\n"
    assert unwrapped(text) == "Back and forth, the demands of the paper's case.\n\nSecond paragraph."
    assert unwrapped("") == ""


def test_an_array_of_parameters_takes_one_row_of_the_settings() -> None:
    noise = {f"sensors.noise[{i}]": 0.1 for i in range(1, 9)}
    positions = {"link.sensor_position[2]": "200 mm", "link.sensor_position[4]": 0.25}
    given = {"link.length": "400 mm", "motor.joint_conductance": 1.2, **noise, **positions}
    given |= {"compensator.mode_rate[1]": -1e-3, "compensator.mode_rate[2]": -2e-3}
    scenario = replace(load_scenario("stop_and_go"), parameters=given)
    assert _changed(scenario) == {
        "link.length": "400 mm",
        "motor.joint_conductance": "1.2 W/K",
        "sensors.noise[1..8]": "0.1 K",
        "link.sensor_position[2]": "200 mm",
        "link.sensor_position[4]": "0.25 m",
        "compensator.mode_rate[1..2]": "2 values",
    }


def test_names_may_be_broken_before_their_parts_and_long_tables_are_folded(tmp_path: Path) -> None:
    path, rows = tmp_path / "page.html", [("link.sensor_position[2]", "0.5_a")] * MANY
    write_page(path, "Title", "Lead.", [Section("Short", table=PageTable(("name", "value"), rows))])
    html = path.read_text("utf-8")
    assert "<td>link.<wbr>sensor_<wbr>position[2]</td><td>0.5_a</td>" in html
    assert "<details>" not in html
    write_page(
        path, "Title", "Lead.", [Section("Long", table=PageTable(("name", "value"), [*rows, ("<b>_a", "")]))]
    )
    html = path.read_text("utf-8")
    assert f"<details><summary>{MANY + 1} rows</summary>" in html
    assert "<td>&lt;b&gt;_a</td>" in html
