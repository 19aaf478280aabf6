"""The arm's name, and the programs that ship."""

from __future__ import annotations

from pathlib import Path

NAME = "SixAxisArm"
PROGRAMS = Path(__file__).parent / "programs"


def program_names() -> list[str]:
    """Names of the programs, which are the arm's scenarios."""
    return sorted(path.stem for path in PROGRAMS.glob("*.toml"))
