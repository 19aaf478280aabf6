"""The reproduction of the paper, computed once for all that is asserted of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from warmlink.orchestration.paper.reproduce import Reproduction


@pytest.fixture(scope="session")
def told() -> list[float]:
    """The progress that the reproduction told, filled by it."""
    return []


@pytest.fixture(scope="session")
def result(told: list[float]) -> Reproduction:
    """The reproduction; tests that use it share one process by `xdist_group("reproduction")`."""
    from warmlink.orchestration.paper.reproduce import reproduce

    return reproduce(lambda doing, share=None: told.append(share))
