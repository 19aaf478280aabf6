"""Native FMUs for tests, compiled as users' are, each once for all workers."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import sleep

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import Compiler, compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import FmiVersion, native_fmu_files

BuildNative = Callable[[str, FmiVersion], Path]


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder that all workers of a session share."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "native"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def c_compiler() -> Compiler:
    if shutil.which("cc") is None and "CC" not in os.environ:
        pytest.skip("no C compiler on this machine")
    (compiler,) = compilers(platforms_named(None))
    return compiler


@pytest.fixture(scope="session")
def native_fmu(shared_folder: Path, c_compiler: Compiler) -> BuildNative:
    """Function of component's name and FMI version that gives the FMU's path."""
    entries = {entry.component.name: entry for entry in catalogue()}

    def build(name: str, version: FmiVersion) -> Path:
        path = shared_folder / f"fmi{version[0]}" / f"{name}.fmu"
        with _alone(shared_folder / f"{name}{version}.lock"):
            if not path.is_file():
                write_archive(path, native_fmu_files(entries[name], version, [c_compiler]))
        return path

    return build


@pytest.fixture(scope="session")
def sanitized_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder for objects with sanitizers, which the tests of one worker share."""
    return tmp_path_factory.mktemp("sanitized")


@contextmanager
def _alone(lock: Path) -> Iterator[None]:
    """Held by one worker at a time."""
    while True:
        try:
            lock.mkdir()
            break
        except FileExistsError:
            sleep(0.05)
    try:
        yield
    finally:
        lock.rmdir()
