"""One run with what loggers write into names and cells: the same numbers, or a sentence with the remedy."""

from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.data.logger_variants import (
    NAMES,
    PLAIN,
    ROWS,
    UNITS,
    Variant,
    check,
    given,
    plain,
    text,
)
from tests.orchestration.diagnosis.data.test_logger_files import VARIANTS as FORMS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment

pytestmark = pytest.mark.usefixtures("as_a_command")

LONE = ("time", "v", "M", "T_room", "T_base", "growth")
MAPPED = [f"{one}={other}" for one, other in zip(LONE[1:], NAMES[1:], strict=True)]


def with_cell(cell: str, row: int = 20, column: int = 4) -> str:
    rows = [list(each) for each in ROWS]
    rows[row][column] = cell
    return text(rows=rows)


VARIANTS = {
    "other names": Variant(
        text(header=[f"{n} [{u}]" for n, u in zip(LONE, UNITS, strict=True)]),
        'say --map "v=speed" --map "M=torque", or leave one out',
    ),
    "two that may be one": Variant(
        text().replace("speed [", "n1 [").replace("torque [", "n2 [").replace("N.m", "rpm"),
        'say --map "n1=speed", or leave it out',
    ),
    "other names for what is measured alone": Variant(
        text().replace("base_temperature", "sonde").replace("elongation", "growth"),
        "may be among 'sonde [degC]', 'growth [um]'",
    ),
    "other names over a row of units": Variant(
        ";".join(LONE) + "\n" + text(";", list(UNITS)).replace("base", "b"), "perhaps speed"
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
    "OVERLOAD of an input": Variant(with_cell("OVERLOAD", column=3), replaced=1, within=2e-4),
    "9999 of an input": Variant(with_cell("9999", column=2), replaced=1),
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
}


def test_there_are_forty_and_more() -> None:
    assert len(VARIANTS) + len(FORMS) >= 80


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_gives_the_same_numbers_or_a_sentence(name: str, tmp_path: Path) -> None:
    check(VARIANTS[name], tmp_path)


def test_a_pad_is_off_where_nothing_or_off_is_written_and_holds_where_it_was_not_read(tmp_path: Path) -> None:
    cells = ["36"] * 10 + ["OVERLOAD"] * 2 + ["off"] * 10 + [""] * 10 + ["40"] * 28
    rows = [[*row, cell] for row, cell in zip(ROWS, cells, strict=True)]
    path = given(Variant(text(header=[*PLAIN, "pad_temperature [degC]"], rows=rows)), tmp_path)
    pad = read_experiment(path).runs[0].inputs["motor.pad_temperature"]
    assert np.isfinite(pad).tolist() == [True] * 12 + [False] * 20 + [True] * 28
    assert pad[11] == pytest.approx(309.15)


@pytest.mark.parametrize("header", ["T1 [degC]", "T1 (°C)", "T1"])
def test_the_channels_of_an_experiment_are_found_however_the_unit_is_written(
    header: str, tmp_path: Path
) -> None:
    given(Variant(text(";", [*PLAIN[:4], header, PLAIN[5]], decimal=",")), tmp_path)
    path = tmp_path / "rig.toml"
    channels = '[channels]\n"T1 [degC]" = "link.base_temperature"\n'
    path.write_text(f'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n{channels}')
    found = read_experiment(path).runs[0].readings["link.base_temperature"]
    assert np.array_equal(found, plain().runs[0].readings["link.base_temperature"])


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
