"""Who made this release of warmlink and under which terms, as every FMU states it."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import metadata
from pathlib import Path

AUTHOR = "the warmlink developers"
COPYRIGHT = f"Copyright (c) 2026 {AUTHOR}"
LICENSE = "MIT"


@cache
def version() -> str:
    """Version of the installed distribution, or of the source tree that this file lies in."""
    project = Path(__file__).parents[2] / "pyproject.toml"
    if project.is_file():
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])
    return metadata.version("warmlink")
