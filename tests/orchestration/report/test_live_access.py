"""Whether everybody can use the page: an accessibility checker, narrow screens, dark mode, the keyboard."""

from pathlib import Path

import pytest

from tests.browser import LAST, Browser, violations
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.orchestration.command_line.pages import live

pytestmark = pytest.mark.platform


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("ziglang", reason='ziglang is not installed: pip install "warmlink[live]"')
    path = tmp_path_factory.mktemp("live") / "cell.html"
    live("windshield_wiper", controller=["lag"], out=path)
    text = path.read_text("utf-8")
    path.write_text(text.replace(LAST, f"{LAST}globalThis.tried = true;\n"), "utf-8")
    return path


@pytest.mark.parametrize(("width", "scheme"), [(375, "light"), (375, "dark"), (1100, "dark")])
def test_an_accessibility_checker_finds_nothing(
    browser: Browser, page: Path, width: int, scheme: str
) -> None:
    browser.open(page, width, scheme)
    browser.value("for (const each of document.querySelectorAll('details')) each.open = true;")
    assert violations(browser) == []


@pytest.mark.parametrize("width", [375, 1000, 1600])
def test_nothing_sticks_out(browser: Browser, page: Path, width: int) -> None:
    browser.open(page, width)
    wide = browser.value("return document.documentElement.scrollWidth;")
    drawn = browser.value(
        "return [...document.querySelectorAll('figure > svg')].map((each) => each.clientWidth)"
    )
    hidden = browser.value(
        "const { parentElement } = document.querySelector('#faults');"
        "return parentElement.scrollWidth - parentElement.clientWidth;"
    )
    assert wide <= width
    assert hidden == 0
    assert len(drawn) == 5
    assert all(0 < each < width for each in drawn)


def test_a_slider_is_moved_by_the_keyboard_and_says_its_value(browser: Browser, page: Path) -> None:
    browser.open(page)
    before = browser.value(
        "const shown = () => document.querySelector('.slider:not([hidden]) input');"
        "while (!shown()) await new Promise((go) => setTimeout(go, 50));"
        "const slider = shown(); slider.focus();"
        "return [slider.getAttribute('aria-valuetext'), document.getElementById('lead').textContent];"
    )
    for _ in range(5):
        browser.press_right()
    after = browser.value(
        "await new Promise((drawn) => setTimeout(drawn, 500));"
        "const slider = document.activeElement;"
        "return [slider.getAttribute('aria-valuetext'), document.getElementById('lead').textContent];"
    )
    assert before[0] == "2.36e-05 1/K"
    assert after[0] != before[0]
    assert after[1] != before[1]


def test_each_segment_says_its_number_and_keeps_its_value_where_an_entry_is_refused(
    browser: Browser, page: Path
) -> None:
    script = """
        const labels = (row) => [...row.querySelectorAll("[aria-label]")].map(({ ariaLabel }) => ariaLabel);
        const rows = () => [...document.querySelectorAll("#segments tr")];
        const told = () => rows().map((row) => [row.cells[0].textContent, labels(row)]);
        const labelled = (label) => document.querySelector(`[aria-label="${label}"]`);
        const press = (label) => {
          labelled(label).focus();
          labelled(label).click();
        };
        for (const each of document.querySelectorAll("details")) each.open = true;
        const first = told();
        press("split segment 1");
        press("split segment 1");
        const focused = document.activeElement.ariaLabel;
        const speed = labelled("segment 2: speed [rad/s]");
        for (const text of ["1.5", "", "-1"]) {
          speed.value = text;
          speed.dispatchEvent(new Event("change", { bubbles: true }));
        }
        const grown = told();
        press("remove segment 1");
        const speeds = [...document.getElementsByName("duty.segment_speed")].map(({ value }) => value);
        const left = told();
        for (let i = 0; i < 2; i++) press("remove segment 1");
        const least = rows().length;
        for (let i = 0; i < 40; i++) press("split segment 1");
        return { first, grown, focused, left, speeds, least, most: rows().length };
    """
    browser.open(page)
    found = browser.value(script)
    ((number, labels),) = found["first"]
    assert (number, labels[0], labels[-1]) == ("1", "segment 1: duration [s]", "remove segment 1")
    for name, count in (("grown", 3), ("left", 2)):
        expected = [
            [str(i), [each.replace("segment 1", f"segment {i}") for each in labels]]
            for i in range(1, count + 1)
        ]
        assert found[name] == expected
    assert found["focused"] == "split segment 1"
    assert found["speeds"] == ["1.5", "3.43"]
    assert (found["least"], found["most"]) == (1, SEGMENTS)
