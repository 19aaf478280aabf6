from pathlib import Path

import pytest

from .ssp_text import Lab


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    """Give a maker and reader of SSPs in a folder of its own."""
    return Lab(tmp_path)
