"""The lines that install warmlink run as they stand, in a copy of the checkout."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.metadata import distribution, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.documented import DOCS, blocks

pytestmark = [pytest.mark.slow, pytest.mark.platform, pytest.mark.timeout(900)]

ROOT = DOCS.parent
(USE,) = blocks((DOCS / "index.md").read_text("utf-8"), "sh")
CHANGE = blocks((ROOT / "CONTRIBUTING.md").read_text("utf-8"), "sh")[0]

NOT_THERE = shutil.ignore_patterns(
    ".git", ".venv", ".typing", ".*_cache", ".hypothesis", "out", "build", "dist", "*.egg-info", "__pycache__"
)


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy of the checkout, installed by one after the other."""
    folder = tmp_path_factory.mktemp("copy")
    return Path(shutil.copytree(ROOT, folder / "warmlink", ignore=NOT_THERE))


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """Folder for what is installed here and pip shall find there, so that it fetches nothing of it."""
    folder = tmp_path / "installed"
    folder.mkdir()
    return folder


def link_needed(folder: Path, name: str = "warmlink", extras: frozenset[str] = frozenset()) -> None:
    """Link into a folder what a package needs by its own declaration, and what that needs, but not it."""
    for line in requires(name) or ():
        needed = Requirement(line)
        if needed.marker is None or any(needed.marker.evaluate({"extra": each}) for each in (*extras, "")):
            found = distribution(needed.name)
            places = {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}
            new = [place for place in places if not (folder / place).exists()]
            for place in new:
                (folder / place).symlink_to(str(found.locate_file(place)))
            if new:
                link_needed(folder, needed.name, frozenset(needed.extras))


def an_index_answers(folder: Path) -> bool:
    asked = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "setuptools"]
    return subprocess.run(asked, cwd=folder, capture_output=True).returncode == 0


def done(lines: str, folder: Path, beside: str = "") -> str:
    environment = {**os.environ, "PYTHONPATH": beside, "PIP_NO_COMPILE": "1"}
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), environment["PATH"]])
    run = subprocess.run(["bash", "-euc", lines], cwd=folder, env=environment, capture_output=True, text=True)
    if run.returncode and not an_index_answers(folder):
        pytest.skip("no package index answers, from which what builds it would come")
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


def test_the_first_page_installs_and_runs(copy: Path, installed: Path) -> None:
    """Beside Python's own library there is only what warmlink says it needs."""
    link_needed(installed)
    there = (
        "cd /\nwhich warmlink\nwarmlink --version\npython -c 'import warmlink; print(warmlink.__version__)'"
    )
    told = done(USE + there, copy, str(installed))
    assert "largest error" in told
    assert str(copy / ".venv" / "bin" / "warmlink") in told
    assert USE.splitlines()[0] in blocks((ROOT / "README.md").read_text("utf-8"), "sh")[0]


def test_who_changes_it_installs_it_in_place(copy: Path, installed: Path) -> None:
    # An environment may stand on another one, whose packages are there too.
    for folder in (Path(place) for place in sys.path if Path(place).name.endswith("-packages")):
        for each in folder.iterdir():
            if "warmlink" not in each.name and not (installed / each.name).exists():
                (installed / each.name).symlink_to(each)
    found = "cd /\nimported='import warmlink.orchestration.cli as it; print(it.__file__)'\n"
    told = done(CHANGE + found + f'{copy}/.venv/bin/python -c "$imported"', copy, str(installed))
    assert told.splitlines()[-1] == str(copy / "orchestration" / "cli.py")
