"""Names that strangers chose steer no terminal, turn no page's text, and are no formulas in a spreadsheet."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path

import pandas as pd
import pytest
from rich.text import Text

from tests.orchestration.simulated import called
from warmlink.fmus.safe_text import as_cell, of_cell, printable, printable_json, write_frame
from warmlink.orchestration import console
from warmlink.orchestration.cli import main
from warmlink.orchestration.progress import progress_bar, spinner
from warmlink.orchestration.report.figures import time_plot
from warmlink.orchestration.report.page import PageTable, Section, write_page
from warmlink.orchestration.report.recorded import columns_of
from warmlink.orchestration.scenarios.logged.sheet import read_sheet
from warmlink.orchestration.system.model import Connection, DefaultExperiment, FmuPart, System
from warmlink.orchestration.system.write import write_ssp

pytestmark = pytest.mark.usefixtures("in_a_fresh_folder")

FORMULAS = ["=cmd|'/C calc'!A0", "@SUM", "+1", "-x", "'=1", "a;=2", "'''@b", "＝1"]
STEERING = ["a\x9b2Jb", "c\u202ed", "e\u2066f\u2069", "g\u200fh", "i\x85j", "k\x7fl"]
RAW = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")
STARTS = tuple("=+-@＝＋－＠")


def named(fmu: Path, names: list[str]) -> Path:
    """A system whose components have such names; the first one drives the last."""
    parts = {name: FmuPart(name, fmu) for name in names}
    wires = (Connection(names[0], "y", names[-1], "u"),)
    path = Path("named.ssp")
    write_ssp(System("named", parts, wires, DefaultExperiment(0.0, 1.0, 0.5)), path)
    return path


@pytest.mark.parametrize("name", [*FORMULAS, "x", "time [s]", "a,-b", "\t=3", "a\n=4", "'", "''x", "- 1"])
def test_a_cell_gives_its_text_back(name: str) -> None:
    cell = as_cell(name)
    assert of_cell(cell) == name
    for split in re.split("[;\t\n]", cell):  # by a spreadsheet of another country
        assert not split.startswith(STARTS)


def test_results_hold_no_formula_and_are_found_by_their_real_names(fmu: Path) -> None:
    assert called(named(fmu, FORMULAS), "--out", "o") == 0
    with Path("o/results.csv").open(encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    assert not any(cell.startswith(STARTS) for each in header for cell in each.split(";"))
    headings = ["time [s]", *(f"{name}.{output} [1]" for name in FORMULAS for output in ("y", "z"))]
    assert set(headings) <= set(pd.read_parquet("o/results.parquet").columns)
    assert set(headings) <= set(columns_of("o/results.csv").names)
    assert {name for name in read_sheet(Path("o/results.csv")).headers if name[0] in "@+-="}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["warmlink", "plot", "o/results.csv", "@SUM.y", "--out", "p.html"])
        with pytest.raises(SystemExit) as ended:
            main()
    assert not ended.value.code
    assert len(rows) == 3


def test_a_table_of_text_holds_no_formula() -> None:
    frame = pd.DataFrame({"=h": FORMULAS, "number": [-1.5] * len(FORMULAS)})
    write_frame(frame, Path("t.csv"))
    header, *rows = csv.reader(io.StringIO(Path("t.csv").read_text("utf-8")))
    assert (of_cell(header[0]), [of_cell(row[0]) for row in rows]) == ("=h", FORMULAS)
    assert not any(row[0].startswith(STARTS) for row in [header, *rows])
    assert {row[1] for row in rows} == {"-1.5"}, "numbers stay numbers"


def test_names_reach_no_terminal_raw(fmu: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = named(fmu, STEERING)
    assert called(path, "--out", "o") == 0
    assert called(path, "--out", "s", "--statistics") == 0
    assert called(path, "--out", "r", "--record", "c\u202ed.yy") == 2
    out, err = capfd.readouterr()
    assert not RAW.search(out + err)
    assert "c\\u202ed.y" in out
    assert "c\\u202ed.y" in err
    assert set(columns_of("o").names) >= {f"{name}.y [1]" for name in STEERING}


@pytest.mark.parametrize("raw", STEERING)
def test_whatever_is_printed_is_printable(raw: str, capfd: pytest.CaptureFixture[str]) -> None:
    console.answer(raw)
    console.remark(raw)
    console.print_table(raw, (raw, "b"), [(raw, Text(raw, "bold"))], texts=2, width=80)
    console.answer_json({raw: raw})
    out, err = capfd.readouterr()
    assert not RAW.search(out.replace("\x7f", "") + err)
    assert out.count(printable(raw)) >= 5
    assert printable("two\nlines\tand ä µ 😀") == "two\nlines\tand ä µ 😀"


@pytest.mark.parametrize("what", ["{0}[bold]:smile:", "\x9b2J\u202e"])
def test_progress_takes_any_name(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a terminal, where it is drawn by a library that reads markup and format fields."""
    shown = io.StringIO()
    shown.isatty = lambda: True  # type: ignore[method-assign]
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setattr("sys.stderr", shown)
    with progress_bar(what) as share:
        share(0.5, what)
    with spinner(what) as doing:
        doing(what)
    assert shown.getvalue().count(printable(what)) >= 2
    assert not {"\x9b", "\u202e"} & set(shown.getvalue())


def test_a_page_turns_no_text(capsys: pytest.CaptureFixture[str]) -> None:
    raw = "c\u202ed<b>`x`"
    lines = {raw: [1.0, 2.0]}
    figure = time_plot([0.0, 1.0], lines, raw)
    write_page(
        Path("p.html"), raw, raw, [Section(raw, raw, PageTable((raw,), [(raw,)]), figure, warning=raw)]
    )
    text = Path("p.html").read_text("utf-8")
    assert not RAW.search(text)
    assert text.count("c\\u202ed&lt;b&gt;") >= 5
    assert json.loads(printable_json(figure.to_json()))["data"][0]["name"] == "c\\u202ed<b>`x`"


def test_json_keeps_all_but_what_steers() -> None:
    held = {"a\u202eb": ["\\u202e", "\x9b", "\U0001f600", "\n", 1.5]}
    for ascii_only in (True, False):
        found = json.loads(printable_json(json.dumps(held, ensure_ascii=ascii_only)))
        assert found == {"a\\u202eb": ["\\u202e", "\\x9b", "\U0001f600", "\n", 1.5]}


def test_a_summary_is_printable_in_a_notebook_too() -> None:
    class Named(console.Answer):
        def summary(self) -> str:
            return "a\u202eb"

    assert repr(Named()) == "a\\u202eb"
    assert Named()._repr_html_() == "<pre>a\\u202eb</pre>"
