"""Which scenarios are the arm's: those shipped, and files that say so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.text_files import read_toml

NAME = "SixAxisArm"
SYSTEM = "system"
PROGRAMS = Path(__file__).parent / "programs"


def arm_scenario_names() -> list[str]:
    """Names of the arm's scenarios that warmlink ships."""
    return sorted(path.stem for path in PROGRAMS.glob("*.toml"))


def is_arm_scenario(name: str) -> bool:
    """Whether a name, or the path of a TOML file, is of a scenario of the arm."""
    return name in arm_scenario_names() or table_of(Path(name)).get(SYSTEM) == NAME


def table_of(path: Path) -> dict[str, Any]:
    """Content of a TOML file; nothing where there is none that can be read."""
    if path.suffix != ".toml":
        return {}
    try:
        return read_toml(path)
    except InputError:  # told by whoever needs it
        return {}
