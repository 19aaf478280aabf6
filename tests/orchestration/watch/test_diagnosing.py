"""Alarms are diagnosed beside the watch, once each, bounded in time; one that was ended is due again."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from warmlink.orchestration.watch import diagnosing
from warmlink.orchestration.watch.diagnosing import ANSWER, Diagnoses, said_of
from warmlink.orchestration.watch.offers import EXPERIMENT_FILE


def alarms_in(folder: Path, *numbers: int) -> list[Path]:
    found = [folder / f"alarm-{each}" for each in numbers]
    for each in found:
        each.mkdir()
        (each / EXPERIMENT_FILE).write_text("")
    return found


def running(monkeypatch: pytest.MonkeyPatch, program: str) -> None:
    """Run a program where a diagnosis would."""
    monkeypatch.setattr(diagnosing, "COMMAND", (sys.executable, "-c", program))
    monkeypatch.setattr(diagnosing, "_LOOKS", 0.0)


def all_told(diagnoses: Diagnoses) -> list[dict[str, Any]]:
    found, give_up = [], time.monotonic() + 60
    while diagnoses.busy and time.monotonic() < give_up:
        if (said := diagnoses.told()) is not None:
            found.append(said)
        time.sleep(0.01)
    return found


def test_each_alarm_is_diagnosed_once_in_its_own_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    alarms = alarms_in(tmp_path, 1, 2, 11)
    running(
        monkeypatch,
        "import os; print('experiment.toml: named in', os.path.basename(os.getcwd())); print('more')",
    )
    told = all_told(Diagnoses(tmp_path))
    assert [each["diagnosed"] for each in told] == [each.name for each in alarms]
    assert told[2] == {
        "alarm": False,
        "diagnosed": "alarm-11",
        "told": "alarm-11 was diagnosed: named in alarm-11",
    }
    assert (alarms[0] / ANSWER).read_text() == "experiment.toml: named in alarm-1\nmore\n"
    assert said_of(alarms[0]) == "named in alarm-1"
    assert all_told(Diagnoses(tmp_path)) == []


def test_one_that_fails_or_takes_too_long_says_so_and_is_not_tried_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (alarm,) = alarms_in(tmp_path, 1)
    running(monkeypatch, "import sys; sys.exit('warmlink: window.csv: has three rows')")
    (told,) = all_told(Diagnoses(tmp_path))
    assert "failed (warmlink: window.csv: has three rows)" in told["told"]
    assert "warmlink diagnose" in told["told"]
    (alarm / ANSWER).unlink()
    running(monkeypatch, "import time; time.sleep(60)")
    (told,) = all_told(Diagnoses(tmp_path, longest=0.2))
    assert "took longer than" in told["told"]
    assert not Diagnoses(tmp_path).busy


def test_one_that_is_ended_with_the_watch_or_has_new_rows_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (alarm,) = alarms_in(tmp_path, 1)
    running(monkeypatch, "import os, time; open('pid', 'w').write(str(os.getpid())); time.sleep(60)")
    diagnoses = Diagnoses(tmp_path)
    diagnoses.told()
    while not ((alarm / "pid").is_file() and (alarm / "pid").read_text()):
        time.sleep(0.01)
    diagnoses.end()
    with pytest.raises(ProcessLookupError):
        os.kill(int((alarm / "pid").read_text()), 0)
    assert diagnoses.due() == [alarm]
    diagnoses.told()
    diagnoses.anew(alarm.name)
    running(monkeypatch, "print('named')")
    assert [each["told"] for each in all_told(diagnoses)] == ["alarm-1 was diagnosed: named"]
    diagnoses.anew(alarm.name)
    assert diagnoses.due() == [alarm]


@pytest.mark.skipif(sys.platform != "linux", reason="limits of processes are set on Linux alone")
def test_it_is_bounded_and_makes_way_for_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    alarms_in(tmp_path, 1)
    monkeypatch.setattr(diagnosing, "_MEMORY", 400_000_000)
    running(
        monkeypatch,
        "import os\ntry: bytearray(10**9)\nexcept MemoryError: print('no memory, nice', os.nice(0))",
    )
    (told,) = all_told(Diagnoses(tmp_path))
    assert told["told"] == f"alarm-1 was diagnosed: no memory, nice {min(os.nice(0) + 10, 19)}"
