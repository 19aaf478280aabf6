"""What made a log end in a traceback, or in advice that did not help."""

import re
from datetime import timedelta
from pathlib import Path

import pandas as pd
import pytest

from tests.orchestration.diagnosis.data.logger_variants import PLAIN, ROWS, Variant, check, text, timed
from tests.shared_data import given
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.diagnose import read

pytestmark = pytest.mark.usefixtures("as_a_command")

NOTED = [*PLAIN, "note"]


def noted(**notes: str) -> str:
    """The file with a column of notes, some of them as given: `_20='"5'` is that of row 20."""
    return text(header=NOTED, rows=[[*row, notes.get(f"_{i}", "")] for i, row in enumerate(ROWS)])


def local(i: int, at: object) -> str:
    """Time on the clock of Berlin in the night in which summer time ends."""
    begins = pd.Timestamp("2025-10-26 00:55", tz="UTC").tz_convert("Europe/Berlin")
    return f"{begins + timedelta(seconds=15 * i):%Y-%m-%d %H:%M:%S}"


def without_time(header: str, cell: str = "7") -> str:
    return text(header=[header, *PLAIN[1:]], rows=[[cell, *row[1:]] for row in ROWS])


VARIANTS = {
    "a quote that is never closed": Variant(noted(_20='"5'), "row 22: a quote"),
    "a quote that takes in rows": Variant(noted(_20='"5', _30='6"'), "takes in the 10 lines below; close it"),
    "a quote in the header": Variant(
        text(header=[*PLAIN, '"'], rows=[[*r, ""] for r in ROWS]), "row 1: a quote"
    ),
    "a quote in the first row": Variant(
        'time [s],speed [rad/s],torque [N.m]\n0,"\n60,3,2\n', "row 2: a quote"
    ),
    "a quote between spaces": Variant(text(" ").replace(" 2.5 ", ' "2.5 ', 1), "row 2: a quote"),
    "a note of two lines": Variant(noted(_59='"door open\nagain"'), names=("note=",)),
    "inches": Variant(noted(_20='pipe of 5"'), names=("note=",)),
    "a blank line of an old Macintosh": Variant("\r" + text().replace("\n", "\r")),
    "line ends of two kinds": Variant("\r" + text()),
    "a DataFrame without rows": Variant(pd.DataFrame(columns=PLAIN, dtype=float), "no rows under the header"),
    "seconds since 1970 with their unit": Variant(timed(lambda i, at: f"{1795391521.5 + 15 * i}s")),
    "milliseconds with their unit, between semicolons": Variant(
        timed(lambda i, at: f"{15000 * i} ms").replace(",", ";")
    ),
    "a unit in the cells against the header": Variant(
        timed(lambda i, at: f"{15 * i} s", "time [ms]"), "its header says ms, its cells s"
    ),
    "minutes and seconds": Variant(timed(lambda i, at: f"{15 * i // 60}:{15 * i % 60:02d}.0", "Time (s)")),
    "minutes and seconds over the hour": Variant(
        timed(lambda i, at: f"{(15 * i // 60 + 55) % 60:02d}:{15 * i % 60:02d}.5")
    ),
    "minutes and seconds, then hours": Variant(
        timed(lambda i, at: str(timedelta(seconds=3300.25 + 15 * i))[:-4].removeprefix("0:"))
    ),
    "the night in which summer time ends": Variant(
        timed(local),
        "'2025-10-26 02:00:00' comes after '2025-10-26 02:59:45': the clock goes back by an hour",
    ),
    "MATLAB": Variant(
        b"MATLAB 5.0 MAT-file, Platform: PCWIN64\0\1IM" + bytes(90), "is a MATLAB file; export"
    ),
    "HDF5": Variant(b"\x89HDF\r\n\x1a\n\0\0", "is an HDF5 file"),
    "a workbook that is called CSV": Variant(b"PK\x03\x04\x14\0", "its ending .xlsx"),
    "no column that may be a time": Variant(
        without_time("delta L [um]"), "no time column; add the times of the rows, headed 'time [s]'"
    ),
    "no column of times, and words": Variant(without_time("who", "Kim"), "add the times of the rows"),
    "times under another name": Variant(text(header=["clk", *PLAIN[1:]]), '--map "clk=time"'),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_gives_the_same_numbers_or_a_sentence(name: str, tmp_path: Path) -> None:
    check(VARIANTS[name], tmp_path)


def test_only_what_the_system_has_is_offered(tmp_path: Path) -> None:
    """A motor by itself has no base; what a word says, and then the order, decides."""
    columns = ["time [s]", "spare (degC)", "wind (degC)", "room (degC)", "ambient (degC)", "heater (%)"]
    (tmp_path / "a.csv").write_text(text(header=columns))
    (tmp_path / "a.toml").write_text('system = "BenchMotor"\n[[run]]\ndata = "a.csv"\n')
    with pytest.raises(InputError) as refusal:
        read_experiment(tmp_path / "a.toml")
    told = str(refusal.value)
    assert "give at least one of motor.shaft_temperature, motor.winding_temperature, and say" in told
    maps = ("spare=motor.shaft", "wind=motor.winding", "ambient=motor.ambient")
    assert told.endswith(" ".join(f'--map "{each}_temperature"' for each in maps))


@pytest.mark.parametrize("name", ["min1", "min2", "min3", "arm", "dst", "duty-559-duty", "duty-1394-duty"])
def test_logs_that_ended_in_a_traceback_are_refused_in_a_sentence(name: str) -> None:
    with pytest.raises(InputError):
        read_experiment(given(f"logs_that_fail/{name}.csv"))


def test_all_that_is_wrong_with_a_file_is_told_at_once(tmp_path: Path) -> None:
    rows = [f"{60 * i},30,2.5,{22 + 0.1 * i:.1f}" for i in range(40)]
    rows[20], rows[21] = rows[21], rows[20]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["time [s],speed [rpmm],torque [kg],base_temperature [degC]", *rows]))
    with pytest.raises(InputError) as refused:
        read([path])
    columns = [re.findall(r"column '(\w+)", each) for each in str(refused.value).splitlines()]
    assert columns == [["time"], ["speed"], ["torque"]]
