"""A function that goes in a later release works, and says so to whoever calls it."""

from __future__ import annotations

import pytest

from warmlink.orchestration.deprecation import deprecated


def test_it_works_and_warns_its_caller() -> None:
    @deprecated("wl.old", "wl.new", "0.3.0")
    def old(a: int, b: int = 2) -> int:
        """As it was."""
        return a + b

    with pytest.warns(
        DeprecationWarning, match=r"^wl\.old will be removed in 0\.3\.0; use wl\.new$"
    ) as warned:
        assert old(1, b=4) == 5
    assert warned[0].filename == __file__
    assert old.__doc__ == "As it was."
