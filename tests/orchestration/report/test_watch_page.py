"""The page of a watch: an accessibility checker, narrow screens, and a title that says how it stands."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.browser import Browser, violations
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch import diagnosing
from warmlink.orchestration.watch.offers import EXPERIMENT_FILE
from warmlink.orchestration.watch.page import PAGE, page_of, write_watch
from warmlink.orchestration.watch.sequential import Limits
from warmlink.orchestration.watch.sources.lines import LinesSource
from warmlink.orchestration.watch.watcher import Moment, Standing
from warmlink.orchestration.watch.watching import Watching, WatchOptions

HEADERS = (
    "time [s],speed [rad/s],torque [N.m],ambient_temperature [degC],base_temperature [degC],"
    "tip_temperature [degC],elongation [um]"
)


def watching_in(folder: Path, diagnose: bool = False) -> Watching:
    """A watch with an alarm, as it stands after some hours."""
    log = folder / "cell.csv"
    log.write_text(f"{HEADERS}\n0,1,1,22,25,23,10\n")
    asked = WatchOptions(rig_of("WarmupCell"), {}, ReadOptions(), 4 * 3600.0, 1 / 30, diagnose=diagnose)
    watching = Watching(LinesSource(log, follow=False), asked, folder, write_watch)
    watcher = watching.watcher
    shape = 3, len(watcher.things)
    watcher.limits = Limits((10, 60, 360), np.ones(shape), 1.1, 1 / 30, 24, 600.0, False)
    draw = np.random.default_rng(1)
    for k in range(200):
        readings = np.array([300.0 + 0.02 * k, 296.0, 3e-5]) + draw.normal(0, 1, 3) * [0.05, 0.05, 3e-7]
        readings[1] = np.nan if 150 < k < 160 else readings[1]
        expected, sigma = np.array([300.0, 296.0, 3e-5]), np.array([0.1, 0.1, 5e-7])
        level = {"model": 0.02 * k, "thermometer": 0.3, "clock": 0.1}
        watcher.moments.append(Moment(14400.0 + 60 * k, level, readings, expected, sigma))
    watcher.standing = Standing(18000.0, causes=("sensor_drift:base_temperature",))
    told = "sensor_drift:base_temperature: since about 12 min before, <b>sensors.offset[3]</b> by +0.2"
    alarm = {"time_s": 18000.0, "alarm": True, "verdict": "thermometer", "causes": [], "told": told}
    watching.events, watching.rows = [alarm], 3600
    return watching


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("watch")
    write_watch(watching_in(folder))
    path = folder / PAGE
    path.write_text(path.read_text("utf-8") + "<script>globalThis.tried = true;</script>", "utf-8")
    return path


@pytest.mark.platform
@pytest.mark.parametrize(("width", "scheme"), [(375, "light"), (1300, "dark")])
def test_an_accessibility_checker_finds_nothing(
    browser: Browser, page: Path, width: int, scheme: str
) -> None:
    browser.open(page, width, scheme)
    assert violations(browser) == []
    assert browser.value("return document.documentElement.scrollWidth;") <= width


def test_the_page_says_how_it_stands_and_nothing_of_a_log_becomes_markup(tmp_path: Path) -> None:
    text = page_of(watching_in(tmp_path))
    assert "ALARM since 5.00 h: sensor_drift:base_temperature" in text
    assert "<b>sensors.offset" not in text
    assert "nan" not in text.lower().replace("dominant", "")


def test_while_it_learns_the_page_says_how_much_is_there(tmp_path: Path) -> None:
    watching = watching_in(tmp_path)
    watching.watcher.limits = None
    assert "Learning: 0.0 h of the 4 h declared sound have come in" in page_of(watching)


def test_a_diagnosis_is_told_once_and_shown_beside_its_alarm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not kept among what was judged, as its time is that of the processor."""
    monkeypatch.setattr(diagnosing, "COMMAND", (sys.executable, "-c", "print('the joint conducts less')"))
    monkeypatch.setattr(diagnosing, "_LOOKS", 0.0)
    watching = watching_in(tmp_path, diagnose=True)
    (tmp_path / "alarm-1").mkdir()
    (tmp_path / "alarm-1" / EXPERIMENT_FILE).write_text("")
    (event,) = watching.events = [{**watching.events[0], "offered": [f"alarm-1/{EXPERIMENT_FILE}"]}]
    assert "Diagnosis" not in page_of(watching)
    assert watching.diagnoses is not None
    told, give_up = [], time.monotonic() + 60
    while watching.diagnoses.busy and time.monotonic() < give_up:
        told += watching._beside()
        time.sleep(0.01)
    assert [each["told"] for each in told] == ["alarm-1 was diagnosed: the joint conducts less"]
    assert watching.events == [event]
    assert "Diagnosis: the joint conducts less" in page_of(watching)


def test_after_an_alarm_the_page_does_not_say_that_all_is_well(tmp_path: Path) -> None:
    """A joint was loose still, and the page said that all was as in the sound part."""
    watching = watching_in(tmp_path)
    watching.watcher.standing = None
    assert "No alarm now; what was found before stands below, and may be there still." in page_of(watching)
    watching.events = []
    assert "All is as in the sound part." in page_of(watching)
