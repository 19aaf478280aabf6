"""A folder for one input, and folders around it that have to stay empty."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from warmlink.fmus.packaging.cache import CACHE_VARIABLE, wanted_cache_folder

TARGET = "target"
AROUND = ("folder", "home", "temporary")


@contextmanager
def nest() -> Iterator[Path]:
    """Make this process live in a new folder: its folder, its home and its temporary files lie in there."""
    keep = {name: os.environ.get(name) for name in ("HOME", "TMPDIR", CACHE_VARIABLE)}
    old, folder = Path.cwd(), Path(tempfile.mkdtemp(prefix="warmlink-fuzz-"))
    for name in AROUND:
        (folder / name).mkdir()
    os.environ[CACHE_VARIABLE] = str(wanted_cache_folder())
    os.environ["HOME"], os.environ["TMPDIR"] = str(folder / "home"), str(folder / "temporary")
    tempfile.tempdir = None
    os.chdir(folder / "folder")
    try:
        yield folder
    finally:
        os.chdir(old)
        for name, value in keep.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        tempfile.tempdir = None
        shutil.rmtree(folder, ignore_errors=True)


def emptied(folder: Path) -> Path:
    """Give the folder for the next input, empty."""
    shutil.rmtree(folder / TARGET, ignore_errors=True)
    (folder / TARGET).mkdir()
    return folder / TARGET


def strays(folder: Path) -> list[str]:
    """Give what was written outside the folder for the input, and remove it."""
    found = [path for name in AROUND for path in (folder / name).iterdir()]
    found += [path for path in folder.iterdir() if path.name not in (TARGET, *AROUND)]
    for path in found:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()
    return [str(path.relative_to(folder)) for path in found]
