from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.trivial_fmu import build_trivial_fmu
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import FmiVersion


def _build(folder: Path, version: FmiVersion) -> Path:
    try:
        return build_trivial_fmu(folder, version)
    except InputError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def trivial2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _build(tmp_path_factory.mktemp("fmu"), "2.0")


@pytest.fixture(scope="session")
def trivial3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _build(tmp_path_factory.mktemp("fmu"), "3.0")
