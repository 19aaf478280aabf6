"""Who made this release of warmlink and under which terms, as every FMU states it."""

import os
import tomllib
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

AUTHOR = "the warmlink developers"
COPYRIGHT = f"Copyright (c) 2026 {AUTHOR}"
LICENSE = "MIT"
DATE = datetime(2026, 11, 22, tzinfo=UTC)
"""Of the release."""


@cache
def version() -> str:
    """Version of the installed distribution, or of the source tree that this file lies in."""
    project = Path(__file__).parents[2] / "pyproject.toml"
    if project.is_file():
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])
    from importlib import metadata  # takes 7 ms to import, which most commands do without

    return metadata.version("warmlink")


def generated() -> datetime:
    """Time that files state as that of their making, so that equal sources give equal files.

    `SOURCE_DATE_EPOCH` in seconds since 1970 (reproducible-builds.org); without it, the date of the release.
    """
    with suppress(KeyError, ValueError, OverflowError, OSError):
        return datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC)
    return DATE


def license_text(distribution: str = "warmlink") -> str:
    """Text of a distribution's licence, as it is installed; ours also from the source tree."""
    source = Path(__file__).parents[2] / "LICENSE"
    if distribution == "warmlink" and source.is_file():
        return source.read_text(encoding="utf-8")
    from importlib import metadata

    texts = (file for file in metadata.files(distribution) or [] if file.name.startswith("LICENSE"))
    return next((file.read_text("utf-8") for file in texts), LICENSE)
