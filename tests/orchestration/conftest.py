"""What the tests of commands begin with."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from warmlink.fmus.arguments import speaking_of_options
from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import OPTIONS
from warmlink.orchestration.shell import quoted


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


@pytest.fixture
def as_a_command() -> Iterator[None]:
    """Let sentences speak of options, as they do while a command runs."""
    with speaking_of_options(OPTIONS, quoted):
        yield
