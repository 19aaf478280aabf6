"""Whatever stands in an experiment file or in a cell, the answer is a sentence."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from benchmarks.fuzz.mutate import WRONG, Raw, changed, toml, ways_into
from benchmarks.fuzz.targets import SPECIMENS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.text_files import read_toml

COMPLETE = read_toml(SPECIMENS / "experiment.toml")


def written(folder: Path, content: dict[str, Any]) -> Path:
    shutil.copy(SPECIMENS / "rod.csv", folder)
    path = folder / "rod.toml"
    path.write_text(toml(content))
    return path


def refusal_of(path: Path) -> str:
    """Why a file is refused; empty where it is read."""
    try:
        read_experiment(path)
    except InputError as refusal:
        return str(refusal)
    return ""


def test_the_complete_file_is_read(tmp_path: Path) -> None:
    read = read_experiment(written(tmp_path, COMPLETE))
    assert read.runs[0].labels == {"surface": "shiny"}
    assert read.calibrated[0].per == "surface"


@pytest.mark.parametrize("path", list(ways_into(COMPLETE)), ids=lambda path: ".".join(map(str, path)))
def test_every_key_with_every_wrong_type_gives_a_sentence_or_is_read(
    tmp_path: Path, path: tuple[Any, ...]
) -> None:
    refused = 0
    for text in WRONG:
        refusal = refusal_of(written(tmp_path, changed(COMPLETE, path, Raw(text))))
        for sentence in refusal.splitlines():  # of each mistake
            assert len(sentence) > 20 or sentence.endswith(" more")
            assert len(sentence) < 700
        refused += refusal != ""
    assert refused >= 4


CSV = "time [s],speed [rad/s],torque [N.m],shaft_temperature [degC],elongation [um]\n"
ROWS = [f"{10 * i},3.43,2.5,{22 + 0.1 * i:g},{0.2 * i:g}" for i in range(30)]


@pytest.mark.parametrize(
    "cell", ["1" * 320, "-" + "9" * 400, "1e999", "0x12", "warm", "True", "2,5"], ids=lambda cell: cell[:6]
)
@pytest.mark.parametrize("column", range(5))
def test_a_cell_that_is_no_finite_number_is_named_with_its_row(
    tmp_path: Path, cell: str, column: int
) -> None:
    """In a refusal, or in the remark that it is taken for a missing value."""
    cells = ROWS[7].split(",")
    cells[column] = f'"{cell}"'
    path = tmp_path / "run.csv"
    path.write_text(CSV + "\n".join([*ROWS[:7], ",".join(cells), *ROWS[8:]]) + "\n")
    try:
        (said,) = read_experiment(path).runs[0].remarks
    except InputError as refusal:
        said = str(refusal)
    assert "row 9, column" in said


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_the_encodings_that_spreadsheets_write_are_read(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes((CSV.replace("[um]", "[µm]") + "\n".join(ROWS)).encode(encoding))
    read = read_experiment(path)
    assert read.runs[0].readings["link.elongation"][10] == pytest.approx(2e-6)


@pytest.mark.parametrize("content", [b"\0\1\2\3" * 50, CSV.encode("utf-16-le"), b"", b"\xff\xfe\xff"])
def test_what_is_no_text_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"run\.csv"):
        read_experiment(path)


def test_a_run_in_milliseconds_called_seconds_is_refused_before_it_is_simulated(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    lines = [f"{i * 1e9:g},{row.partition(',')[2]}" for i, row in enumerate(ROWS)]
    path.write_text(CSV + "\n".join(lines) + "\n")
    with pytest.raises(InputError, match="at most 100 can be simulated"):
        read_experiment(path)
