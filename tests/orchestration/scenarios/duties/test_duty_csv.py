"""Recorded duty cycles: what a CSV file may hold, and what is refused instead of being left out."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios.duties.duty import Duty, Recorded, Segment
from warmlink.orchestration.scenarios.duties.duty_files import load
from warmlink.orchestration.scenarios.duties.recorded import read_recorded

HEADER = "time [min],speed [rad/s],torque [N.m]"
ROWS = "0,3.43,2.5\n10,0,0\n20,3.43,2.5"


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "recorded.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_rows_become_segments(tmp_path: Path, encoding: str) -> None:
    duty = read_recorded(written(tmp_path, f"{HEADER}\n{ROWS}\n\n", encoding))
    assert [(s.duration, s.speed, s.torque) for s in duty.segments] == [(600, 3.43, 2.5), (600, 0, 0)]
    assert duty.stop_time == 1200


def test_measured_columns_may_stand_beside(tmp_path: Path) -> None:
    text = f"{HEADER},shaft_temperature [degC],elongation\n0,1,1,20,0\n10,1,1,21,\n"
    assert len(segments_of(written(tmp_path, text))) == 1


def test_a_pad_is_switched_by_whichever_of_its_cells_is_given(tmp_path: Path) -> None:
    text = "time [s],pad_power [W],pad_temperature [degC]\n0,20,\n10,,36\n20,,\n30,,\n"
    assert [s.pad_mode for s in segments_of(written(tmp_path, text))] == [1, 2, 0]


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    duty = read_recorded(written(tmp_path, "time [s],speed [rad/s]\n0,3\n10,3\n"))
    assert duty.remarks == ("recorded.csv has no column torque, which is taken as 0 N.m",)
    assert read_recorded(written(tmp_path, f"{HEADER}\n{ROWS}")).remarks == ()


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("2026-03-29 01:59:50", "2026-03-29 03:00:00", True),
        ("29.03.2026 01:59:50", "29.03.2026 03:00:00", True),
        ("2026-03-30 01:59:50", "2026-03-30 03:00:00", False),
        ("2026-03-29 08:59:50", "2026-03-29 10:00:00", False),
        ("2026-03-29T00:59:50Z", "2026-03-29T02:00:00Z", False),
    ],
)
def test_an_hour_that_clocks_may_have_skipped_is_said(
    tmp_path: Path, before: str, after: str, said: bool
) -> None:
    head = "time,speed [rad/s],torque [N.m]"
    duty = read_recorded(written(tmp_path, f"{head}\n{before},3,1\n{after},3,2\n"))
    assert duty.stop_time == 3610
    assert len(duty.remarks) == said
    for remark in duty.remarks:
        assert remark.startswith(
            f"recorded.csv: row 3, column 'time': '{after}' is taken to come 3610 s after"
        )
        assert "if clocks were put forward" in remark


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("time [s],torqe [N.m]\n0,1\n1,1", "column 'torqe \\[N.m\\]' is not known; did you mean torque\\?"),
        ("time [s],current [A]\n0,1\n1,1", "column 'current \\[A\\]' is not known; choose .*, or remove it"),
        ("time [s],duration [s]\n0,1\n1,1", "column 'duration \\[s\\]' is not known"),
        ("Zeit [s];Drehzahl [rpm]\n0;1\n1;1", "column 'Zeit \\[s\\]' is not known; choose time, speed, "),
        ("time [s],torque [N.m],torque [N.m]\n0,1,2\n1,1,2", "are both torque; keep one"),
        (
            "time [s],torque [N.m],torque [mN.m]\n0,1,2\n1,1,2",
            "'torque \\[mN.m\\]' are both torque; keep one",
        ),
        ("time [s],time [h]\n0,1\n1,1", "are both time; keep one"),
        (
            "time [s],speed [rpm],torque [N.m]\n0,3,2,,7\n1,3,2\n2,3,2\n3,3,2",
            "the first row has more cells th",
        ),
        ("time [s],speed [rpm],torque [N.m]\n0,3,2\n1,3,2,,7\n2,3,2\n3,3,2", "cannot be read as columns"),
        ("time [s],torque [N.m]\n0,2,5\n1,2,5", "row 2 has more cells than there are headers \\(2\\); give"),
        ("time [s],pad_power [W],pad_temperature [K]\n0,1,300\n1,,", "row 2: .* exclude each other"),
        ("torque [N.m],speed [rad/s]\n1,1\n2,1", "no column 'time \\[s\\]'; add it"),
        ("torque [N.m]\n1\n2", "no columns are found; separate cells by commas"),
        ("time [s],torque [kg]\n1,1\n2,2", "column 'torque \\[kg\\]': .*; give it in N.m"),
        ("time [s],torque\n1,1\n2,2", "column 'torque' has no unit"),
        ("time,torque [N.m]\n1,1\n2,2", "column 'time' has no unit; head it as 'time \\[s\\]'"),
        (
            "time [s],speed [rad/s]\n0,1\n1,-2\n2,3",
            "row 3, column 'speed \\[rad/s\\]': '-2' is below 0; give absolute values",
        ),
        ("time [s],torque [N.m]\n0,much\n1,1", "row 2, column 'torque \\[N.m\\]': 'much' is no reading"),
        (
            "time [s],speed [rpm],torque [N.m]\n0,1,1\n,2,1",
            "row 3, column 'time \\[s\\]': the time is missing",
        ),
        ("time [s],torque [N.m]\n1,1\n1,1", "row 3, .*: 1 s comes after 1 s; times must increase"),
        ("time [s],torque [N.m]\n1,1", "1 rows under the header; give at least two times"),
        ("", "no columns are found"),
        ("time [s],torque [N.m]\n0," + 200_000 * "1", "no columns are found"),
    ],
)
def test_refused_in_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=f"^recorded.csv: .*{sentence}") as refusal:
        read_recorded(written(tmp_path, text))
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 300


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_another_encoding_is_read_as_a_measured_run_is(tmp_path: Path, encoding: str) -> None:
    text = "time [s],speed [rad/s],ambient_temperature [°C]\n0,3,22\n60,3,22\n"
    (segment,) = segments_of(written(tmp_path, text, encoding))
    assert segment.ambient_temperature == pytest.approx(295.15)


@pytest.mark.parametrize("unit", ["rpm", "1/min", "U/min", "r/min"])
def test_a_file_is_read_as_loggers_write_it(tmp_path: Path, unit: str) -> None:
    text = f"""sep=;
# shift of Monday
Time [ms];Speed [{unit}];Torque (Nm);ambient_temperature_degF;Tip temperature [°C]
0;27,50;2,90;71,6;21,5
5000;27,50;2,90;71,6;21,6
10000;0,00;0,00;71,6;21,6
15000;0,00;0,00;72,5;
20000;0,00;0,00;72,5;
"""
    found = segments_of(written(tmp_path, text))
    assert [each.duration for each in found] == [10, 5, 5]
    first, _, last = found
    assert (first.speed, first.torque) == (pytest.approx(27.5 * 2 * math.pi / 60), 2.9)
    assert (first.ambient_temperature, last.ambient_temperature) == (
        pytest.approx(295.15),
        pytest.approx(295.65),
    )


def test_equal_rows_in_sequence_make_one_segment(tmp_path: Path) -> None:
    rows = [f"{5 * i},{3 if (i // 100) % 2 else 0},2" for i in range(1000)]
    duty = read_recorded(written(tmp_path, "\n".join(["time [s],speed [rad/s],torque [N.m]", *rows])))
    assert [each.duration for each in duty.segments] == 9 * [500] + [495]
    assert duty.component_parameters["duration[10]"] == 495


def segments_of(path: Path) -> tuple[Segment, ...]:
    duty = read_recorded(path)
    assert isinstance(duty, Duty)
    return duty.segments


def test_more_segments_than_duty_cycle_holds_are_a_table(tmp_path: Path) -> None:
    rows = [f"{5 * i + 7},{i},{20 + i / 2},{'' if i % 2 else 36}" for i in range(40)]
    head = "time [s],speed [rad/s],ambient_temperature [degC],pad_temperature [degC]"
    path = written(tmp_path, "\n".join([head, *rows]))
    duty = read_recorded(path)
    assert isinstance(duty, Recorded)
    assert duty.stop_time == 5 * 39
    found = dict(zip(duty.table.names, duty.table.over(np.array([0.0, 12.5, 1e4])).T, strict=True))
    assert found["speed"].tolist() == [0, 2, 39]
    assert found["pad_mode"].tolist() == [2, 2, 0]
    assert found["pad_temperature"].tolist() == pytest.approx([309.15, 309.15, 295.15])
    assert found["ambient_temperature"].tolist() == pytest.approx([293.15, 294.15, 312.65])
    linear = read_recorded(path, ["ambient_temperature"])
    assert isinstance(linear, Recorded)
    assert linear.table.over(np.array([12.5]))[0, 2] == pytest.approx(294.40)


def test_a_table_is_unrolled_into_its_rows_up_to_the_end_of_the_run(tmp_path: Path) -> None:
    rows = [f"{5 * i},{i // 2}" for i in range(100)]
    duty = read_recorded(written(tmp_path, "\n".join(["time [s],speed [rad/s]", *rows])))
    first, second, last = duty.until(25.0).unrolled()
    assert [(s.duration, s.speed) for s in (first, second, last)] == [(10, 0), (10, 1), (5, 2)]
    assert duty.until(500.0).remarks[-1] == "recorded ends at 495 s; its last row holds from then on"
    assert len(duty.until(500.0).until(400.0).remarks) == len(duty.remarks)


@pytest.mark.parametrize("constant", [1, 20])
def test_the_last_row_holds_after_it_however_few_rows_there_are(tmp_path: Path, constant: int) -> None:
    rows = [f"{600 * i / constant},{3.43 + 0.01 * i},2.5" for i in range(constant)]
    text = "\n".join(["time [s],speed [rad/s],torque [N.m]", *rows, "600,0,0"])
    duty = read_recorded(written(tmp_path, text))
    assert isinstance(duty, Duty)
    longer = duty.until(1200.0)
    *_, last = longer.unrolled()
    assert (last.duration, last.speed, last.torque) == (600.0, 0.0, 0.0)
    assert longer.start_values()["duty"][f"segment_speed[{constant + 1}]"] == 0.0
    assert longer.remarks == ("recorded ends at 600 s; its last row holds from then on",)
    assert longer.until(600.0) == duty


def test_as_many_segments_as_duty_cycle_holds_are_a_table_after_their_last_row(tmp_path: Path) -> None:
    rows = [f"{10 * i},{i}" for i in range(33)]
    duty = read_recorded(written(tmp_path, "\n".join(["time [s],speed [rad/s]", *rows])))
    assert len(duty.unrolled()) == 32
    assert not duty.tables
    assert duty.until(400.0).tables
    assert duty.until(400.0).unrolled()[-1].speed == 32
    assert duty.until(400.0).remarks[-1] == "recorded ends at 320 s; its last row holds from then on"


def test_so_few_rows_that_are_linear_are_a_table_too(tmp_path: Path) -> None:
    path = written(tmp_path, f"{HEADER}\n{ROWS}")
    assert isinstance(read_recorded(path), Duty)
    assert isinstance(read_recorded(path, ["torque"]), Recorded)
    with pytest.raises(InputError, match=r"^recorded.csv: linear: sped is no column; did you mean speed"):
        read_recorded(path, ["sped"])
    with pytest.raises(InputError, match="linear: stop_and_go has segments and no columns"):
        load("stop_and_go", ["torque"])


LOGGED = "Stamp [s],v [rpm],current [A],room [degC]\n0,30,1,20\n5,60,2,21\n10,0,3,22\n"


def test_a_logs_own_names_are_said_and_the_rest_is_not_read(tmp_path: Path) -> None:
    path = written(tmp_path, LOGGED)
    columns = {"Stamp": "time", "v": "speed", "room [degC]": "ambient_temperature"}
    found = read_recorded(path, columns=columns)
    assert [(s.duration, s.ambient_temperature) for s in found.unrolled()] == [(5, 293.15), (5, 294.15)]
    assert found.unrolled()[0].speed == pytest.approx(math.pi)
    assert found.remarks == ("recorded.csv has no column torque, which is taken as 0 N.m",)
    (tmp_path / "scenario.toml").write_text(
        'duty = "recorded.csv"\n[columns]\nStamp = "time"\nv = "speed"\n', encoding="utf-8"
    )
    assert load_scenario(str(tmp_path / "scenario.toml")).duty.unrolled()[1].speed == pytest.approx(
        2 * math.pi
    )


@pytest.mark.parametrize(
    ("columns", "sentence"),
    [
        ({"v": "speed"}, "no column 'time \\[s\\]'; add it"),
        ({"v": "bogus"}, "columns: 'v': 'bogus' is no column of a duty; choose time, speed, "),
        ({"Stamp": "time", "w": "speed"}, "columns: no column 'w'; choose Stamp, v, current or room"),
        ({"Stamp": "time", "v": "speed", "room": "speed"}, "columns: two columns are speed; keep one"),
    ],
)
def test_names_that_do_not_fit_are_refused(tmp_path: Path, columns: dict[str, str], sentence: str) -> None:
    with pytest.raises(InputError, match=f"^recorded.csv: {sentence}"):
        read_recorded(written(tmp_path, LOGGED), columns=columns)


def test_units_at_the_end_of_names_count_whoever_names_the_columns(tmp_path: Path) -> None:
    path = written(tmp_path, "time_min,v_rpm,I_A\n0,30,1\n5,60,2\n10,0,3\n")
    found = read_recorded(path, columns={"v_rpm": "speed"}).unrolled()
    assert [each.duration for each in found] == [300, 300]
    assert [each.speed for each in found] == pytest.approx([math.pi, 2 * math.pi])


def test_between_spaces_nan_is_an_empty_cell(tmp_path: Path) -> None:
    head = "time[s] speed[rad/s] pad_temperature[degC]"
    found = segments_of(written(tmp_path, f"{head}\n0 1 36\n10 NaN NaN\n20 2 36\n30 2 36\n"))
    assert [(each.speed, each.pad_mode) for each in found] == [(1, 2), (1, 0), (2, 2)]


def test_written_segments_beyond_what_the_component_holds_are_refused_with_a_remedy() -> None:
    duty = Duty("long", "long", "", 39.0, tuple(Segment(1.0, float(i)) for i in range(39)))
    with pytest.raises(InputError, match=r"39 segments are more than the 32 .* as rows of a CSV file"):
        _ = duty.component_parameters


def test_parquet_is_read_as_csv_is(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {"time [s]": np.arange(100.0), "speed [rad/s]": np.arange(100.0) % 7, "growth [um]": 1.0}
    )
    frame.to_parquet(tmp_path / "shift.parquet")
    duty = load(tmp_path / "shift.parquet")
    assert duty.name == "shift"
    assert len(duty.unrolled()) == 99


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.csv: no such file; give an existing"):
        read_recorded(tmp_path / "absent.csv")
