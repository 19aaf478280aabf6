"""The twin finds a thermometer that slips, calls it by its name, and forgets nothing in a restart."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.watch import WatchedCell
from tests.orchestration.watch.conftest import SLIPS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import stamped, unstamped
from warmlink.orchestration.watch.state import Beside, beside, decoded, encoded, restored, saved
from warmlink.orchestration.watch.watcher import Standing
from warmlink.orchestration.watch.watching import STATE, Watching

pytestmark = pytest.mark.xdist_group("sound cell")  # which one worker makes

Events = list[dict[str, Any]]


def events_of(cell: WatchedCell, rows: np.ndarray) -> Events:
    found = []
    for row in rows.tolist():
        read = cell.reader.read(row)
        assert read is not None
        found += [event for tick in cell.gatherer.add(read) for event in cell.watcher.add(tick)]
    return found


@pytest.fixture(scope="module")
def events(sound_cell: tuple[WatchedCell, np.ndarray]) -> Events:
    cell, rows = sound_cell
    return events_of(cell.fork(), rows)


def test_a_thermometer_that_slips_is_found_within_minutes_and_named(events: Events) -> None:
    alarms = [each for each in events if each["alarm"] and "again" not in each]
    assert len(alarms) == 1
    late = alarms[0]["time_s"] - 3600 * SLIPS
    assert 0 < late < 900
    last = [each for each in events if each["alarm"]][-1]
    assert last["verdict"] == "thermometer"
    assert last["causes"][0]["name"].endswith(":base_temperature")
    assert "base_temperature" in last["told"]


def test_innovations_of_the_sound_part_are_small_and_nothing_alarms_before(events: Events) -> None:
    assert all(each["time_s"] > 3600 * SLIPS for each in events if each["alarm"])


@pytest.mark.parametrize("until", [1, 50])
def test_a_restart_at_any_moment_tells_the_same(
    until: int, sound_cell: tuple[WatchedCell, np.ndarray], events: Events, tmp_path: Path
) -> None:
    cell, rows = sound_cell
    first, path = cell.fork(), tmp_path / "watch.state"
    told = events_of(first, rows[:until])
    saved(path, {"sound": 1}, first.watcher, first.gatherer, {})
    second = WatchedCell.made(4, first.watcher.sound / 86400, first.watcher.rate)
    assert restored(path, {"sound": 1}, second.watcher, second.gatherer)
    assert [*told, *events_of(second, rows[until:])] == events


def test_a_damaged_state_and_one_of_another_watch_are_refused(
    sound_cell: tuple[WatchedCell, np.ndarray], tmp_path: Path
) -> None:
    cell, path = sound_cell[0].fork(), tmp_path / "watch.state"
    assert not restored(path, {}, cell.watcher, cell.gatherer)
    saved(path, {"sound": 1}, cell.watcher, cell.gatherer, {})
    with pytest.raises(InputError, match="another sound"):
        restored(path, {"sound": 2}, cell.watcher, cell.gatherer)
    path.write_bytes(path.read_bytes().replace(b"unsorted", b"repeated", 1)[:-9])
    with pytest.raises(InputError, match="is damaged"):
        restored(path, {"sound": 1}, cell.watcher, cell.gatherer)


@pytest.mark.parametrize("other", ["fields", "kinds", "shapes", "things"])
def test_a_state_of_another_version_is_refused_in_a_sentence(
    other: str, sound_cell: tuple[WatchedCell, np.ndarray], tmp_path: Path
) -> None:
    cell, path = sound_cell[0].fork(), tmp_path / "watch.state"
    saved(path, {}, cell.watcher, cell.gatherer, {})
    facts = unstamped(path.read_bytes())
    assert facts is not None
    learnt = facts["watcher"]["map"]["learnt"]["of"]
    if other == "fields":
        del learnt["noise"]["of"]["stirred"]
    elif other == "kinds":
        learnt["noise"]["kind"] = "QuietNoise"
    elif other == "shapes":
        learnt["weights"] = encoded(decoded(learnt["weights"])[:, 1:])
    else:
        del facts["gatherer"]["counts"]
    path.write_bytes(stamped(facts))
    with pytest.raises(InputError, match="another version of warmlink; remove it to learn anew"):
        restored(path, {}, cell.watcher, cell.gatherer)


@pytest.mark.parametrize(
    ("kept", "other"),
    [
        *(
            ("events", each)
            for each in (None, {}, 3, ["told"], [{"alarm": False}], [{"alarm": 1, "told": ""}])
        ),
        *(("rows", each) for each in (None, "7", [7], 7.5)),
        *(("doubtful", each) for each in (None, {})),
        *(("place", each) for each in (7, "12", [7], ["7", 7], [7, 7, 7])),
    ],
)
def test_what_a_state_keeps_beside_filter_and_test_is_of_the_right_kind_or_refused(
    kept: str, other: Any, sound_cell: tuple[WatchedCell, np.ndarray], tmp_path: Path
) -> None:
    cell, path, right = sound_cell[0], tmp_path / STATE, Beside([{"alarm": False, "told": "so"}], 7, 0, None)
    saved(path, {}, cell.watcher, cell.gatherer, right._asdict())
    assert beside(path) == right
    saved(path, {}, cell.watcher, cell.gatherer, {**right._asdict(), kept: other})
    with pytest.raises(InputError, match="another version of warmlink; remove it to learn anew"):
        Watching.begin_of(tmp_path)


def test_the_memory_of_a_watch_is_bounded(
    sound_cell: tuple[WatchedCell, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.watch.watcher.WINDOW", 40)
    monkeypatch.setattr("warmlink.orchestration.watch.watcher._SNAPSHOT", 10)
    cell = sound_cell[0].fork()
    watcher = cell.watcher
    watcher.recent.clear()
    watcher.snapshots.clear()
    watcher.judged, watcher.moments = 0, deque(maxlen=50)
    for k, row in enumerate(sound_cell[1][:250].tolist()):
        events_of(cell, np.array([row]))
        assert len(watcher.recent) <= 40 + 2 * 10, k
        assert len(watcher.snapshots) <= 5
    assert watcher.judged > 70
    assert len(watcher.moments) == 50
    assert watcher.opening == []


def test_alarms_say_when_they_are_over(sound_cell: tuple[WatchedCell, np.ndarray]) -> None:
    cell = sound_cell[0].fork()
    cell.watcher.standing = Standing(0.0, quiet=59)
    told = events_of(cell, sound_cell[1][:20])
    assert [each.get("over") for each in told] == [True]
    assert cell.watcher.standing is None
