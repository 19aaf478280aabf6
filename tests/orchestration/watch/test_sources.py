"""The same log through every source is the same rows, cell for cell once they are read."""

from __future__ import annotations

import io
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.watch.conftest import ROWS, lines_of, read
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.sources.lines import LinesSource
from warmlink.orchestration.watch.sources.mapping import read_mapping
from warmlink.orchestration.watch.sources.opening import opened
from warmlink.orchestration.watch.sources.rows import RowReader


def test_a_file(log: Path, expected: list[str]) -> None:
    assert read(LinesSource(log, follow=False)) == expected


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_file_with_decimal_commas(
    separator: str, table: np.ndarray, expected: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "cell.csv"
    headers, *rows = lines_of(table[:ROWS])
    text = [
        headers.replace(",", separator),
        *(each.replace(",", separator).replace(".", ",") for each in rows),
    ]
    path.write_text("# a logger's note\n" + "\r\n".join(text) + "\r\n", "utf-8-sig")
    assert read(LinesSource(path, follow=False)) == expected


def test_standard_input(log: Path, expected: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    with log.open("rb") as stream:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(stream))
        assert read(LinesSource(None, follow=True)) == expected


def test_a_file_that_grows_by_pieces_of_lines_and_is_rotated(
    table: np.ndarray, expected: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "cell.csv"
    headers, *rows = (f"{each}\n" for each in lines_of(table[:ROWS]))
    path.write_text(headers)

    def write() -> None:
        with path.open("a") as stream:
            for piece in ("".join(rows[:10]), rows[10][:7], rows[10][7:], rows[11]):
                stream.write(piece)
                stream.flush()
                time.sleep(0.05)
        time.sleep(0.3)
        path.rename(tmp_path / "cell.csv.1")
        path.write_text(headers + "".join(rows[12:25]))
        time.sleep(0.5)
        path.write_text(headers)  # emptied in place, as copytruncate does
        time.sleep(0.5)
        with path.open("a") as stream:
            stream.write("".join(rows[25:]))

    writer = threading.Thread(target=write)
    writer.start()
    source = LinesSource(path, follow=True)
    assert read(source) == expected
    writer.join()
    assert any("rotated" in each for each in source.told)


def test_a_file_goes_on_where_it_was_left(log: Path, expected: list[str]) -> None:
    first = LinesSource(log, follow=False)
    begun = read(first, 15)
    second = LinesSource(log, follow=False, begin=first.place())
    assert [*begun, *read(second, ROWS - 15)] == expected


def test_a_file_that_was_rotated_while_nobody_read_is_read_from_its_beginning(
    log: Path, expected: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "cell.csv"
    path.write_bytes(log.read_bytes())
    first = LinesSource(path, follow=False)
    read(first, 15)
    path.rename(tmp_path / "cell.csv.1")
    path.write_bytes(log.read_bytes())
    second = LinesSource(path, follow=False, begin=first.place())
    assert read(second) == expected
    assert any("rotated meanwhile" in each for each in second.told)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("absent.csv", "no such file"),
        ("http://cell/log", "is no source"),
        ("mqtt://cell", "names no host or no topic"),
        ("mqtt://me:secret@cell/topic", "a password in the address"),
        ("opc.tcp://cell:4840", "nothing says which nodes"),
    ],
)
def test_what_is_no_source_is_refused(name: str, told: str) -> None:
    with pytest.raises(InputError, match=told) as fault:
        opened(name, follow=False)
    assert "secret" not in str(fault.value)


def test_a_mapping_without_columns_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mapping.toml"
    path.write_text("[columns]\n")
    with pytest.raises(InputError, match=r"no \[columns\]"):
        opened("mqtt://cell/topic", follow=True, mapping=path)


def test_the_mapping_of_the_page_is_read(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "watch.md").read_text("utf-8")
    path = tmp_path / "mapping.toml"
    path.write_text(page.partition("```toml\n")[2].partition("```")[0])
    columns = read_mapping(path)
    assert columns["shaft_temperature [degC]"] == "joint.temperatures.shaft"
    reader = RowReader("page", list(columns), rig_of("WarmupCell"), ReadOptions())
    assert len(reader.inputs) == 3
