"""`warmlink live` in a real browser: its numbers, and what happens when something is moved."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser import browse
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import build_native_fmus
from warmlink.orchestration.command_line.live import live
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.load import load_scenario
from warmlink.orchestration.scenarios.metrics import error_metrics
from warmlink.orchestration.scenarios.run import changed
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.assemble import component
from warmlink.orchestration.system.model import DefaultExperiment, System

LARGEST = 2_500_000
"""Bytes that a page may have."""

CHANGED = {"motor.joint_conductance": "2 W/K"}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('ziglang is not installed: pip install "warmlink[live]"')
    path = tmp_path_factory.mktemp("live") / "cell.html"
    live("windshield_wiper", ["lag"], None, None, path)
    return path


def errors(scenario: Scenario, folder: Path) -> dict[str, Any]:
    """Error of the tool point by the native FMU of the whole system, in m."""
    (fmu,) = build_native_fmus([Entry(scenario.joined(), "warmlink.orchestration.system.shipped")], folder)
    stop = scenario.stop_time
    system = System("Alone", {"whole": component("whole", fmu)}, (), DefaultExperiment(0.0, stop, 1.0))
    result = simulate(system, stop, 1.0)
    return {
        name: expression.value(lambda each: result[f"whole.{each}"])
        for name, expression in (
            ("none", scenario.setup.roles.uncompensated),
            ("lag", scenario.setup.roles.score),
        )
    }


@pytest.mark.slow
@pytest.mark.platform
def test_the_page_gives_the_native_numbers_at_every_step(page: Path, tmp_path: Path) -> None:
    """A slider is set as a reader sets it; both errors are the native run's to the last bit."""
    script = """
        model.setValue("motor.joint_conductance", 2);
        await new Promise((drawn) => setTimeout(drawn, 500));
        const { errors } = results(model);
        const listed = Object.entries(errors).map(([law, error]) => [law, [...error]]);
        const answer = document.getElementById("answer").textContent;
        const result = { errors: Object.fromEntries(listed), answer };
    """
    found = browse(page, script, tmp_path)
    scenario = changed(load_scenario("windshield_wiper"), parameters=CHANGED)
    for law, expected in errors(scenario, tmp_path).items():
        np.testing.assert_array_equal(found["errors"][law], expected)
        metrics = error_metrics(np.arange(expected.size, dtype=float), expected, scenario.tolerance)
        assert f"{metrics.max_abs_um:.1f} µm" in found["answer"]


@pytest.mark.platform
def test_everything_on_the_page_moves_the_answer(page: Path, tmp_path: Path) -> None:
    script = """
        const wait = () => new Promise((drawn) => setTimeout(drawn, 300));
        const told = () => document.getElementById("lead").textContent;
        const seen = [told()];
        const slider = document.querySelector("#sliders input[type=range]");
        slider.value = 900;
        slider.dispatchEvent(new Event("input"));
        await wait();
        seen.push(told());
        const pull = (handle, dx, dy) => {
          const { x, y, width, height } = handle.getBoundingClientRect();
          const at = { clientX: x + width / 2, clientY: y + height / 2, bubbles: true, pointerId: 1 };
          document.querySelector("#duty figure").setPointerCapture = () => {};
          handle.dispatchEvent(new PointerEvent("pointerdown", at));
          const moved = { ...at, clientX: at.clientX + dx, clientY: at.clientY + dy };
          handle.dispatchEvent(new PointerEvent("pointermove", moved));
          document.querySelector("#duty figure").dispatchEvent(new PointerEvent("pointerup", at));
        };
        pull(document.querySelector('.handle[data-kind="speed"]'), 0, 60);
        await wait();
        seen.push(told());
        const { speed } = model.state.segments[0];
        document.querySelector('button[aria-label="split segment 1"]').click();
        await wait();
        pull(document.querySelector('.handle[data-kind="duration"]'), -100, 0);
        await wait();
        const [torque] = document.querySelectorAll('input[aria-label^="segment 2: torque"]');
        torque.value = "0";
        torque.dispatchEvent(new Event("change"));
        await wait();
        seen.push(told());
        model.setValue("link.tip_position", 5);
        await wait();
        const result = { seen, speed, first: model.state.segments.map(({ duration }) => duration),
          ranked: [...document.querySelectorAll(".slider")].map((each) => each.firstChild.textContent),
          fault: document.getElementById("fault").textContent };
    """
    found = browse(page, script, tmp_path)
    assert len(set(found["seen"])) == len(found["seen"])
    assert found["speed"][0] < 3.43
    assert found["first"][0] < found["first"][1] == 3600.0
    assert "link.expansion_coefficient" in found["ranked"]
    assert found["fault"].startswith("WarmupCell.link.tip_position: 5 m lies beyond")


@pytest.mark.platform
def test_the_page_is_light_and_needs_no_network(page: Path) -> None:
    assert page.stat().st_size < LARGEST
    text = page.read_text("utf-8")
    assert "http" not in text.replace("http://www.w3.org", "")


def test_without_a_compiler_for_browsers_the_page_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from warmlink.fmus.packaging.native import browser

    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(browser, "native_sources", lambda whole, speaker: ({}, ""))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"needs zig: pip install \"warmlink\[live\]\""):
        live("windshield_wiper", ["none"], None, None, tmp_path / "page.html")
    assert not list(tmp_path.glob("*.html"))


def test_a_page_is_html(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"page\.pdf: is no page; name a file that ends in \.html"):
        live("windshield_wiper", None, None, None, tmp_path / "page.pdf")
