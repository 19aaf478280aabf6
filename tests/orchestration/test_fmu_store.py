"""Where built FMUs are kept."""

from __future__ import annotations

import errno
import os
import re
import tempfile
from dataclasses import replace
from pathlib import Path
from zipfile import is_zipfile

import pytest

import warmlink as wl
from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, cache_folder, source_digest
from warmlink.fmus.packaging.python import fmu as building
from warmlink.orchestration.fmu_store import FmuStore, store


def test_a_cache_that_cannot_be_written_is_replaced_with_a_remark(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    said: list[str] = []
    found = store("python", [], said.append)
    assert found.root.parent == tmp_path
    assert found.root.stat().st_mode & 0o077 == 0
    assert len(said) == 1
    assert "cannot be written; built FMUs go to" in said[0]
    assert CACHE_VARIABLE in said[0]


def test_where_nothing_can_be_written_it_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "file"))
    with pytest.raises(InputError, match=f"cannot be written; name a folder .* {CACHE_VARIABLE}"):
        cache_folder()


def test_a_cache_named_from_where_one_stands_is_one_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # An FMU in Python goes to its own folder while it begins.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(CACHE_VARIABLE, "here")
    assert cache_folder() == tmp_path / "here"


def test_what_a_read_only_cache_lacks_is_built_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "filled" / source_digest() / "python").mkdir(parents=True)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "filled"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    built = FmuStore("python").files(["Heater"])["Heater"]
    assert is_zipfile(built)
    assert built.is_relative_to(tmp_path / "temporary")


def test_a_damaged_fmu_is_built_anew(tmp_path: Path) -> None:
    kept = FmuStore("python", tmp_path)
    kept.folder.mkdir(parents=True)
    (kept.folder / "Heater.fmu").write_bytes(b"")  # as a computer leaves it that loses its power
    assert is_zipfile(kept.files(["Heater"])["Heater"])


def test_a_full_disk_is_that_of_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(entries: object, folder: Path, progress: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(building, "build_python_fmus", full)
    place = re.escape(str(FmuStore("python", tmp_path).folder))
    with pytest.raises(
        NoRoomError, match=f"{place}: cannot be written .* another folder in {CACHE_VARIABLE}"
    ):
        FmuStore("python", tmp_path).files(["Heater"])


def test_fmus_of_ones_own_are_kept_under_what_they_are_and_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    twice = wl.Component(
        name="Twice",
        description="Doubles a temperature",
        inputs=(wl.Input("given", "K", "what is doubled"),),
        outputs=(wl.Output("doubled", "K", "twice of it"),),
        observe=lambda x, u, p, time: {"doubled": 2.0 * u.given},
    )
    files = wl.fmu_files([twice, "Heater"])
    assert {name: path.name for name, path in files.items()} == {"Twice": "Twice.fmu", "Heater": "Heater.fmu"}
    times = files["Twice"].stat().st_mtime_ns
    assert wl.fmu_files(twice) == {"Twice": files["Twice"]}
    assert files["Twice"].stat().st_mtime_ns == times
    thrice = replace(twice, observe=lambda x, u, p, time: {"doubled": 3.0 * u.given})
    described = replace(twice, description="Doubles what is given")
    assert len({wl.fmu_files(each)["Twice"] for each in (twice, thrice, described)}) == 3
    shipped_again = replace(twice, name="Heater")
    with pytest.raises(InputError, match="Heater: two components of this name"):
        wl.fmu_files(["Heater", shipped_again])
    assert wl.fmu_files(shipped_again)["Heater"] != files["Heater"]
    with pytest.raises(InputError, match="Heatr: there is no component of this name; did you mean Heater"):
        wl.fmu_files("Heatr")
