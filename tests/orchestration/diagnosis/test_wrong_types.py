"""Whatever stands in an experiment file or in a cell, the answer is a sentence."""

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment import read_experiment

COMPLETE: dict[str, Any] = {
    "title": "Rod",
    "system": "BenchRod",
    "initial": "measured",
    "run": [
        {
            "data": "rod.csv",
            "labels": {"surface": "shiny"},
            "heldout": False,
            "adapt": "1 min",
            "known": {"link.width": "20 mm"},
        }
    ],
    "channels": {"on [1]": "heater.on", "T1 [degC]": "link.sensor_temperature[1]"},
    "covariates": {"far [degC]": "neighbour_temperature"},
    "known": {"link.length": "330 mm"},
    "calibrate": {"heater.power": {"min": "1 W", "max": "9 W", "start": "2 W", "per": "surface"}},
    "causes": {"per": ["surface"]},
    "noise": {"link.sensor_temperature[1]": "0.1 K"},
}

WRONG = {
    "text": '"x"',
    "number": "3",
    "endless": "9" * 320,
    "not a number": "nan",
    "switch": "true",
    "list": "[]",
    "list of lists": '[["a"]]',
    "table": "{ a = 1 }",
    "date": "2026-01-01",
}


def paths(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if path:
        yield path
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in items:
        yield from paths(value, (*path, key))


def toml(value: Any) -> str:
    if isinstance(value, Raw):
        return value.text
    if isinstance(value, dict):
        return "{ " + ", ".join(f'"{key}" = {toml(each)}' for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else f'"{value}"'


class Raw:
    """A value as it stands in the file."""

    def __init__(self, text: str) -> None:
        self.text = text


def written(folder: Path, content: dict[str, Any]) -> Path:
    lines = [f"{10 * i},1,{20 + 0.1 * i:g},21" for i in range(30)]
    (folder / "rod.csv").write_text("time [s],on [1],T1 [degC],far [degC]\n" + "\n".join(lines) + "\n")
    path = folder / "rod.toml"
    path.write_text("\n".join(f"{key} = {toml(value)}" for key, value in content.items()))
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


@pytest.mark.parametrize("path", list(paths(COMPLETE)), ids=lambda path: ".".join(map(str, path)))
def test_every_key_with_every_wrong_type_gives_a_sentence_or_is_read(
    tmp_path: Path, path: tuple[Any, ...]
) -> None:
    refused = 0
    for text in WRONG.values():
        content = copy.deepcopy(COMPLETE)
        inner = content
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = Raw(text)
        sentence = refusal_of(written(tmp_path, content))
        assert "\n" not in sentence
        assert len(sentence) < 600
        refused += sentence != ""
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
    cells = ROWS[7].split(",")
    cells[column] = f'"{cell}"'
    path = tmp_path / "run.csv"
    path.write_text(CSV + "\n".join([*ROWS[:7], ",".join(cells), *ROWS[8:]]) + "\n")
    with pytest.raises(InputError, match="row 9, column"):
        read_experiment(path)


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
