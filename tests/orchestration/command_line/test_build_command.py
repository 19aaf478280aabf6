"""`warmlink build`: what is named is built, what is wrong is said, and where its folder takes nothing."""

from __future__ import annotations

import errno
import os
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from warmlink.orchestration.cli import main
from warmlink.orchestration.fmu_store import BuildProgress
from warmlink.orchestration.products.build import build


def failing(number: int) -> Callable[..., NoReturn]:
    def fail(*arguments: object, **named: object) -> NoReturn:
        raise OSError(number, os.strerror(number))

    return fail


@pytest.mark.parametrize("kind", ["python", "native"])
@pytest.mark.parametrize(
    ("owner", "name", "number", "reason"),
    [
        (Path, "mkdir", errno.EROFS, "Read-only file system"),
        (zipfile.ZipFile, "__init__", errno.EACCES, "Permission denied"),
        (zipfile.ZipFile, "writestr", errno.ENOSPC, "No space left on device"),
    ],
)
def test_what_cannot_be_written_is_said_in_one_sentence(
    kind: str,
    owner: object,
    name: str,
    number: int,
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["warmlink", "build", "--fmus", kind])
    with monkeypatch.context() as patch:
        patch.setattr(owner, name, failing(number))
        with pytest.raises(SystemExit) as stop:
            main()
    out, err = capsys.readouterr()
    assert stop.value.code == 2
    assert (out, err) == ("", f"warmlink: dist: cannot be written ({reason}); choose another --out\n")
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def built(*arguments: str) -> list[str]:
    """Paths that `warmlink build` wrote, of all kinds."""
    build(arguments, "out", fmus="python")
    return sorted(path.relative_to("out").as_posix() for path in Path("out").rglob("*") if path.is_file())


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["HeatPath"], ["python/HeatPath.fmu"]),
        (["lag", "Heater"], ["python/Heater.fmu", "python/LagCompensator.fmu"]),
        (
            ["BenchRod"],
            ["BenchRod.ssp", *(f"python/{n}.fmu" for n in ("Heater", "TemperatureSensors", "ThermalLink"))],
        ),
    ],
)
def test_what_is_named_is_built_and_nothing_else(
    names: list[str], expected: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert built(*names) == expected


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["ThermolLink"], "ThermolLink: no such component, controller or system; did you mean ThermalLink?"),
        (["--fmi", "1"], "--fmi 1: no such version; choose 3 or 2"),
        (
            ["ThermalLink", "--scenario", "x.toml"],
            "ThermalLink: --scenario builds its own system alone; give names or a scenario",
        ),
    ],
)
def test_what_cannot_be_built_is_said_before_anything_is_written(
    arguments: list[str],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["warmlink", "build", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    assert (stop.value.code, capsys.readouterr().err) == (2, f"warmlink: {told}\n")
    assert not [*tmp_path.iterdir()]


def test_one_version_is_built_where_one_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("there is no C compiler here")
    monkeypatch.chdir(tmp_path)
    paths = build(["HeatPath"], fmus="native", fmi=3)
    assert paths == [Path("dist/native/fmi3/HeatPath.fmu")]


def test_progress_says_what_is_made_and_how_many_are_left() -> None:
    told: list[tuple[float, str]] = []
    at_work = BuildProgress(lambda share, note="": told.append((share, note)), 3)
    at_work.begun("HeatPath")
    at_work.begun("Heater")
    at_work.done("HeatPath")
    at_work.done("Heater")
    assert told == [
        (0.0, "3 left: HeatPath"),
        (0.0, "3 left: HeatPath, Heater"),
        (pytest.approx(1 / 3), "2 left: Heater"),
        (pytest.approx(2 / 3), "1 left"),
    ]
