"""`warmlink live` in a real browser: its numbers, and what happens when something is moved."""

import importlib.util
import json
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser import Browser
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import build_native_fmus
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.metrics import error_metrics
from warmlink.orchestration.closed_loop.outcome import run
from warmlink.orchestration.command_line.arguments import settings_given
from warmlink.orchestration.command_line.pages import live
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.report.live.content import Asked
from warmlink.orchestration.report.live.page import kept_live_page
from warmlink.orchestration.scenarios.overrides import parameters_of
from warmlink.orchestration.scenarios.scenario import Scenario, changed
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
    live("windshield_wiper", controller=["lag"], out=path)
    return path


def errors(scenario: Scenario, folder: Path) -> dict[str, Any]:
    """Error of the tool point by the native FMU of the whole system, in m."""
    (fmu,) = build_native_fmus([Entry(scenario.joined(), "warmlink.orchestration.machine.machine")], folder)
    alone = DefaultExperiment(0.0, stop := scenario.stop_time, 1.0)
    roles = scenario.machine.roles
    judged = {"none": roles.uncompensated, "lag": roles.score}
    needed = sorted({f"whole.{each}" for expression in judged.values() for each in expression.variables})
    whole = System("Alone", {"whole": component("whole", fmu)}, (), alone)
    result = simulate(whole, stop, 1.0, record=needed)
    return {
        name: expression.value(lambda each: result[f"whole.{each}"]) for name, expression in judged.items()
    }


@pytest.mark.slow
@pytest.mark.platform
def test_the_page_gives_the_native_numbers_at_every_step(
    browser: Browser, page: Path, tmp_path: Path
) -> None:
    """A slider is set as a reader sets it; both errors are the native run's to the last bit."""
    script = """
        put({ "motor.joint_conductance": "2" });
        await new Promise((drawn) => setTimeout(drawn, 500));
        const errors = Object.fromEntries(plots()[0].lines.map(({ name, values }) => [name, [...values]]));
        const answer = document.getElementById("answer").textContent;
        const result = { errors, answer };
    """
    found = browser.browse(page, script)
    scenario = changed(load_scenario("windshield_wiper"), parameters=CHANGED)
    for law, expected in errors(scenario, tmp_path).items():
        np.testing.assert_array_equal(found["errors"][law], 1e6 * expected)
        metrics = error_metrics(np.arange(expected.size, dtype=float), expected, scenario.tolerance)
        assert f"{metrics.max_abs_um:.1f} µm" in found["answer"]


@pytest.mark.platform
def test_everything_on_the_page_moves_the_answer(browser: Browser, page: Path) -> None:
    script = """
        const wait = () => new Promise((drawn) => setTimeout(drawn, 300));
        const told = () => document.getElementById("lead").textContent;
        await wait();
        const seen = [told()];
        while (!document.querySelector(".slider:not([hidden])")) await wait();
        const slider = document.querySelector("#sliders input[type=range]");
        slider.value = Number(slider.max) - 0.1;
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        await wait();
        seen.push(told());
        const pull = (handle, dx, dy) => {
          const { x, y, width, height } = handle.getBoundingClientRect();
          const at = { clientX: x + width / 2, clientY: y + height / 2, bubbles: true, pointerId: 1 };
          document.querySelector("#duty").setPointerCapture = () => {};
          handle.dispatchEvent(new PointerEvent("pointerdown", at));
          const moved = { ...at, clientX: at.clientX + dx, clientY: at.clientY + dy };
          handle.dispatchEvent(new PointerEvent("pointermove", moved));
          document.querySelector("#duty").dispatchEvent(new PointerEvent("pointerup", at));
        };
        pull(document.querySelector('.handle[data-along="y"]'), 0, 60);
        await wait();
        seen.push(told());
        const speed = Number(texts()["duty.segment_speed"]);
        document.querySelector('button[aria-label="split segment 1"]').click();
        await wait();
        pull(document.querySelector('.handle[data-along="x"]'), -100, 0);
        await wait();
        const torque = document.querySelector('[aria-label="segment 2: torque [N.m]"]');
        torque.value = "0";
        torque.dispatchEvent(new Event("change", { bubbles: true }));
        await wait();
        seen.push(told());
        put({ "link.tip_position": "5000" });
        await wait();
        const result = { seen, speed, first: texts()["duty.duration"].split(",").map(Number),
          ranked: [...document.querySelectorAll(".slider:not([hidden])")].map(({ id }) => id),
          fault: document.getElementById("fault").textContent };
    """
    found = browser.browse(page, script)
    assert len(set(found["seen"])) == len(found["seen"])
    assert found["speed"] < 3.43
    assert found["first"][0] < found["first"][1] == 3600.0
    assert found["ranked"][0] == "link.expansion_coefficient"
    assert found["fault"].startswith("WarmupCell.link.tip_position: 5 m lies beyond")


@pytest.mark.platform
def test_the_command_computes_what_the_page_shows(browser: Browser, page: Path, tmp_path: Path) -> None:
    """With parameters set on the page, and with a changed duty; within the coupling error of the command."""
    script = """
        const most = ({ name, values }) => [name, Math.max(...values.map(Math.abs))];
        const largest = () => Object.fromEntries(plots()[0].lines.map(most));
        const wait = () => new Promise((drawn) => setTimeout(drawn, 300));
        put({ "link.length": "400", "sensors.fault_kind[3]": "3", stop: "3000" });
        await wait();
        const command = document.getElementById("command").textContent;
        await new Promise((rested) => setTimeout(rested, 500));
        const set = { command, largest: largest(), address: location.hash };
        copies(0, 2);
        put({ "duty.duration": "1200,900", "duty.segment_speed": "3.43,1", "duty.segment_pad_mode": "0,1",
          "duty.segment_pad_power": "0,7" });
        await wait();
        const duty = { command: document.getElementById("command").textContent, largest: largest() };
        const files = { toml: scenarioText(), ssv: parameterSet() };
        document.querySelector("[type=reset]").click();
        await wait();
        restore(set.address);
        const result = { set, duty, files, back: changed() };
    """
    found = browser.browse(page, script)
    assert found["back"]["link.length"] == "400"
    assert found["back"]["stop"] == "3000"
    (tmp_path / "windshield_wiper_live.toml").write_text(found["files"]["toml"], "utf-8")
    (tmp_path / "page.ssv").write_text(found["files"]["ssv"], "utf-8")
    assert parameters_of(tmp_path / "page.ssv")["link.length"] == 0.4
    for shown in (found["set"], found["duty"]):
        warmlink, run_, name, *options = shlex.split(shown["command"])
        assert (warmlink, run_) == ("warmlink", "run")
        beside = tmp_path / name
        given = {
            option: options[i + 1] for i, option in enumerate(options) if option in ("--controller", "--stop")
        }
        outcome = run(
            beside if beside.is_file() else name,
            given["--controller"],
            parameters=settings_given(options[i + 1] for i, each in enumerate(options) if each == "--set"),
            stop=given.get("--stop"),
        )
        assert outcome.time[-1] == 3000.0
        bound = outcome.coupling_error_um
        assert bound is not None
        for law, figures in (("none", outcome.uncompensated), ("lag", outcome.metrics)):
            assert abs(shown["largest"][law] - figures.max_abs_um) <= bound, law


@pytest.mark.platform
def test_a_wrong_address_and_a_wrong_file_are_refused_in_a_sentence(browser: Browser, page: Path) -> None:
    script = """
        const sentences = [];
        const until = async (seen) => {
          for (let i = 0; i < 500 && !seen(); i++) await new Promise((passed) => setTimeout(passed, 20));
        };
        const given = "time [s],speed [rad/s],elongation [um]\\n0,3,0\\n600,0,9\\n900,0,8\\n";
        const told = async (action) => {
          setTimeout(action);
          await new Promise((said) => setTimeout(said, 20));
          sentences.push(document.getElementById("fault").textContent);
        };
        for (const settings of ["x", "law=observer", "law=", "a=1", "stop=-1", "link.length=long",
          "duty.duration=0,9", "duty.segment_pad_mode=7", "duty.segment_speed=1,2"])
          await told(() => restore("#" + settings));
        const drop = (text) => {
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File([text], "run.csv"));
          dispatchEvent(new DragEvent("drop", { dataTransfer }));
        };
        for (const text of ["time [s]\\n0\\n", "time [h]\\n0\\n1e9\\n", "time [s]\\n0\\n0.2\\n"]) {
          const before = document.getElementById("fault").textContent;
          drop(text);
          await until(() => document.getElementById("fault").textContent !== before);
          sentences.push(document.getElementById("fault").textContent);
        }
        drop(given);
        await until(() => document.querySelector(".dots")?.getAttribute("d"));
        const marks = document.querySelector(".dots").getAttribute("d").split("M").length - 1;
        const command = document.getElementById("command").textContent.split("\\n").at(-1);
        const result = { sentences, stop: Number(texts().stop), marks, command };
    """
    found = browser.browse(page, script)
    *addresses, file, long, short = found["sentences"]
    assert [
        each
        for each in addresses
        if not each.startswith("The address holds settings that do not fit this page")
    ] == []
    assert file == "run.csv: 1 rows under the header; give at least two times."
    assert long == "run.csv: lasts 3600000000000 s; the page takes runs of 1.0 s to 86400.0 s."
    assert short == "run.csv: lasts 0.2 s; the page takes runs of 1.0 s to 86400.0 s."
    assert (found["stop"], found["marks"], found["command"]) == (900, 3, "warmlink diagnose run.csv")


@pytest.mark.platform
def test_a_slider_may_be_dragged_for_long(browser: Browser, page: Path) -> None:
    """Browsers refuse an address that changes too often; it holds what was set last all the same."""
    script = """
        put({ stop: "60" });
        for (let i = 1; i <= 250; i++) {
          put({ "link.length": `${400 + i}` });
          await new Promise((drawn) => setTimeout(drawn));
          if (document.getElementById("fault").textContent) break;
        }
        const fault = document.getElementById("fault").textContent;
        await new Promise((rested) => setTimeout(rested, 700));
        const result = { fault, address: location.hash };
    """
    assert browser.browse(page, script) == {"fault": "", "address": "#stop=60&link.length=650"}


@pytest.mark.platform
def test_the_page_is_light_and_needs_no_network(page: Path) -> None:
    assert page.stat().st_size < LARGEST
    text = page.read_text("utf-8")
    assert not re.search(r"<(?:script|link|img)[^>]+(?:src|href)=|@import|fetch\(", text)


def test_without_a_compiler_for_browsers_the_page_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from warmlink.fmus.packaging.native import fmu

    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path / "cache"))
    # It says so before it makes anything.
    monkeypatch.setattr(fmu, "native_sources", lambda whole, speaker: pytest.fail("made C at first"))
    found = importlib.util.find_spec  # which finds the controllers, too
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "ziglang" else found(name))
    with pytest.raises(InputError, match=r"needs zig: pip install \"warmlink\[live\]\""):
        live("windshield_wiper", controller=["none"], out=tmp_path / "page.html")
    assert not list(tmp_path.glob("*.html"))


def test_a_page_is_html(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"page\.pdf: is no page; name a file that ends in \.html"):
        live("windshield_wiper", out=tmp_path / "page.pdf")


@pytest.mark.platform
def test_the_report_of_a_run_holds_the_page_of_what_was_run(
    browser: Browser, page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Commands keep the run's options, and a mismatch does not change a value twice."""
    assert page.is_file()
    asked = [
        "--controller",
        "lag",
        "--mismatch",
        "thermal_high",
        "--stop",
        "10 min",
        "--set",
        "link.length=0.5 m",
    ]
    folder = tmp_path / "out"
    monkeypatch.setattr("sys.argv", ["warmlink", "run", "windshield_wiper", *asked, "--out", str(folder)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code
    assert '<iframe src="live.html"' in (folder / "report.html").read_text("utf-8")
    script = """
        const wait = () => new Promise((drawn) => setTimeout(drawn, 300));
        const shown = () => ({ command: document.getElementById("command").textContent.split("\\n")[0],
          largest: Object.fromEntries(plots()[0].lines.map(most)) });
        const most = ({ name, values }) => [name, Math.max(...values.map(Math.abs))];
        await wait();
        const begun = shown();
        put({ "motor.joint_conductance": "1" });
        await wait();
        const result = { begun, moved: shown(), toml: scenarioText() };
    """
    found = browser.browse(folder / "live.html", script)
    assert sorted(shlex.split(found["begun"]["command"])) == sorted(
        ["warmlink", "run", "windshield_wiper", *asked]
    )
    metrics = json.loads((folder / "metrics.json").read_text("utf-8"))
    bound = metrics["error_budget_um"]["coupling"]
    assert abs(found["begun"]["largest"]["lag"] - metrics["compensated"]["max_abs_um"]) <= bound
    assert found["moved"]["command"] == "warmlink run windshield_wiper_live.toml --controller lag"
    (tmp_path / "windshield_wiper_live.toml").write_text(found["toml"], "utf-8")
    outcome = run(tmp_path / "windshield_wiper_live.toml", "lag")
    assert outcome.coupling_error_um is not None
    assert abs(found["moved"]["largest"]["lag"] - outcome.metrics.max_abs_um) <= outcome.coupling_error_um


def test_a_report_without_a_compiled_system_has_no_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    assert kept_live_page(load_scenario("windshield_wiper"), Asked("windshield_wiper", {})) == ""
