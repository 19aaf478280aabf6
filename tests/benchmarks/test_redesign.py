"""A heat path that was found is worth something: the law designed for the extended model is better."""

from pathlib import Path

import pytest

from benchmarks.redesign import of_chain


@pytest.mark.slow
def test_an_observer_of_the_extended_chain_removes_what_the_old_one_leaves(tmp_path: Path) -> None:
    found = of_chain(tmp_path, 0.3, 1)
    assert found.said == "named flange"
    assert abs(found.value - 0.3) < 0.005
    assert found.none > 100
    assert found.before > 3
    assert found.after < 0.1 * found.before
