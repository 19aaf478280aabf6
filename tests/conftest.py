"""What every test may use: the FMUs, built once a session."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.packaging.build import build_python_fmus
from warmlink.fmus.packaging.catalogue import catalogue


@pytest.fixture(scope="session")
def python_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Path of every Python FMU by the component's name."""
    built = build_python_fmus(catalogue(), tmp_path_factory.mktemp("dist"))
    return {path.stem: path for path in built}
