"""`warmlink live` of a recorded duty that changes in every row, in a real browser."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.browser import Browser
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.packaging.native.fmu import build_native_fmus
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.command_line.pages import live
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.products.build import JOINED_HOME
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.assemble import component
from warmlink.orchestration.system.model import DefaultExperiment, System

ROWS = 1800


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario with a recorded duty, and its page."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('ziglang is not installed: pip install "warmlink[live]"')
    home, generator = tmp_path_factory.mktemp("live"), np.random.default_rng(3)
    rows = (
        f"{i},{3 + generator.uniform():.4f},{2.5 * (i % 200 < 150)},{22 + 2e-3 * i:.3f}" for i in range(ROWS)
    )
    head = "time [s],speed [rad/s],torque [N.m],ambient_temperature [degC]"
    (home / "shift.csv").write_text("\n".join([head, *rows]))
    (home / "shift.toml").write_text('duty = "shift.csv"\nlinear = ["ambient_temperature"]\n')
    live(str(home / "shift.toml"), controller=["lag"], out=home / "page.html")
    return home


def whole_run(scenario: Scenario, folder: Path) -> Result:
    """Run of the native FMU of the whole system."""
    (fmu,) = build_native_fmus([Entry(scenario.joined(), JOINED_HOME)], folder)
    stop = scenario.stop_time
    system = System("Alone", {"whole": component("whole", fmu)}, (), DefaultExperiment(0.0, stop, 1.0))
    return simulate(system, stop, 1.0)


def test_the_page_plays_the_recorded_duty(browser: Browser, folder: Path, tmp_path: Path) -> None:
    """Errors and demands are the native FMU's of the whole system, to the last bit."""
    script = """
        await new Promise((drawn) => setTimeout(drawn, 800));
        const lines = plots().flatMap((plot) => plot.lines);
        const result = {
          found: Object.fromEntries(lines.map(({ name, values }) => [name, [...values]])),
          headings: Array.from(document.querySelectorAll("h2"), ({ textContent }) => textContent),
          fault: document.getElementById("fault").textContent,
          scenario: decodeURIComponent(document.getElementById("scenario").href),
        };
    """
    told = browser.browse(folder / "page.html", script)
    scenario = load_scenario(str(folder / "shift.toml"))
    native = whole_run(scenario, tmp_path)
    assert told["fault"] == ""
    roles = scenario.machine.roles
    for name, expression in (("none", roles.uncompensated), ("lag", roles.score)):
        wanted = 1e6 * expression.value(lambda each: native[f"whole.{each}"])
        np.testing.assert_array_equal(told["found"][name], wanted)
    np.testing.assert_array_equal(told["found"]["speed"], native["whole.duty.speed"])
    assert told["headings"].count("Recorded duty: torque") == 1
    assert 'duty = "shift.csv"' in told["scenario"]
    assert 'linear = ["ambient_temperature"]' in told["scenario"]
    assert "[[segment]]" not in told["scenario"]


def test_a_measured_run_takes_the_place_of_the_recorded_duty(
    browser: Browser, folder: Path, tmp_path: Path
) -> None:
    rows = [f"{i},{(i % 7) / 2},{i % 5},{20 + i % 3},{30 if i % 4 else ''},{i / 10}" for i in range(400)]
    heads = ("time [s]", "speed [rad/s]", "torque [N.m]", "ambient_temperature [degC]")
    other = "\n".join([",".join([*heads, "pad_temperature [degC]", "elongation [um]"]), *rows])
    path = tmp_path / "other.csv"
    path.write_text(other)
    script = f"""
        await take(new File([{json.dumps(other)}], "other.csv"));
        await new Promise((drawn) => setTimeout(drawn, 800));
        const result = {{
          found: Object.fromEntries(plots()[0].lines.map(({{ name, values }}) => [name, [...values]])),
          command: document.getElementById("command").textContent,
          scenario: decodeURIComponent(document.getElementById("scenario").href),
        }};
    """
    told = browser.browse(folder / "page.html", script)
    native = whole_run(replace(load_scenario(str(path)), controller=shipped("lag")), tmp_path / "native")
    growth = 1e6 * native["whole.link.elongation"]
    np.testing.assert_allclose(told["found"]["none"], growth, rtol=1e-9, atol=1e-12)
    assert told["command"].startswith("warmlink run shift_live.toml --controller lag")
    assert 'duty = "other.csv"' in told["scenario"]
    assert "linear" not in told["scenario"]
