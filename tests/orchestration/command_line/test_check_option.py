"""`diagnose --check` shows what is understood of a file, and stops."""

import json
from contextlib import suppress
from pathlib import Path

import pytest

from warmlink.orchestration.cli import main

HEAD = "clock;v [rad/s];M;T_room;base_temperature_degC;note\n"
LINES = [
    f"22.11.2026 23:{50 + i // 6}:{10 * (i % 6):02d};3,43;2,5;22;{22 + i / 8:.3f};x\n".replace(".", ",")
    for i in range(60)
]
OPTIONS = [
    *("--map", "clock=time", "--map", "v=speed", "--map", "M=torque", "--map", "T_room=ambient_temperature"),
    *("--unit", "N.m", "--unit", "degC"),
]


@pytest.fixture
def logged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    lines = [line.replace(",", ".", 2) for line in LINES]  # the date keeps its points
    lines[20] = lines[20].replace(f"{22 + 20 / 8:.3f}".replace(".", ","), "OVERLOAD")
    Path("log.csv").write_text(HEAD + "".join(lines[:40] + lines[50:]))
    return tmp_path


def answer(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *more: str) -> str:
    monkeypatch.setattr("sys.argv", ["warmlink", "diagnose", "log.csv", "--check", *OPTIONS, *more])
    with suppress(SystemExit):
        main()
    said = capsys.readouterr()
    assert said.err == ""
    return said.out


def test_it_says_columns_units_rows_gaps_ranges_and_what_is_assumed_or_passed_over(
    logged: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said = answer(capsys, monkeypatch)
    for part in (
        "separated by semicolons, decimal comma",
        "50 rows over 9.833 min, one every 10 s, 1 gaps, the longest 110 s from 390 s on",
        "motor.torque",
        "N.m (--unit)",
        "degC (name)",
        "rad/s (header)",
        "49 of 50",
        "29.375",
        "row 22, column 'base_temperature_degC': 'OVERLOAD' is taken for a missing value",
        "no pad_temperature column: taken as off",
        "not used: note",
    ):
        assert part in said, part
    assert "v [rad/s] " in said
    assert [path.name for path in logged.iterdir()] == ["log.csv"]


def test_the_same_as_json(
    logged: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = json.loads(answer(capsys, monkeypatch, "--json"))
    (run,) = found["runs"]
    assert run["gaps"] == [{"at_s": 390.0, "lasts_s": 110.0}]
    base = run["columns"][-1]
    assert base == {
        "column": "base_temperature_degC",
        "variable": "link.base_temperature",
        "unit": "degC",
        "unit_from": "name",
        "filled": 49,
        "cells": 50,
        "least": 22.0,
        "largest": 29.375,
    }


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--scenario", "windshield_wiper"], ""),
        (["--scenario", "absent.toml"], "absent.toml: no such file"),
        (["--noise", "base_temperature_degC=0.1 K"], ""),
        (["--noise", "base_temperature=-1 K"], "not a standard deviation"),
        (["--noise", "T9=1 K"], "no variable T9"),
        (["--decimal", "komma"], "did you mean comma"),
        (["--map", "note"], 'no name; write --map "note='),
    ],
)
def test_what_else_is_known_is_taken_or_refused(
    logged: Path,
    option: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sys.argv", ["warmlink", "diagnose", "log.csv", "--check", *OPTIONS, *option])
    with suppress(SystemExit):
        main()
    err = capsys.readouterr().err
    assert said in err
    assert bool(err) == bool(said)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--time-limit", "2 min"), "--time-limit: applies only to a calibration; add --calibrate-only"),
        (("--time-limit", "0 s", "--calibrate-only"), "--time-limit: "),
        (("--time-limit", "2 K", "--calibrate-only"), "--time-limit: "),
    ],
)
def test_a_time_limit_is_one_of_a_calibration(
    logged: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.setattr("sys.argv", ["warmlink", "diagnose", "log.csv", *options])
    with pytest.raises(SystemExit) as ended:
        main()
    told = capsys.readouterr().err
    assert ended.value.code == 2
    assert said in told
    assert "Traceback" not in told
