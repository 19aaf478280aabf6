"""Recorded duty cycles: what a CSV file may hold, and what is refused instead of being left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.duties.duty_files import read_csv

HEADER = "time [min],speed [rad/s],torque [N.m]"
ROWS = "0,3.43,2.5\n10,0,0\n20,3.43,2.5"


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "recorded.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_rows_become_segments(tmp_path: Path, encoding: str) -> None:
    duty = read_csv(written(tmp_path, f"{HEADER}\n{ROWS}\n\n", encoding))
    assert [(s.duration, s.speed, s.torque) for s in duty.segments] == [(600, 3.43, 2.5), (600, 0, 0)]
    assert duty.stop_time == 1200


def test_measured_columns_may_stand_beside(tmp_path: Path) -> None:
    text = f"{HEADER},shaft_temperature [degC],elongation\n0,1,1,20,0\n10,1,1,21,\n"
    assert len(read_csv(written(tmp_path, text)).segments) == 1


def test_a_pad_is_switched_by_whichever_of_its_cells_is_given(tmp_path: Path) -> None:
    text = "time [s],pad_power [W],pad_temperature [degC]\n0,20,\n10,,36\n20,,\n30,,\n"
    assert [s.pad_mode for s in read_csv(written(tmp_path, text)).segments] == [1, 2, 0]


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    duty = read_csv(written(tmp_path, "time [s],speed [rad/s]\n0,3\n10,3\n"))
    assert duty.remarks == ("recorded.csv has no column torque, which is taken as 0 N.m",)
    assert read_csv(written(tmp_path, f"{HEADER}\n{ROWS}")).remarks == ()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("time [s],torqe [N.m]\n0,1\n1,1", "column 'torqe' is not known; did you mean torque\\?"),
        ("time [s],current [A]\n0,1\n1,1", "column 'current' is not known; choose .*, or remove it"),
        ("time [s],duration [s]\n0,1\n1,1", "column 'duration' is not known"),
        ("time [s],torque [N.m],torque [N.m]\n0,1,2\n1,1,2", "column 'torque' stands twice; keep one"),
        ("time [s],torque [N.m],torque [mN.m]\n0,1,2\n1,1,2", "column 'torque' stands twice; keep one"),
        ("time [s],time [h]\n0,1\n1,1", "column 'time' stands twice; keep one"),
        ("time [s];torque [N.m]\n0;1\n1;1", "is not of the form 'name \\[unit\\]'"),
        ("time [s],torque [N.m]\n0,2,5\n1,2,5", "line 2: 3 cells under 2 columns; mend the row"),
        ("time [s],torque [N.m]\n\n0,2\n1", "line 4: 1 cells under 2 columns; mend the row"),
        ("time [s],pad_power [W],pad_temperature [K]\n0,1,300\n1,,", "line 2: .* exclude each other"),
        ("torque [N.m]\n1\n2", "no column 'time \\[s\\]'; add it"),
        ("time [s],torque [kg]\n1,1\n2,2", "column 'torque': .*; give it in N.m"),
        ("time [s],torque\n1,1\n2,2", "column 'torque' has no unit"),
        ("time [s],torque [N.m]\n0,much\n1,1", "line 2: 'much' in column 'torque' is no number"),
        ("time [s],torque [N.m]\n1,1\n1,1", "line 3: time is missing or does not increase"),
        ("time [s],torque [N.m]\n1,1", "1 rows under the header; give at least two times"),
        ("", "is empty; give a header"),
        ("time [s],torque [N.m]\n0," + 200_000 * "1", "line 2: field larger than field limit"),
    ],
)
def test_refused_in_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=f"^recorded.csv: .*{sentence}") as refusal:
        read_csv(written(tmp_path, text))
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 300


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_another_encoding_is_named_as_such(tmp_path: Path, encoding: str) -> None:
    text = f"{HEADER},ambient_temperature [°C]\n{ROWS}"
    with pytest.raises(InputError, match=r"recorded\.csv: line 1 is not text in UTF-8"):
        read_csv(written(tmp_path, text, encoding))


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.csv: no such file; give an existing"):
        read_csv(tmp_path / "absent.csv")
