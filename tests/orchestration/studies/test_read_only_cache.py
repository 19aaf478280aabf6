"""A study with a cache that was filled before and is read-only, as one that a whole cluster reads."""

import os
from pathlib import Path

import pytest

from warmlink.fmus.packaging import cache
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, writable_cache
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.studies.workers import FmuSet


def test_a_study_unpacks_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, access = tmp_path / "shared", os.access
    monkeypatch.setenv(CACHE_VARIABLE, str(folder))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    FmuStore("python").files(["Heater"])
    before = sorted(folder.rglob("*"))
    monkeypatch.setattr(cache.os, "access", lambda path, mode: Path(path) != folder and access(path, mode))
    fmus = FmuSet.read("python", FmuStore("python").files(["Heater"]))
    assert fmus.files()["Heater"].is_relative_to(writable_cache())
    assert not fmus.unpacked.is_relative_to(folder)
    assert sorted(folder.rglob("*")) == before
