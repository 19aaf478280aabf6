"""Rows mean the same in whatever order and portions they come, and what cannot be used is counted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.sources.rows import LoggedRow, RowReader
from warmlink.orchestration.watch.ticks import Gatherer, Tick

HEADERS = ["time [s]", "speed [rad/s]", "torque [N.m]", "ambient_temperature [degC]", "T_base [degC]"]
NAMED = ReadOptions(names={"T_base": "base_temperature"})
BASE = "link.base_temperature"


def reader(headers: Sequence[str] = HEADERS, told: ReadOptions = NAMED, comma: bool = False) -> RowReader:
    return RowReader("log", headers, rig_of("WarmupCell"), told, comma)


def test_cells_become_si_and_what_is_no_reading_is_none() -> None:
    rows = reader()
    row = rows.read(["60", "2", "1.5", "22", "25.5"])
    assert row == LoggedRow(
        60.0, {"motor.speed": 2.0, "motor.torque": 1.5, AMBIENT: 295.15}, {BASE: 298.65}, NAN
    )
    for cell in ("", "off", "9.9E37", "999", "-300", None):
        found = rows.read(["120", "2", "1.5", "22", cell])
        assert found is not None
        assert math.isnan(found.readings[BASE])
    assert rows.read(["soon", "2", "1.5", "22", "25.5"]) is None
    assert rows.read(["180"]) is not None, "a line that breaks off still has its time"


AMBIENT, NAN = "motor.ambient_temperature", pytest.approx(math.nan, nan_ok=True)


def test_numbers_and_texts_mean_the_same() -> None:
    rows = reader()
    assert str(rows.read(["60", "2.25", "1.5", "22", "25.5"])) == str(rows.read([60.0, 2.25, 1.5, 22, 25.5]))


@pytest.mark.parametrize(
    ("cell", "seconds"),
    [
        ("2026-03-01T00:00:10+00:00", 1772323210.0),
        ("2026-03-01 00:00:10", 1772323210.0),
        ("1772323210000", 1772323210.0),
        ("1772323210000000", 1772323210.0),
        ("1772323210000000000", 1772323210.0),
        (1772323210, 1772323210.0),
    ],
)
def test_times_may_be_dates_and_counts_since_1970(cell: str | float, seconds: float) -> None:
    row = reader(["time", *HEADERS[1:]]).read([cell, 2, 1, 22, 25])
    assert row is not None
    assert row.time == seconds


def test_a_switch_may_be_logged_in_words_and_a_temperature_may_not() -> None:
    for cell, value in (("True", 1.0), ("FALSE ", 0.0), ("false", 0.0), (True, 1.0), ("on", math.nan)):
        row = reader().read(["60", cell, "1.5", "22", "True"])
        assert row is not None
        assert row.inputs["motor.speed"] == pytest.approx(value, nan_ok=True)
        assert math.isnan(row.readings[BASE])


def test_a_comma_is_a_decimal_mark_where_the_source_says_so() -> None:
    row = reader(comma=True).read(["60", "2,25", "1,5", "22", "25,5"])
    assert row is not None
    assert row.inputs["motor.speed"] == 2.25


@pytest.mark.parametrize(
    ("headers", "told"),
    [
        (["speed [rad/s]", "base_temperature [degC]"], "there is no time column"),
        (["time [s]", "speed [rad/s]"], "no measured column is known"),
        (["time [s]", "base_temperature"], "has no unit"),
        (["time [s]", "base_temperature [m]"], "m"),
        (["time [s]", "base_temperature [degC]", "base_temperature [K]"], "are both"),
    ],
)
def test_headers_that_do_not_fit_are_refused(headers: list[str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        reader(headers, ReadOptions())


def gathered(times: Sequence[float], finish: bool = True) -> tuple[list[Tick], Gatherer]:
    rows = reader()
    gatherer = Gatherer(rig_of("WarmupCell"), {}, rows.readings)
    ticks = []
    for time in times:
        read = rows.read([time, 1.0 + time % 7, 1.5, 22, 25 + time / 1e4])
        assert read is not None
        ticks += list(gatherer.add(read))
    return [*ticks, *(gatherer.rest() if finish else ())], gatherer


def same(one: Sequence[Tick], other: Sequence[Tick]) -> bool:
    return repr(one) == repr(other)


def test_rows_that_come_a_little_late_change_nothing() -> None:
    times = np.arange(0.0, 1200.0, 5.0)
    swapped = times.copy()
    for k in range(10, 200, 7):
        swapped[[k, k + 3]] = swapped[[k + 3, k]]
    swapped[1], swapped[3] = swapped[3], swapped[1]
    ticks, gatherer = gathered(times.tolist())
    other, counted = gathered(swapped.tolist())
    assert same(ticks, other)
    assert not gatherer.counts
    assert counted.counts["unsorted"] > 20
    assert [tick.end for tick in ticks[:3]] == [60.0, 120.0, 180.0]


def test_rows_that_come_twice_count_once_and_late_ones_not_at_all() -> None:
    times = np.arange(0.0, 1200.0, 5.0).tolist()
    ticks, gatherer = gathered(sorted([*times, *times[50:90]]))
    assert same(ticks, gathered(times)[0])
    assert gatherer.counts["repeated"] == 40
    _, late = gathered([*times, 100.0, 103.0])
    assert late.counts["late"] == 2


def test_a_clock_that_stands_still_is_counted_and_survived() -> None:
    times = np.arange(0.0, 600.0, 5.0).tolist()
    ticks, gatherer = gathered([*times, *[595.0] * 50, *np.arange(600.0, 1200.0, 5.0).tolist()])
    assert same(ticks, gathered(np.arange(0.0, 1200.0, 5.0).tolist())[0])
    assert gatherer.counts["repeated"] == 50


def test_after_a_gap_of_a_day_the_filter_begins_anew() -> None:
    times = [*np.arange(0.0, 600.0, 5.0), *np.arange(87000.0, 87600.0, 5.0)]
    ticks, gatherer = gathered(times)
    assert [tick.anew for tick in ticks].count(True) == 1
    assert gatherer.counts["gaps"] == 1
    assert all(0 < tick.end - tick.start <= 900 + 60 for tick in ticks)


def test_a_clock_that_is_set_back_is_followed() -> None:
    ticks, gatherer = gathered([*np.arange(0.0, 6000.0, 5.0), *np.arange(1000.0, 2000.0, 5.0)])
    assert gatherer.counts["clock set back"] == 1
    assert ticks[-1].anew or any(tick.anew for tick in ticks[-20:])
    assert all(a.end <= b.start + 1e-9 for a, b in pairwise(ticks))


def test_inputs_are_held_and_weighed_by_time() -> None:
    rows = reader()
    gatherer = Gatherer(rig_of("WarmupCell"), {}, rows.readings)
    ticks = []
    for time, speed in ((0, 1), (15, 3), (70, ""), (200, 0)):
        read = rows.read([time, speed, 1, 22, 25])
        assert read is not None
        ticks += list(gatherer.add(read))
    ticks += list(gatherer.rest())
    speed = list(rig_of("WarmupCell").externals).index("motor.speed")
    shares = dict(zip(ticks[0].levels[:, speed], ticks[0].shares, strict=True))
    assert shares == {1.0: pytest.approx(0.25), 3.0: pytest.approx(0.75)}
    assert ticks[1].levels[:, speed].tolist() == [3.0], "an empty cell holds the value before"


def test_a_spike_is_passed_over() -> None:
    rows = reader()
    gatherer = Gatherer(rig_of("WarmupCell"), {}, rows.readings)
    ticks = []
    for k in range(100):
        read = rows.read([k, 1, 1, 22, 25 + 0.01 * (k % 3) + 40 * (k == 30)])
        assert read is not None
        ticks += list(gatherer.add(read))
    assert ticks[0].readings[0] == pytest.approx(298.16, abs=0.01)
    assert gatherer.counts["spikes"] == 1
