"""Quantities as people and programs give them."""

from __future__ import annotations

import numpy as np
import pytest

from warmlink.orchestration.written.quantities import quantity


@pytest.mark.parametrize("number", [np.float64(60.0), np.float32(60.0), np.int64(60), 60, "60 s", "1 min"])
def test_a_number_of_numpy_is_a_number(number: str | float) -> None:
    assert quantity(number, "s") == 60.0
