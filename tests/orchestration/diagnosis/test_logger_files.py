"""One run as many loggers write it: each file gives the same numbers, or a sentence with the remedy."""

from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.columns import Said, said
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_experiment

NAMES = ("time", "speed", "torque", "ambient_temperature", "base_temperature", "elongation")
UNITS = ("s", "rad/s", "N.m", "degC", "degC", "um")
LONE = ("time", "v", "M", "T_room", "T_base", "growth")
MAPPED = [f"{one}={other}" for one, other in zip(LONE[1:], NAMES[1:], strict=True)]
ROWS = [
    [
        f"{15 * i}",
        "3.43" if i < 30 else "0",
        "2.5",
        f"{22 + i / 64:.4f}",
        f"{22.25 + i / 8:.3f}",
        f"{i * 1.25}",
    ]
    for i in range(60)
]
BEGIN = datetime(2026, 11, 22, 23, 52, 1)
"""A start from which the run goes over midnight."""

TEXT = Callable[[], str | bytes]


def headed(form: str, units: tuple[str, ...] = UNITS) -> list[str]:
    return [form.format(name, unit) for name, unit in zip(NAMES, units, strict=True)]


PLAIN = headed("{} [{}]")


def text(
    separator: str = ",", header: list[str] = PLAIN, rows: list[list[str]] = ROWS, decimal: str = "."
) -> str:
    lines = [header, *([cell.replace(".", decimal) for cell in row] for row in rows)]
    return "\n".join(separator.join(line) for line in lines) + "\n"


def timed(form: str | Callable[[int, datetime], str], header: str = "time", step: int = 15) -> str:
    """The file with other times, written by a form of `strftime` or by the number of the row."""

    def stamp(i: int) -> str:
        at = BEGIN + timedelta(seconds=step * i)
        return at.strftime(form) if isinstance(form, str) else form(i, at)

    return text(header=[header, *PLAIN[1:]], rows=[[stamp(i), *row[1:]] for i, row in enumerate(ROWS)])


def with_cell(cell: str, row: int = 20, column: int = 4) -> str:
    rows = [list(each) for each in ROWS]
    rows[row][column] = cell
    return text(rows=rows)


def frame() -> pd.DataFrame:
    return pd.DataFrame({name: [float(row[i]) for row in ROWS] for i, name in enumerate(PLAIN)})


def with_times(values: object, name: str = "timestamp") -> pd.DataFrame:
    return frame().drop(columns="time [s]").assign(**{name: values})


def stamps() -> pd.DatetimeIndex:
    return pd.DatetimeIndex([BEGIN + timedelta(seconds=15 * i) for i in range(60)])


def parquet(path: Path) -> None:
    frame().to_parquet(path)


def dated_parquet(path: Path) -> None:
    frame().drop(columns="time [s]").set_index(stamps()).to_parquet(path)


def workbook(path: Path) -> None:
    pytest.importorskip("openpyxl")
    frame().to_excel(path, index=False)


def dated_workbook(path: Path) -> None:
    """With a title, a row of units and dates in cells."""
    pytest.importorskip("openpyxl")
    table = with_times(stamps(), "Timestamp")[["Timestamp", *PLAIN[1:]]]
    units = pd.DataFrame([dict(zip(["Timestamp", *NAMES[1:]], ["", *UNITS[1:]], strict=True))])
    table = table.set_axis(["Timestamp", *NAMES[1:]], axis=1).astype(object)
    pd.concat([units, table]).to_excel(path, index=False, startrow=3)


def two_sheets(path: Path) -> None:
    pytest.importorskip("openpyxl")
    with pd.ExcelWriter(path) as book:
        frame().to_excel(book, sheet_name="monday", index=False)
        frame().to_excel(book, sheet_name="tuesday", index=False)


class Variant(NamedTuple):
    """A file, what is said of it, and what is expected: the same numbers, or a part of the refusal."""

    content: str | bytes | pd.DataFrame | Callable[[Path], None]
    refused: str = ""
    units: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    decimal: str = ""
    suffix: str = ".csv"
    missing: int = 0
    within: float = 0.0

    @property
    def told(self) -> Said:
        return said(self.units, self.names, self.decimal)


COLUMNS = tuple(f"{name}={unit}" for name, unit in zip(NAMES, UNITS, strict=True))
TOA5 = (
    '"TOA5","CR1000","CR1000","1234","CR1000.Std.32","CPU:cell.CR1","5","Table1"\n'
    + ",".join(f'"{n}"' for n in ("TIMESTAMP", "RECORD", *NAMES[1:]))
    + "\n"
    + ",".join(f'"{u}"' for u in ("TS", "RN", *UNITS[1:]))
    + '\n"","","Smp","Smp","Avg","Avg","Avg"\n'
    + "".join(
        f'"{(BEGIN + timedelta(seconds=15 * i)):%Y-%m-%d %H:%M:%S}",{i},{",".join(row[1:])}\n'
        for i, row in enumerate(ROWS)
    )
)
METRIC = [
    "time [min]",
    "speed [rpm]",
    "torque [mN.m]",
    *headed("{} [{}]", (*UNITS[:3], "K", "degF", "mm"))[3:],
]
CONVERTED = [
    [
        repr(float(t) / 60),
        repr(float(v) * 30 / np.pi),
        repr(float(m) * 1000),
        repr(float(a) + 273.15),
        repr(float(b) * 1.8 + 32),
        repr(float(e) / 1000),
    ]
    for t, v, m, a, b, e in ROWS
]
BIG = [[*row[:5], f"{1000 + i},{i:03d}"] for i, row in enumerate(ROWS)]

VARIANTS = {
    "semicolons": Variant(text(";")),
    "semicolons and decimal commas": Variant(text(";", decimal=",")),
    "tabs": Variant(text("\t"), suffix=".txt"),
    "tabs and decimal commas": Variant(text("\t", decimal=","), suffix=".tsv"),
    "spaces": Variant(text("   "), suffix=".dat"),
    "spaces and decimal commas": Variant(text("  ", header=[*NAMES], decimal=","), units=COLUMNS),
    "bars": Variant(text("|")),
    "every cell in quotes": Variant('"' + text('","').replace("\n", '"\n"').removesuffix('"')),
    "quoted decimal commas between commas": Variant(
        '"' + text('","', decimal=",").replace("\n", '"\n"').removesuffix('"')
    ),
    "separator said as Excel does": Variant("sep=;\n" + text(";", decimal=",")),
    "a separator at the end of each row": Variant(text(";").replace("\n", ";\n")),
    "a byte order mark": Variant(text().encode("utf-8-sig")),
    "Latin-1": Variant(
        text(";", headed("{} [{}]", (*UNITS[:3], "°C", "°C", "µm")), decimal=",").encode("latin-1")
    ),
    "UTF-16": Variant(text("\t").encode("utf-16")),
    "UTF-16 without its mark": Variant(text("\t").encode("utf-16-le"), "save it as UTF-8"),
    "lines of Windows": Variant(text().replace("\n", "\r\n")),
    "lines of an old Macintosh": Variant(text().replace("\n", "\r")),
    "blank lines": Variant("\n\n" + text().replace("\n", "\n\n", 3) + "\n\n\n"),
    "comments above": Variant("# logger 3000\n# started by hand, 3 sensors\n" + text()),
    "a comment among the rows": Variant(text().replace("\n300,", "\n# door opened\n300,")),
    "the header in a comment": Variant("# " + text(" ")),
    "lines about the logger above": Variant("Logger: DAQ 3000\nSerial: 17\n\n" + text(";", decimal=",")),
    "rows about the logger, filled up": Variant("Logger;DAQ 3000;;;;\nSerial;17;;;;\n" + text(";")),
    "a row of units": Variant(text(";", [*NAMES]).replace("\n", f"\n{';'.join(UNITS)}\n", 1)),
    "a row of units in brackets": Variant(
        text(",", [*NAMES]).replace("\n", "\n" + ",".join(f"[{unit}]" for unit in UNITS) + "\n", 1)
    ),
    "a data logger with four header rows": Variant(TOA5),
    "units in parentheses": Variant(text(header=headed("{} ({})"))),
    "units behind a slash": Variant(text(header=headed("{} / {}"))),
    "units at the end of the name": Variant(
        text(header=headed("{}_{}", ("s", "rad_s", "Nm", "degC", "C", "um")))
    ),
    "names in capitals with spaces": Variant(
        text(header=[h.replace("_", " ").title() for h in headed("{}")]), units=COLUMNS
    ),
    "units in other spellings": Variant(
        text(header=headed("{} ({})", ("sec", "rad/s", "Nm", "C", "℃", "µm")))
    ),
    "other units": Variant(text(header=METRIC, rows=CONVERTED), within=1e-9),
    "no units": Variant(text(header=[*NAMES]), 'give --unit "time=s"'),
    "units given for each quantity": Variant(
        text(header=[*NAMES]), units=("s", "rad/s", "N.m", "degC", "um")
    ),
    "units given for each column": Variant(text(header=[*NAMES]), units=COLUMNS),
    "a unit given against the header": Variant(
        text(), "is in degC already", units=("base_temperature=degF",)
    ),
    "a unit for no column": Variant(text(), "no such column", units=("T_basis=degC",)),
    "a unit of another quantity": Variant(
        text(header=headed("{} [{}]", (*UNITS[:4], "um", "um"))), "does not convert"
    ),
    "ISO times": Variant(timed("%Y-%m-%dT%H:%M:%S")),
    "ISO times with zone and fraction": Variant(timed("%Y-%m-%d %H:%M:%S.250+01:00", "timestamp")),
    "German dates": Variant(timed("%d.%m.%Y %H:%M:%S")),
    "German dates of two digits": Variant(timed("%d.%m.%y %H:%M:%S")),
    "American dates with PM": Variant(timed("%m/%d/%Y %I:%M:%S %p")),
    "dates with the month in letters": Variant(timed("%d-%b-%Y %H:%M:%S")),
    "dates that may begin with the month": Variant(
        timed(lambda i, at: f"{3 + (at.day - 22)}/04/2026 {at:%H:%M:%S}"),
        "may begin with the day or the month",
    ),
    "the same dates, said how": Variant(
        timed(lambda i, at: f"{3 + (at.day - 22)}/04/2026 {at:%H:%M:%S}"), units=("time=%d/%m/%Y %H:%M:%S",)
    ),
    "a clock over midnight": Variant(timed("%H:%M:%S")),
    "a clock with thousandths behind a comma": Variant(
        text(
            ";",
            ["time", *PLAIN[1:]],
            [[f"{BEGIN + timedelta(seconds=15 * i):%H:%M:%S,000}", *row[1:]] for i, row in enumerate(ROWS)],
            ",",
        )
    ),
    "a clock without seconds": Variant(timed("%H:%M", step=60), "is not of the form HH:MM:SS"),
    "seconds since 1970": Variant(timed(lambda i, at: f"{1795391521 + 15 * i}")),
    "thousandths since 1970": Variant(timed(lambda i, at: f"{1795391521000 + 15000 * i}", "timestamp")),
    "date and time in two columns": Variant(timed("%d.%m.%Y,%H:%M:%S", "Date,Time")),
    "a time beside the seconds": Variant(
        timed(lambda i, at: f"{at:%d.%m.%Y %H:%M:%S},{15 * i}", "timestamp,time [s]")
    ),
    "Parquet": Variant(parquet, suffix=".parquet"),
    "Parquet with dates for an index": Variant(dated_parquet, suffix=".parquet"),
    "no Parquet": Variant(text(), "cannot be read as Parquet", suffix=".parquet"),
    "a workbook": Variant(workbook, suffix=".xlsx"),
    "a workbook with a title, units and dates": Variant(dated_workbook, suffix=".xlsx"),
    "a workbook of two sheets": Variant(two_sheets, "has 2 sheets", suffix=".xlsx"),
    "a DataFrame": Variant(frame()),
    "a DataFrame with dates for an index": Variant(frame().drop(columns="time [s]").set_index(stamps())),
    "a DataFrame of texts": Variant(frame().astype(str)),
    "other names": Variant(
        text(header=[f"{n} [{u}]" for n, u in zip(LONE, UNITS, strict=True)]), "may be speed"
    ),
    "other names over a row of units": Variant(
        ";".join(LONE) + "\n" + text(";", list(UNITS)).replace("base", "b"), "may be speed"
    ),
    "other names, said": Variant(
        text(header=[f"{n} [{u}]" for n, u in zip(LONE, UNITS, strict=True)]), names=tuple(MAPPED)
    ),
    "a name mistyped": Variant(
        text().replace("base_temperature", "base_temprature"), '--map "base_temprature=base_'
    ),
    "a name for no column": Variant(text(), "there is no column 'T9'", names=("T9=middle_temperature",)),
    "a name that is no variable": Variant(text(), "is no column of WarmupCell", names=("torque=torqe",)),
    "columns that nothing is made of": Variant(
        text(header=[*PLAIN, "fan [rpm]", "operator"], rows=[[*row, "900", "Kim"] for row in ROWS]),
        names=("fan=",),
    ),
    "two columns of one name": Variant(
        text(header=[*PLAIN, PLAIN[4]], rows=[[*row, "7"] for row in ROWS]), "are both"
    ),
    "OVERLOAD": Variant(with_cell("OVERLOAD"), missing=1),
    "ERR": Variant(with_cell("ERR"), missing=1),
    "dashes": Variant(with_cell("---"), missing=1),
    "NaN": Variant(with_cell("NaN"), missing=1),
    "1e99": Variant(with_cell("1e99"), missing=1),
    "9.9E+37": Variant(with_cell("9.9E+37"), missing=1),
    "infinity": Variant(with_cell("-inf"), missing=1),
    "-9999": Variant(with_cell("-9999"), missing=1),
    "a thermometer's own mark": Variant(with_cell("-127.0"), missing=1),
    "OVERLOAD of an input": Variant(with_cell("OVERLOAD", column=3), within=2e-4),
    "9999 of an input": Variant(with_cell("9999", column=2)),
    "a number with its unit": Variant(with_cell("22.5 °C"), "is not a number"),
    "a word for a time": Variant(with_cell("ERR", column=0), "is no time"),
    "the header again among the rows": Variant(
        text().replace("\n300,", "\n" + ",".join(PLAIN) + "\n300,"), "is no time"
    ),
    "an end that is no row": Variant(text() + "End of file\n", "is no time"),
    "a row that is longer": Variant(text().replace("\n300,", "\n300,1,"), "give every column a header"),
    "commas for both": Variant(text(decimal=","), "commas are decimal marks too"),
    "two decimal marks": Variant(
        text(";").replace("\n300;3.43", "\n300;3,43"), "say --decimal comma or --decimal point"
    ),
    "thousands or decimals": Variant(
        text(";", rows=[[f"{15 * i}", "3", "2", "22", "23", f"1,{i:03d}"] for i in range(60)]),
        "--decimal comma",
    ),
    "rows that go back": Variant(text(rows=[*ROWS[30:], *ROWS[:30]]), "times must increase"),
    "an empty cell between spaces": Variant(
        text(" ").replace("\n300 3.43", "\n300     "), "between spaces an empty cell is not seen"
    ),
    "words in the first row": Variant(
        text(rows=[["0", "3.43", "2.5", "22", "ERR", "ERR"], *ROWS[1:]]), missing=2
    ),
    "words in most of the first row": Variant(
        text(";", rows=[["0", "OL", "OL", "OL", "OL", "OL"], *ROWS[1:]]), "needs a value in the first row"
    ),
    "a temperature called T": Variant(
        text(header=["t [s]", *PLAIN[1:4], "T [degC]", PLAIN[5]]), names=("T=base_temperature",)
    ),
    "facts about the start above": Variant("Start;22.11.2026;08:59:31\n" + text(";")),
    "a dash for the unit of a date": Variant(
        timed("%d.%m.%Y %H:%M:%S").replace(",", ";").replace("\n", "\n-;;;;;\n", 1)
    ),
    "no header": Variant(text().partition("\n")[2], "no header row"),
    "one column": Variant("time [s]\n" + "\n".join(str(i) for i in range(60)), "no columns are found"),
}


def given(variant: Variant, folder: Path) -> Path | pd.DataFrame:
    path = folder / f"run{variant.suffix}"
    if isinstance(variant.content, pd.DataFrame):
        return variant.content
    if callable(variant.content):
        variant.content(path)
    else:
        content = variant.content
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    return read_experiment(given(Variant(text()), tmp_path_factory.mktemp("plain")))


def test_there_are_forty_and_more() -> None:
    assert len(VARIANTS) >= 80


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_gives_the_same_numbers_or_a_sentence(name: str, plain: Experiment, tmp_path: Path) -> None:
    variant = VARIANTS[name]
    source = given(variant, tmp_path)
    if variant.refused:
        with pytest.raises(InputError) as refusal:
            read_experiment(source, variant.told)
        assert variant.refused in str(refusal.value)
        assert "\n" not in str(refusal.value)
        return
    (read,), (wanted,) = read_experiment(source, variant.told).runs, plain.runs
    assert np.array_equal(read.time, wanted.time) or variant.within
    assert np.allclose(read.time, wanted.time, rtol=variant.within, atol=0)
    for kind in ("inputs", "readings"):
        one, other = getattr(read, kind), getattr(wanted, kind)
        assert one.keys() == other.keys()
        for variable, values in one.items():
            there = np.isfinite(values)
            assert np.allclose(values[there], other[variable][there], rtol=variant.within, atol=0), variable
    gaps = sum(int(np.isnan(values).sum()) for values in read.readings.values())
    assert gaps == variant.missing
    assert len(read.remarks) == (1 if "of an input" in name else variant.missing)
    assert all("row 22, column" in remark or "row 2, column" in remark for remark in read.remarks)


def test_a_pad_is_off_where_nothing_or_off_is_written_and_holds_where_it_was_not_read(tmp_path: Path) -> None:
    cells = ["36"] * 10 + ["OVERLOAD"] * 2 + ["off"] * 10 + [""] * 10 + ["40"] * 28
    rows = [[*row, cell] for row, cell in zip(ROWS, cells, strict=True)]
    path = given(Variant(text(header=[*PLAIN, "pad_temperature [degC]"], rows=rows)), tmp_path)
    pad = read_experiment(path).runs[0].inputs["motor.pad_temperature"]
    assert np.isfinite(pad).tolist() == [True] * 12 + [False] * 20 + [True] * 28
    assert pad[11] == pytest.approx(309.15)


@pytest.mark.parametrize("header", ["T1 [degC]", "T1 (°C)", "T1"])
def test_the_channels_of_an_experiment_are_found_however_the_unit_is_written(
    header: str, plain: Experiment, tmp_path: Path
) -> None:
    given(Variant(text(";", [*PLAIN[:4], header, PLAIN[5]], decimal=",")), tmp_path)
    path = tmp_path / "rig.toml"
    channels = '[channels]\n"T1 [degC]" = "link.base_temperature"\n'
    path.write_text(f'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n{channels}')
    found = read_experiment(path).runs[0].readings["link.base_temperature"]
    assert np.array_equal(found, plain.runs[0].readings["link.base_temperature"])


def test_times_without_a_single_one_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time [s],speed [rad/s],tip_temperature [degC]\n,1,22\n,2,23\n,3,24\n")
    with pytest.raises(InputError):
        read_experiment(path)


def test_an_experiment_without_channels_names_the_columns_it_has(tmp_path: Path) -> None:
    (tmp_path / "rod.csv").write_text("time [s],heater_on [1],T1 [degC]\n0,1,22\n10,1,23\n20,1,24\n")
    path = tmp_path / "rod.toml"
    path.write_text('title = "Rod"\nsystem = "BenchRod"\n[[run]]\ndata = "rod.csv"\n')
    with pytest.raises(InputError):
        read_experiment(path)
