"""`warmlink watch`: what it prints and writes, what it refuses, and that a killed one goes on."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
import urllib.request
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from tests.command import exit_code
from tests.orchestration.watch.conftest import RATE, SLIPS, SOUND
from warmlink.orchestration.command_line.watch import _in_words
from warmlink.orchestration.products.watch import MachineSettings, WatchSettings, watching
from warmlink.orchestration.watch.page import PAGE, served
from warmlink.orchestration.watch.watching import rate_of

ASKED = ["--sound", f"{SOUND} h", "--until-end", "--alarms", f"{RATE} per day"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["absent.csv"], "absent.csv: no such file"),
        (["cell.csv", "--sound", "soon"], "--sound"),
        (["cell.csv", "--sound", "-3 h"], "--sound"),
        (["cell.csv", "--alarms", "often"], "--alarms 'often': is no rate"),
        (["cell.csv", "--alarms", "0 per day"], "--alarms '0 per day': is no rate"),
        (["cell.csv", "--tick", "0 s"], "--tick"),
        (["cell.csv", "--controller", "magic"], "magic"),
        (["cell.csv", "--parameters", "gains.ssv"], "--parameters gains.ssv: is of no law"),
        (["cell.csv", "--speed", "-1"], "--speed -1: is no speed"),
        (["cell.csv", "--serve", "here"], "--serve here: is no address"),
        (["cell.csv", "--mapping", "nodes.toml"], "--mapping nodes.toml: is for servers"),
        (["mqtt://cell"], "names no host or no topic"),
        (["empty.csv"], "has no header line"),
        (["words.csv"], "there is no time column"),
        (["cell.csv", "--system", "Bench"], "system: 'Bench' is not one"),
        (["cell.csv", "--system", "BenchMotor"], "cell.csv: no measured column is known"),
        (["cell.csv", "--system", "BenchMotor", "--scenario", "warm_up"], "warm_up names a machine too"),
        (["cell.csv", "--sound", "20 h"], "the log ends after"),
        (["cell.csv", "--sound", "30 min"], "holds only"),
    ],
)
def test_what_cannot_be_watched_is_refused_in_a_sentence(
    arguments: list[str],
    told: str,
    log: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("cell.csv").symlink_to(log)
    Path("empty.csv").write_text("")
    Path("words.csv").write_text("speed [rad/s],base_temperature [degC]\n1,25\n")
    assert exit_code(["watch", *arguments, "--until-end"], monkeypatch) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in err
    assert "Traceback" not in err


def test_another_machine_is_watched_by_its_name(log: Path, tmp_path: Path) -> None:
    told = {"names": ["base_temperature=motor.shaft_temperature"]}
    whose = MachineSettings("BenchMotor", parameters={"motor.winding_conductance": "2 W/K"})
    with watching(str(log), tmp_path, told, WatchSettings("1 h", "1 per day", "60 s"), whose) as work:
        assert work.asked.rig.name == "BenchMotor"
        assert work.asked.known == {"motor.winding_conductance": 2.0}
        assert work.reader.readings == ("motor.shaft_temperature",)


@pytest.mark.parametrize(
    ("text", "rate"),
    [("1 per 30 days", 1 / 30), ("2 per week", 2 / 7), ("1 per year", 1 / 365.25), ("3 per 12 h", 6)],
)
def test_a_rate_is_a_number_in_a_time(text: str, rate: float) -> None:
    assert rate_of(text, "alarms") == pytest.approx(rate, rel=1e-3)


def test_the_page_is_served_read_only_and_nothing_else_is(tmp_path: Path) -> None:
    (tmp_path / PAGE).write_text("the page")
    (tmp_path / "watch.state").write_text("secret")
    with served("127.0.0.1:0", tmp_path) as port:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/") as answer:
            assert answer.read() == b"the page"
        for path in ("watch.state", "../etc/passwd", "alarms.jsonl"):
            with pytest.raises(urllib.error.HTTPError):
                urllib.request.urlopen(f"http://127.0.0.1:{port}/{path}")
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(f"http://127.0.0.1:{port}/", data=b"take this")


def told_in(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / "alarms.jsonl").read_text().splitlines()]


@pytest.fixture(scope="module")
def whole(log: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder and what is printed of a watch that nobody interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as out:
        assert exit_code(["watch", str(log), *ASKED, "--json", "--out", str(folder)], patch) == 0
    return folder, out.getvalue()


@pytest.mark.slow
def test_alarms_are_printed_and_written_and_shown(whole: tuple[Path, str]) -> None:
    folder, out = whole
    events = [json.loads(line) for line in out.splitlines()]
    assert events == told_in(folder)
    alarms = [each for each in events if each["alarm"]]
    assert alarms[-1]["verdict"] == "thermometer"
    assert alarms[0]["time_s"] > 3600 * SLIPS
    page = (folder / PAGE).read_text("utf-8")
    assert "ALARM since" in page
    assert "base_temperature" in page
    assert "http" not in page.replace("http-equiv", "")


def test_an_alarm_is_called_so_once_however_often_it_is_named() -> None:
    """The count at the end is of alarms, and a name that is told anew is none."""
    first = {"time_s": 60.0, "alarm": True, "verdict": "model", "told": "friction_level"}
    lines = [_in_words(each) for each in (first, {**first, "again": True}, {"alarm": False, "told": "x"})]
    assert [line.count("ALARM") for line in lines] == [1, 0, 0]
    assert "the same alarm (model): friction_level" in lines[1]


@pytest.mark.slow
def test_a_watch_that_is_killed_again_and_again_tells_the_same(
    whole: tuple[Path, str], log: Path, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "warmlink", "watch", log, *ASKED, "--out", tmp_path, "--speed", "4000"]
    for after in (0.2, 2.5):
        running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not (tmp_path / "watch.state").is_file() and running.poll() is None:
            time.sleep(0.1)
        time.sleep(after)
        running.send_signal(signal.SIGKILL)
        running.wait()
    assert (tmp_path / "watch.state").is_file()
    subprocess.run(command[:-2], capture_output=True, check=True)
    assert told_in(tmp_path) == told_in(whole[0])


@pytest.mark.slow
def test_ctrl_c_ends_it_with_what_was_seen(log: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "warmlink", "watch", log, "--sound", "20 h", "--out", tmp_path]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / PAGE).is_file() and running.poll() is None:
        time.sleep(0.1)
    time.sleep(0.3)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert running.returncode == 0
    assert "goes on from here" in err
    assert "Traceback" not in err
    assert "0 alarms" in out
