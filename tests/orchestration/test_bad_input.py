"""Whatever is given wrongly ends in one clear sentence and exit code 2, with nothing left behind."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from tests.command import refused

SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
 version="1.0" name="lonely">
<ssd:System name="lonely"><ssd:Elements>
<ssd:Component name="link" type="application/x-fmu-sharedlibrary" source="resources/Absent.fmu"/>
</ssd:Elements></ssd:System></ssd:SystemStructureDescription>"""


@pytest.fixture(autouse=True)
def _in_a_fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.ssp").write_bytes(b"PK\x03\x04 this is no archive")
    Path("broken.fmu").write_bytes(b"not a zip either")
    Path("empty.toml").write_text("title = 'nothing to do'")
    Path("wrong.toml").write_text("title = ")
    with zipfile.ZipFile("lonely.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", SSD)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "absent.toml"], "absent.toml: no such file"),
        (["run", "windscreen"], "windscreen: no such scenario; choose"),
        (["run", "empty.toml"], "stop_time is missing"),
        (["run", "wrong.toml"], "not readable as TOML"),
        (["diagnose", "wrong.toml", "run.csv"], "an experiment file cannot be combined with other files"),
        (["diagnose", "absent.csv", "also.csv"], "absent.csv: no such file"),
        (["run", "--controller", "magic"], "magic: no such controller; choose"),
        (["run", "--fmus", "wasm"], "--fmus wasm: no such kind; choose native or python"),
        (["run", "--master", "magic"], "magic"),
        (["run", "--set", "link.lenght=1 m"], "did you mean length"),
        (["run", "--set", "arm.length=1 m"], "there is no component arm"),
        (["run", "--set", "link.length"], "no value"),
        (["run", "--set", "=2"], "no name"),
        (["run", "--set", "foo=2"], "foo: names no component; choose duty, motor, link, sensors, camera or"),
        (["run", "--set", "length=2 m"], "length: names no component; did you mean link.length?"),
        (["run", "windsheld_wiper"], "no such scenario; did you mean windshield_wiper?"),
        (["run", "--controller", "Lagg"], "no such controller; did you mean lag?"),
        (["run", "--stop", "1e20 s"], "1e+20 s is more than a year"),
        (["run", "--step", "1e-9 s"], "a run keeps at most 1000000 in memory"),
        (["run", 300 * "a"], "aaa...: no such scenario"),
        (["run", f"{300 * 'a'}.toml"], "aaa...: no such file"),
        (["run", "six_axis_shift", "--step", "1e-3 s"], "2.88e+07 communication points"),
        (["run", "--set", "link.length=3 kg"], "kg does not convert to m"),
        (["run", "--set", "link.length=3 furlnogs"], "not a known unit"),
        (["run", "--set", "link.length=nan"], "not a finite number"),
        (
            ["run", "--set", "link.width=-20 mm"],
            "link.width: -0.02 m is not positive; give a value above 0 m",
        ),
        (["run", "--set", "link.tip_position=50 cm"], "link.tip_position: 0.5 m lies beyond the link's end"),
        (["run", "--step", "7 s"], "7 s"),
        (["run", "--step", "0 s"], "--step: 0 s is not positive"),
        (["run", "--step", "1 m"], "m does not convert to s"),
        (["run", "--stop", "-1 h"], "--stop: -1 h is not positive"),
        (["simulate", "absent.ssp"], "absent.ssp"),
        (["simulate", "broken.ssp"], "broken.ssp"),
        (["simulate", "lonely.ssp"], "Absent.fmu"),
        (["simulate", "."], ".: is a folder; give the path of an .fmu or .ssp file"),
        (["live", "."], ".: is a folder"),
        (["run", "."], ".: is a folder; choose "),
        (["tune", "."], ".: is a folder; choose lag_law"),
        (["design", "."], ".: is a folder"),
        (["diagnose", "."], ".: is a folder; give the path of a file of measurements"),
        (["reduce", "."], ".: is a folder; give a STEP file or a mesh"),
        (["check", "absent.fmu"], "absent.fmu: no such file"),
        (["reduce", "absent.step"], "absent.step: no such file; give a STEP file or a mesh"),
        (["check", "broken.ssp"], "broken.ssp"),
        (["build", "--fmus", "wasm"], "--fmus wasm: no such kind"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_refused_in_one_sentence(
    arguments: list[str],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if arguments[0] == "run" and "--fmus" not in arguments:
        arguments = [*arguments, "--fmus", "python"]
    assert sentence in refused(arguments, capsys, monkeypatch)


def test_a_folder_that_cannot_be_written(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("taken").write_text("a file where the folder should be")
    arguments = ["run", "--fmus", "python", "--stop", "10 s", "--no-report", "--out", "taken/here"]
    assert "cannot be written" in refused(arguments, capsys, monkeypatch)
