"""What a live page says at first, in the frame of another page, and in a browser that is too old."""

import re
import time
from pathlib import Path

import pytest

from tests.browser import LAST, Browser
from warmlink.orchestration.command_line.arguments import EXPLAINED
from warmlink.orchestration.command_line.pages import live
from warmlink.orchestration.command_line.run import run

OLD = "needs a browser of 2024"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("ziglang", reason='ziglang is not installed: pip install "warmlink[live]"')
    path = tmp_path_factory.mktemp("live") / "cell.html"
    live("windshield_wiper", controller=["lag"], out=path)
    return path


def lead(browser: Browser, page: Path) -> str:
    """What the page says once it has settled."""
    browser.open(page)
    asked = "Promise.resolve(document.getElementById('lead')?.textContent ?? '')"
    said, until = "", time.monotonic() + 60
    while not re.search("Largest|2024", said) and time.monotonic() < until:
        time.sleep(0.1)
        said = str(browser.evaluate(asked))
    return said


def test_it_says_that_it_computes_until_it_has(browser: Browser, page: Path) -> None:
    text = page.read_text("utf-8")
    (begun,) = re.findall(r'<p class="lead" id="lead" aria-live="polite">(.*?)</p>', text)
    assert begun == "The cell is computed …"
    assert lead(browser, page).startswith("Largest error of the tool point: none ")


@pytest.mark.parametrize("lacks", ["window.DecompressionStream", "window.WebAssembly"])
def test_a_browser_that_is_too_old_is_told(browser: Browser, page: Path, tmp_path: Path, lacks: str) -> None:
    text = page.read_text("utf-8").replace("<head>", f"<head><script>{lacks} = undefined</script>", 1)
    (tmp_path / "old.html").write_text(text, "utf-8")
    assert OLD in lead(browser, tmp_path / "old.html")


def test_a_browser_that_cannot_read_the_script_is_told(browser: Browser, page: Path, tmp_path: Path) -> None:
    text = page.read_text("utf-8").replace(LAST, f"{LAST}const of the = future;\n", 1)
    (tmp_path / "old.html").write_text(text, "utf-8")
    assert OLD in lead(browser, tmp_path / "old.html")


def test_it_computes_in_the_frame_of_another_page(browser: Browser, page: Path, tmp_path: Path) -> None:
    """As on the site's first page; the frame tells the page around it all that it says."""
    tell = "new MutationObserver(() => parent.postMessage(document.getElementById('lead').textContent, '*'))"
    watch = f"{tell}.observe(document.getElementById('lead'), {{ childList: true }});"
    marked = page.read_text("utf-8").replace("<noscript>", f"<script>{watch}</script><noscript>", 1)
    (tmp_path / "live.html").write_text(marked, "utf-8")
    frame = '<p id="lead"></p><iframe src="live.html" loading="lazy" width="900" height="700"></iframe>'
    heard = "onmessage = ({ data }) => { document.getElementById('lead').textContent += data; };"
    (tmp_path / "index.html").write_text(f"<!doctype html><script>{heard}</script>{frame}", "utf-8")
    said = lead(browser, tmp_path / "index.html")
    assert said.startswith("Largest error of the tool point")
    assert OLD not in said


def test_its_command_names_files_of_start_values_and_not_each_value(
    page: Path, browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from warmlink.controllers.start_values import by_scalar, shipped_design
    from warmlink.orchestration.system.ssp.parameter_values import write_ssv

    monkeypatch.chdir(tmp_path)
    values = {f"compensator.{name}": value for name, value in by_scalar(shipped_design("observer")).items()}
    write_ssv(values, Path("observer.ssv"))
    set_, files = ["motor.joint_conductance=2 W/K"], [Path("observer.ssv")]
    live("windshield_wiper", controller=["observer"], out=Path("mine.html"), set_=set_, parameters=files)
    command = browser.browse(tmp_path / "mine.html", "const result = commands();")
    asked = 'run windshield_wiper --parameters observer.ssv --set "motor.joint_conductance=2 W/K"'
    assert command == [f"warmlink {asked} --controller observer"]


def test_it_says_when_the_model_no_longer_holds(page: Path, browser: Browser) -> None:
    script = """
    const said = () => new Promise((go) => setTimeout(() => go(at("left").textContent), 3000));
    const result = [await said()];
    for (const torque of ["10", "25"]) {
      put({ [content.words.torque[0]]: torque });
      result.push(await said());
    }
    """
    well, hot, hotter = browser.browse(page, script)
    assert well == ""
    for said in (hot, hotter):
        assert said.startswith("The figures mean little: ")
        assert "motor.winding_temperature (-123.1 degC to 246.9 degC)" in said
    assert "link.elongation" not in hot
    assert "link.elongation (-1e+04 um to 1e+04 um)" in hotter


def test_the_variables_that_the_help_records_can_be_recorded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"--record (\S+?)\. ", EXPLAINED["record"])
    run("stop_and_go", stop="1 min", record=example, report=False, out=Path("o"))
    header = (tmp_path / "o" / "results.csv").read_text("utf-8").partition("\n")[0]
    assert "link.elongation" in header
    assert "compensator.correction" in header
