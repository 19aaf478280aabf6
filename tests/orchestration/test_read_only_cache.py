"""A cache that was filled before and is read-only, as one that a whole cluster reads."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from warmlink.fmus.packaging import cache
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, cache_folder, kept, kept_before
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.studies.workers import FmuSet


@pytest.fixture
def shared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """What lies in it and is kept there, before nobody may write any more; temporary files lie elsewhere."""
    folder, access = tmp_path / "shared", os.access
    monkeypatch.setenv(CACHE_VARIABLE, str(folder))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    FmuStore("python").files(["Heater"])
    kept("things", "made before", lambda: b"thing")
    before = sorted(folder.rglob("*"))
    monkeypatch.setattr(cache.os, "access", lambda path, mode: Path(path) != folder and access(path, mode))
    yield folder
    assert sorted(folder.rglob("*")) == before


def test_what_it_holds_is_used_without_a_word(shared: Path) -> None:
    said: list[str] = []
    found = store("python", ["Heater"], said.append).files(["Heater"], said.append)
    assert found["Heater"].is_relative_to(shared)
    assert kept_before("things", "made before") == b"thing"
    assert said == []


def test_what_it_lacks_is_made_elsewhere(shared: Path) -> None:
    said: list[str] = []
    found = store("python", ["Heater"], said.append).files(["Heater", "HeatPath"], said.append)
    assert found["Heater"].is_relative_to(shared)
    assert found["HeatPath"].is_file()
    assert "shared: cannot be written; built FMUs go to" in said[0]


def test_a_study_unpacks_elsewhere(shared: Path) -> None:
    fmus = FmuSet.read("python", FmuStore("python").files(["Heater"]))
    assert fmus.files()["Heater"].is_relative_to(cache_folder())
    assert not fmus.unpacked.is_relative_to(shared)
