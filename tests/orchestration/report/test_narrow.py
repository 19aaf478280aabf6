"""Pages of results on a telephone and on a large screen, and a look for each controller on all of them."""

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.browser import Browser
from tests.chromium import Chromium
from warmlink.orchestration.catalogue import controllers
from warmlink.orchestration.command_line.diagnose import diagnose, hide
from warmlink.orchestration.command_line.laws import design
from warmlink.orchestration.report.figures import LOOK_OF, LOOKS, heat_map, looks_of, time_plot
from warmlink.orchestration.report.live.content import _plot as live_plot
from warmlink.orchestration.report.page import PageTable, Section, write_page
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER

LAWS = ("none", "lag", "observer", "observer_drift", "regression")
DRAWN = """(async () => {
  const found = () => [...document.querySelectorAll(".figure")];
  const begun = () => document.readyState === "complete" && found().length;
  while (!begun() || found().some((each) => !each.querySelector(".main-svg .infolayer *")))
    await new Promise((go) => setTimeout(go, 50));
  const figures = found();
  const { scrollWidth } = document.documentElement;
  const boxes = [...document.querySelectorAll("main .main-svg, main table")].map((each) => {
    const box = each.closest(".scroll"), { left } = box.getBoundingClientRect();
    return each.getBoundingClientRect().right - left + box.scrollLeft - box.scrollWidth;
  });
  const hidden = figures.map((each) => each.parentElement.scrollWidth - each.parentElement.clientWidth);
  const names = [...document.querySelectorAll(".xtick")].map((each) => {
    const { left, right } = each.getBoundingClientRect();
    return [each.textContent, left, right];
  });
  return { scrollWidth, beyond: Math.max(0, ...boxes), hidden: Math.max(0, ...hidden), names };
})()"""


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Chromium.started(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with the heat map and the wide table of a comparison."""
    path = tmp_path_factory.mktemp("compared") / "page.html"
    rows = ("stop_and_go", "overnight_stop_and_warm_restart")
    texts = [["57.2", *["12.0<br>79 %"] * 4]] * 2
    figure = heat_map(LAWS, rows, np.full((2, 5), 12.0), texts, 5.0, "µm")
    table = PageTable(("duty cycle", *LAWS), [(name, *["-1234.5"] * 5) for name in rows])
    write_page(path, "Compared", "Lead.", [Section("Map", figure=figure, table=table)])
    return path


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("diagnosed")
    hide(["radiation"], out=folder / "run.csv")
    diagnose([folder / "run.csv"], out=folder / "found")
    return folder / "found" / "report.html"


@pytest.mark.parametrize("width", [400, 1300])
def test_every_controller_of_a_comparison_is_seen(chromium: Browser, compared: Path, width: int) -> None:
    chromium.open(compared, width)
    found = chromium.evaluate(DRAWN)
    assert found["scrollWidth"] <= width
    assert found["beyond"] < 1
    assert found["hidden"] == 0
    assert {name for name, *_ in found["names"]} == set(LAWS)
    assert all(0 <= left < right <= width for _, left, right in found["names"])
    ends = sorted((left, right) for _, left, right in found["names"])
    assert all(before[1] < after[0] for before, after in pairwise(ends))


@pytest.mark.parametrize("width", [400, 1300])
def test_tables_and_residuals_of_a_diagnosis_are_seen(chromium: Browser, diagnosed: Path, width: int) -> None:
    chromium.open(diagnosed, width)
    found = chromium.evaluate(DRAWN)
    assert found["scrollWidth"] <= width
    assert found["beyond"] < 1
    assert found["hidden"] == 0


@pytest.mark.parametrize("width", [400, 1300])
def test_the_bode_plots_of_a_design_are_seen(chromium: Browser, tmp_path: Path, width: int) -> None:
    pytest.importorskip("control")
    design(["WarmupCell"], law="observer", out=tmp_path / "observer.ssv", report=tmp_path / "design.html")
    chromium.open(tmp_path / "design.html", width)
    found = chromium.evaluate(DRAWN)
    assert found["scrollWidth"] <= width
    assert found["beyond"] < 1
    assert found["hidden"] == 0


def test_a_controller_has_one_look_on_all_pages() -> None:
    lines = {name: [0.0, 1.0] for name in ("mine", "lag", "none")}
    drawn = json.loads(time_plot([0.0, 1.0], lines, "error [µm]").to_json())["data"]
    own = {each["name"]: (each["line"]["color"], each["line"]["dash"]) for each in drawn}
    assert own["none"] == ("#5b6577", "solid")
    assert len(set(own.values())) == 3
    asked = [{"name": NO_CONTROLLER, "law": ""}, {"name": "lag", "law": "lag"}, {"name": "x", "law": "mine"}]
    live = {line["name"]: LOOKS[int(line["style"])] for line in live_plot("", "", asked)["lines"]}
    assert live["none"].line() == {"color": "#5b6577", "dash": "solid", "width": 2}
    assert (live["lag"].line()["color"], live["lag"].line()["dash"]) == own["lag"]


def test_every_shipped_law_has_a_look_of_its_own() -> None:
    shipped = {NO_CONTROLLER, *controllers()}
    assert shipped <= LOOK_OF.keys()
    assert len({LOOK_OF[name] for name in shipped}) == len(shipped)
    assert looks_of(["none", "mine", "observer", "other"]) == [0, 1, 2, 3]
