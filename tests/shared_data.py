"""Strangers' logs and systems, where the machine has them; they are not part of the project."""

import os
from pathlib import Path

import pytest

DATA = Path(os.environ.get("WARMLINK_DATA", Path(__file__).parents[2] / "shared" / "data"))


def given(name: str) -> Path:
    """Path of a file or folder of them; the test is skipped where it is absent."""
    path = DATA / name
    if not path.exists():
        pytest.skip(f"{path} is absent: set WARMLINK_DATA to the folder with the measured runs")
    return path
