"""The laws that a live page shows where nobody names any."""

import pytest

from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.report.live.page import usual_laws
from warmlink.orchestration.scenarios.scenario import changed


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, ["lag", "observer"]),
        ({"compensator.gain": "2 um/W"}, ["lag"]),
        ({"link.length": "0.4 m"}, ["lag", "observer"]),
    ],
)
def test_a_law_that_lacks_a_start_value_is_not_shown_beside(
    given: dict[str, str], expected: list[str]
) -> None:
    scenario = changed(load_scenario("stop_and_go"), controller="lag", parameters=given)
    assert [law.name for law in usual_laws(scenario)] == expected
