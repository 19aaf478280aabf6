"""Addresses of a live page: what does not fit changes nothing, and the page takes its own."""

import importlib.util
from pathlib import Path

import pytest

from tests.browser import Browser
from warmlink.orchestration.command_line.pages import live


@pytest.fixture
def page(tmp_path: Path) -> Path:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('ziglang is not installed: pip install "warmlink[live]"')
    live("windshield_wiper", controller=["lag"], out=tmp_path / "cell.html")
    return tmp_path / "cell.html"


def test_a_refused_address_changes_nothing_and_an_own_one_is_taken(browser: Browser, page: Path) -> None:
    script = """
        const others = [...document.querySelectorAll("button, meta")];
        const buttons = () => others.map((each) => each.value ?? each.content).join();
        const refused = (settings) => {
          try { restore(`#${settings}`); } catch { return true; }
          return false;
        };
        const entry = fields("sensors.fault_time[1]")[0];
        const [before, felt] = [buttons(), entry.value];
        const all = ["copies=5", "back=a", "copy=1", "viewport=9", "sensors.fault_time[1]=5"].every(refused);
        const same = buttons() === before && entry.value === felt;
        put({ "sensors.fault_kind[1]": "1" });
        entry.value = "";
        entry.dispatchEvent(new Event("change", { bubbles: true }));
        const kept = entry.value === felt;
        put({ "duty.duration": "15,20" });
        document.querySelector("#segments [name=copies]").click();
        const shown = texts();
        restore(`#${new URLSearchParams(changed())}`);
        const result = { all, same, kept, split: shown["duty.duration"] };
    """
    assert browser.browse(page, script) == {"all": True, "same": True, "kept": True, "split": "7.5,7.5,20"}
