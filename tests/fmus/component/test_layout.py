"""Named variables in one flat vector."""

import numpy as np
import pytest

from warmlink.fmus.component import Layout, State


@pytest.mark.parametrize("name", ["_mean", "lambda", "count"])
def test_any_name_of_a_variable_may_be_read(name: str) -> None:
    layout = Layout([State(name, "K"), State("held", "K", size=2)])
    read = layout.read(np.array([1.0, 2.0, 3.0]))
    assert getattr(read, name) == 1.0
    assert read.held.tolist() == [2.0, 3.0]
    assert getattr(layout.record({name: 4.0, "held": 0.0}), name) == 4.0
