"""What a command takes is read without typer as typer reads it."""

from __future__ import annotations

import shlex
from functools import wraps
from typing import Any

import pytest
import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.cli import command_named, main
from warmlink.orchestration.command_line.arguments import for_typer, listed, plain_values, settings_given

GIVEN = (
    "run",
    'run six_axis_shift --stop "1 h" --no-report --set "a.b=1 K" --set a.c=2 --parameters x.ssv --json',
    "run --controller=lag --statistics --no-csv --record=link.* --record controller.*",
    "compare --controllers lag,observer --with my.py:Law --jobs 3 --exact",
    "tune lag_law --trials 8 --out there",
    "diagnose a.csv b.csv --assume torque=0 --map T9= --check",
    "list interface ThermalLink",
    "check cell.ssp",
)
UNUSUAL = (
    "run --help",
    "run a b",
    "run --stop",
    "run --nothing",
    "check",
    "tune x --jobs many",
    "run --set -x",
)


@pytest.mark.parametrize("line", GIVEN)
def test_plain_arguments_are_read_as_typer_reads_them(line: str) -> None:
    name, *given = shlex.split(line)
    told: list[dict[str, Any]] = []
    app = typer.Typer()
    app.command()(for_typer(wraps(command_named(name))(lambda **values: told.append(values))))
    app(given, standalone_mode=False)
    assert plain_values(command_named(name), given) == told[0]


@pytest.mark.parametrize("line", UNUSUAL)
def test_what_is_unusual_is_left_to_typer(line: str) -> None:
    name, *given = shlex.split(line)
    assert plain_values(command_named(name), given) is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("T", '--noise T: no value; write --noise "tip_temperature=0.1 K"'),
        ("=1 K", '--noise =1 K: no name; write --noise "tip_temperature=0.1 K"'),
    ],
)
def test_a_pair_is_refused_with_an_example_of_its_own_option(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as told:
        settings_given([text], "--noise")
    assert str(told.value) == sentence


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("a.x, b.y,a.x", ["a.x", "b.y"]),
        ("a.x[1],a.A[1,2],b.y", ["a.x[1]", "a.A[1,2]", "b.y"]),
        ("a.A[1,2,3]", ["a.A[1,2,3]"]),
    ],
)
def test_commas_part_names_and_no_indices(text: str, names: list[str]) -> None:
    assert listed(text) == names


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        (
            "simulate x.ssp --isolate true",
            "--isolate true: --isolate is a flag, which takes no value; write --isolate, or leave it out",
        ),
        (
            "compare --report=false --jobs 1",
            "--report=false: --report is a flag, which takes no value; write --report or --no-report",
        ),
    ],
)
def test_a_flag_with_a_value_is_explained(
    line: str, sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["warmlink", *shlex.split(line)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert sentence in " ".join(capsys.readouterr().err.split())


def test_help_shows_flags_as_flags(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["warmlink", "simulate", "--help"])
    with pytest.raises(SystemExit):
        main()
    shown = capsys.readouterr().out
    assert "--isolate" in shown
    assert "--help" in shown
    assert "bool" not in shown
