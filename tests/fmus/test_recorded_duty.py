"""RecordedDuty: the row that holds at any time, in a table of any length, and nothing remembered."""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.component import Output
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.join import join
from warmlink.fmus.component.table import EARLY, RecordedTable
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.recorded_duty.component import COMPONENT, duty_table, player, playing

TIMES = [0.0, 10.0, 25.0]
SHIFT = duty_table(
    TIMES,
    {"speed": [1.0, 2.0, 0.5], "ambient_temperature": [290.0, 300.0, 285.0], "pad_mode": [0, 2, 1]},
    linear=["ambient_temperature"],
)


def running(table: RecordedTable) -> Instance:
    instance = Instance(playing(COMPONENT, table))
    instance.initialize()
    return instance


def test_as_declared_it_is_full_duty() -> None:
    instance = Instance(COMPONENT)
    instance.initialize()
    assert instance.outputs().tolist() == [3.43, 2.5, 295.15, 0, 295.15, 0]


def test_a_held_column_jumps_and_a_linear_one_goes_straight() -> None:
    duty = running(SHIFT)
    found = []
    for _ in range(6):
        found.append([duty.get(name) for name in ("speed", "ambient_temperature", "pad_mode")])
        duty.step(duty.time, 5.0)
    assert found == [[1, 290, 0], [1, 295, 0], [2, 300, 2], [2, 295, 2], [2, 290, 2], [0.5, 285, 1]]


def test_rounding_before_a_row_counts_as_its_beginning() -> None:
    assert SHIFT.at(10 - EARLY / 2)[1] == 2.0
    assert SHIFT.at(10 - 2 * EARLY)[1] == 1.0


def test_a_run_beyond_the_last_row_is_said_once() -> None:
    duty, told = running(SHIFT), list[str]()
    duty.warn = told.append
    for _ in range(4):
        duty.step(duty.time, 25.0)
    assert told == ["recorded_duty: its table ends at 25 s; the last row holds from then on"]
    assert duty.get("speed") == 0.5


def test_means_are_those_of_the_rows() -> None:
    fine = np.linspace(0.0, 25.0, 250_001)[:-1]
    speed, _, ambient, *_ = SHIFT.over(fine).T
    assert speed.mean() == pytest.approx((1 * 10 + 2 * 15) / 25, rel=1e-6)
    assert ambient.mean() == pytest.approx((295 * 10 + 292.5 * 15) / 25, rel=1e-6)


@given(
    st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=30),
    st.lists(st.floats(-1.0, 1e4), min_size=1, max_size=20),
)
@settings(max_examples=50, deadline=None)
def test_many_times_at_once_are_as_one_by_one(steps: Sequence[float], asked: Sequence[float]) -> None:
    times = np.cumsum(steps)
    values = np.sin(np.arange(times.size))
    table = RecordedTable(times, {"a": values, "b": 3.0 * values, "c": [7.0]}, linear=["b"])
    at = np.array([*asked, *times[:5]])
    rows = np.array([table.at(time) for time in at])
    assert np.array_equal(table.over(at), rows[:, 1:4] + rows[:, 4:] * (at - rows[:, 0])[:, None])


def test_a_table_survives_its_file_and_being_sent() -> None:
    (played,) = playing(COMPONENT, SHIFT).tables
    content = played.content
    assert content.startswith(b"warmlink table 1: speed [rad/s], torque [N.m], ambient_temperature [K], ")
    assert int.from_bytes(content[-8:], "little") == zlib.crc32(content[:-8])
    for found in (played.read(content, "rows.table").table, pickle.loads(pickle.dumps(SHIFT))):
        assert found.linear == SHIFT.linear
        assert found.handle != SHIFT.handle
        assert all(np.array_equal(a, b) for a, b in zip(found.columns, SHIFT.columns, strict=True))
        assert found.digest == SHIFT.digest


def test_a_column_that_never_changes_takes_no_room() -> None:
    long = duty_table(np.arange(1e5), {"speed": np.arange(1e5), "torque": np.full(100_000, 2.0)})
    (played,) = playing(COMPONENT, long).tables
    assert len(played.content) < 2 * 8e5 + 1000


@pytest.mark.parametrize("byte", [3, 150, 300, -1])
def test_any_damage_is_refused(byte: int) -> None:
    (played,) = playing(COMPONENT, SHIFT).tables
    damaged = bytearray(played.content)
    damaged[byte] ^= 1
    with pytest.raises(InputError, match=r"^rows\.table: .*; write it"):
        played.read(bytes(damaged), "rows.table")
    with pytest.raises(InputError, match=r"^rows\.table: .*; write it"):
        played.read(played.content[:byte], "rows.table")


@pytest.mark.parametrize(
    ("times", "columns", "linear", "sentence"),
    [
        ([], {}, (), "needs rows; give at least one time"),
        ([0, 1, 1], {}, (), "row 3: its time, 1 s, is not after that of the row before"),
        ([0, np.nan], {}, (), "row 2: its time is not finite"),
        ([0, 1], {"speed": [1, 2, 3]}, (), "speed: 3 values for 2 rows"),
        ([0, 1], {"speed": [1, np.inf]}, (), "speed: row 2: inf is not finite"),
        ([0, 1], {"speed": [1, -2]}, (), "speed: row 2: -2 rad/s is too low; give at least 0 rad/s"),
        ([0, 1], {"pad_mode": [1, 3]}, (), "pad_mode: row 2: 3 is too high"),
        ([0, 1], {"pad_mode": [0, 0.5]}, (), "pad_mode: row 2: 0.5 is not a whole number"),
        ([0, 1], {"pad_mode": [0, 1]}, ("pad_mode",), "pad_mode: .*cannot be linear"),
        ([0, 1], {}, ("sped",), "linear: sped is no column; did you mean speed"),
    ],
)
def test_bad_rows_are_refused_in_a_sentence(
    times: list[float], columns: dict[str, list[float]], linear: tuple[str, ...], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        playing(COMPONENT, duty_table(times, columns, linear))


def test_a_table_without_rows_is_refused() -> None:
    with pytest.raises(InputError, match="needs rows"):
        RecordedTable([], {"speed": []})


def test_another_table_needs_the_same_columns() -> None:
    with pytest.raises(InputError, match="a table of a; give speed, torque"):
        playing(COMPONENT, RecordedTable([0.0], {"a": [1.0]}))


def test_anything_can_be_played() -> None:
    flow = Output("flow", "kg/s", "flow of coolant", nominal=0.1)
    pump = player(
        "Pump", "Recorded flow", [flow], RecordedTable([0, 10], {"flow": [0.1, 0.2]}, linear=["flow"])
    )
    instance = Instance(pump)
    instance.initialize()
    instance.step(0.0, 5.0)
    assert instance.get("flow") == pytest.approx(0.15)


def test_joined_it_drives_its_neighbour_as_beside_it() -> None:
    """The parts stepped one after the other are the joined component, to the last digits."""
    wires = [(f"duty.{name}", f"motor.{name}") for name in COMPONENT.y.names]
    whole = Instance(join("Driven", {"duty": playing(COMPONENT, SHIFT), "motor": MOTOR}, wires))
    duty, motor, told = running(SHIFT), Instance(MOTOR), list[str]()
    whole.warn = told.append
    whole.initialize()
    motor.set({name: duty.get(name) for name in COMPONENT.y.names})
    motor.initialize()
    for second in range(40):
        motor.set({name: duty.get(name) for name in COMPONENT.y.names})
        for each in (whole, duty, motor):
            each.step(second, 1.0)
        assert whole.get("motor.shaft_temperature") == pytest.approx(
            motor.get("shaft_temperature"), rel=1e-12
        )
    assert told == ["driven.duty: its table ends at 25 s; the last row holds from then on"]


def test_two_parts_play_tables_of_their_own() -> None:
    other = duty_table([0.0, 5.0], {"speed": [4.0, 5.0]})
    whole = Instance(join("Two", {"a": playing(COMPONENT, SHIFT), "b": playing(COMPONENT, other)}))
    whole.initialize()
    whole.step(0.0, 10.0)
    assert (whole.get("a.speed"), whole.get("b.speed")) == (2.0, 5.0)
    assert [each.file for each in whole.component.tables] == ["a.rows.table", "b.rows.table"]


def test_a_saved_state_brings_back_the_same_row() -> None:
    duty = running(SHIFT)
    duty.step(0.0, 12.0)
    saved, before = duty.snapshot(), duty.outputs().tolist()
    duty.step(12.0, 20.0)
    duty.restore(saved)
    assert duty.outputs().tolist() == before
    assert replace(saved) == duty.snapshot()
