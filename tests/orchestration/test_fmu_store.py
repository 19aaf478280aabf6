"""Where built FMUs are kept."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, cache_folder
from warmlink.orchestration.fmu_store import store


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
