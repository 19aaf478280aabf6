"""What the page of a diagnosis shows: the model to use, over times as people tell them, and its warning."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.report.diagnosis import _growing
from warmlink.orchestration.report.diagnosis_figures import _better, time_unit


@pytest.mark.parametrize(
    ("hours", "told"), [(0.1, (60.0, "min")), (5, (60.0, "min")), (20, (3600.0, "h")), (312, (86400.0, "d"))]
)
def test_a_time_is_told_in_the_unit_that_its_length_asks_for(hours: float, told: tuple[float, str]) -> None:
    assert time_unit(3600.0 * hours) == told


def predicted(value: float) -> Any:
    return SimpleNamespace(readings=(np.full((3, 2), value),))


def test_what_is_drawn_beside_the_model_as_it_stands_is_the_model_to_use() -> None:
    before, after, used = predicted(0.0), predicted(1.0), predicted(2.0)
    found: Any = SimpleNamespace(before=before, after=after, adopted=used, delivers=True, verdict="unknown")
    assert _better(found) == ("to use from now on", used)
    found.adopted = predicted(1.0)
    assert _better(found) == ("nearest causes", after), "it is that of the causes"
    found.adopted, found.delivers = before, False
    assert _better(found) == ("nearest causes", after), "nothing is delivered"
    found.after = before
    assert _better(found) is None


def test_the_warning_tells_the_errors_that_the_page_shows() -> None:
    """It compared others, and said that an error grows from 1.06 to 1.07 beside 1.07 and 1.05 on the page."""
    errors = {"before": (1.07, 1.0, 1.1), "adopted": (1.05, 1.0, 1.1)}
    reported = SimpleNamespace(rmse=lambda each, heldout: errors[each])
    held_out = (SimpleNamespace(in_noise=1.06), SimpleNamespace(in_noise=1.07))
    found: Any = SimpleNamespace(
        before="before", adopted="adopted", causes=("friction",), reported=reported, held_out=held_out
    )
    assert _growing(found) == ""
    errors["adopted"] = (1.1, 1.0, 1.2)
    assert _growing(found) == "The error on held-out rows grows from 1.07 to 1.1 times the noise."
