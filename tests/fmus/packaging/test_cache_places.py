"""Where what is kept goes: folders that cannot be written, hold what was kept before, or are no folders."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from warmlink.fmus.packaging import cache
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, cache_folder, kept


@pytest.fixture(autouse=True)
def _temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))


def test_a_file_is_no_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file"))
    assert cache_folder().parent == tmp_path / "temporary"


def test_who_has_no_home_keeps_things_among_temporary_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in (CACHE_VARIABLE, "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", none)
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert cache_folder().parent == tmp_path / "temporary"


def test_a_filled_cache_that_is_read_only_is_read_and_what_it_lacks_goes_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    filled = tmp_path / "filled"
    monkeypatch.setenv(CACHE_VARIABLE, str(filled))
    assert kept("things", 1, lambda: b"made before") == b"made before"
    assert cache_folder() == filled
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert kept("things", 1, lambda: b"made again") == b"made before"
    assert cache_folder().parent == tmp_path / "temporary"
    assert kept("things", 2, lambda: b"lacking") == b"lacking"
    assert len([*cache_folder().glob("things/*.kept")]) == 1


@pytest.mark.skipif(os.name == "nt", reason="tells no time of the last change")
def test_a_change_that_keeps_size_and_time_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As where packages are unpacked with the same times for all their files."""
    for room in ("fmus", "controllers", "orchestration"):
        (tmp_path / room).mkdir()
    file = tmp_path / "fmus" / "equations.py"
    monkeypatch.setattr(cache, "ROOMS", tmp_path)
    found = []
    for text in ("gain = 1.0", "gain = 2.0"):
        file.write_text(text)
        os.utime(file, (1e9, 1e9))
        found.append(cache.source_state.__wrapped__())
    assert found[0] != found[1]
