"""Recursions give what a loop gives."""

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.model.recursions import recursion


@pytest.mark.parametrize(("count", "columns", "reach"), [(1, 1, 1), (2, 3, 5), (300, 2, 3), (4000, 0, 1)])
def test_each_number_follows_from_those_before(count: int, columns: int, reach: int) -> None:
    random = np.random.default_rng(count)
    given, by_last = random.normal(size=(count, columns)), random.uniform(-0.3, 0.3, (reach, count))
    expected = given.copy()
    for k in range(count):
        for d in range(1, min(reach, k) + 1):
            expected[k] += by_last[d - 1, k - d] * expected[k - d]
    kept = given.copy()
    assert recursion(given, by_last) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert np.array_equal(given, kept)
