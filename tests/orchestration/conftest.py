"""What the tests of commands begin with."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small FMU that does as its parameters say."""
    from benchmarks.trivial_fmu import build_trivial_fmu  # which a copy of the house alone lacks

    try:
        return build_trivial_fmu(tmp_path_factory.mktemp("fmu"))
    except InputError as fault:
        pytest.skip(str(fault))


@pytest.fixture
def in_a_fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in an empty folder."""
    monkeypatch.chdir(tmp_path)
