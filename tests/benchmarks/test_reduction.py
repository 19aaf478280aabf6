"""A few random runs of the benchmark: bounds hold, and would not for a model that is worse than stated."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("gmsh", reason="gmsh is not installed: pip install 'warmlink[cad]'")
pytest.importorskip("pymor", reason="pyMOR is not installed: pip install 'warmlink[cad]'")

from benchmarks.reduction import compared, example_part, random_run
from warmlink.orchestration.reduction.part import Part

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def part() -> Part:
    return example_part(size=0.025, order=30)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_stated_bounds_hold(part: Part, seed: int) -> None:
    kept = compared(part, random_run(part, [seed], 100))
    assert kept.held
    assert np.all(kept.errors > 0)
    assert np.all(kept.bounds < 300 * kept.errors)


def test_a_model_that_is_worse_than_stated_is_found(part: Part) -> None:
    stiffer = replace(part, model=replace(part.model, conduction=1.3 * part.model.conduction))
    assert not compared(stiffer, random_run(part, [1], 100)).held
