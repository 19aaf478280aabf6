"""One run as loggers write files, headers, units and times: the same numbers, or a sentence."""

from datetime import timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.orchestration.diagnosis.data.logger_variants import (
    BEGIN,
    NAMES,
    PLAIN,
    ROWS,
    UNITS,
    Variant,
    check,
    headed,
    text,
    timed,
)

pytestmark = pytest.mark.usefixtures("as_a_command")


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
    "a row of units with brackets in them": Variant(
        text(";", [*NAMES]).replace("\n", f"\n{';'.join(UNITS).replace('rad/s', 'rad/(s)')}\n", 1)
    ),
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
    "facts about the start above": Variant("Start;22.11.2026;08:59:31\n" + text(";")),
    "a dash for the unit of a date": Variant(
        timed("%d.%m.%Y %H:%M:%S").replace(",", ";").replace("\n", "\n-;;;;;\n", 1)
    ),
    "no header": Variant(text().partition("\n")[2], "no header row"),
    "headers alone": Variant(text().partition("\n")[0] + "\n", "there are no rows below its only line"),
    "one column": Variant("time [s]\n" + "\n".join(str(i) for i in range(60)), "no columns are found"),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_gives_the_same_numbers_or_a_sentence(name: str, tmp_path: Path) -> None:
    check(VARIANTS[name], tmp_path)
