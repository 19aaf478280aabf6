"""What every test may use: the FMUs, built once a session."""

from __future__ import annotations

import os
from pathlib import Path

# As the command does: see warmlink.orchestration.cli.main.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.packaging.python.fmu import build_python_fmus


@pytest.fixture(scope="session")
def python_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Path of every Python FMU by the component's name."""
    built = build_python_fmus(catalogue(), tmp_path_factory.mktemp("dist"))
    return {path.stem: path for path in built}
