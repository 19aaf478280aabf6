"""What every test may use: the FMUs, built once a session; and which tests one worker runs in which order."""

from __future__ import annotations

import gc
import os
from pathlib import Path

# As the command does: see warmlink.orchestration.threads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from xdist.scheduler import LoadGroupScheduling

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.packaging.python.fmu import build_python_fmus


@pytest.fixture(scope="session")
def python_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Path of every Python FMU by the component's name."""
    built = build_python_fmus(catalogue(), tmp_path_factory.mktemp("dist") / "python")
    return {path.stem: path for path in built}


class OneWorkerPerFile(LoadGroupScheduling):
    """One worker runs all tests of a file or of an `xdist_group`.

    What they share, fixtures and whatever is built once a process, is then made once.
    """

    def _split_scope(self, nodeid: str) -> str:
        group: str = super()._split_scope(nodeid)
        return group.partition("::")[0]


def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> OneWorkerPerFile:
    return OneWorkerPerFile(config, log)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the slow tests too, as .ci/run does")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with the files that have slow tests, so that no worker waits long for the other at the end."""
    slow = [item for item in items if item.get_closest_marker("slow")]
    paths = {item.path for item in slow}
    items.sort(key=lambda item: item.path not in paths)
    for item in slow if not config.getoption("slow") else ():
        item.add_marker(pytest.mark.skip(reason="slow: --slow runs it too"))


def pytest_configure() -> None:
    """Let garbage be sought seldom, which took a tenth of the time: thousands of tests are gone through."""
    gc.set_threshold(20_000)


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()
