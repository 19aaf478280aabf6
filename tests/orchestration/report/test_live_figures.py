"""What the page computes besides the run: the same figures and expressions as the command."""

import numpy as np
import pytest

from tests.node import node
from warmlink.orchestration.scenarios.expression import Expression
from warmlink.orchestration.scenarios.metrics import error_metrics

pytestmark = pytest.mark.platform

STEP = 2.0


def test_figures_of_an_error_are_the_commands() -> None:
    generator = np.random.default_rng(3)
    fading = 2e-5 * np.exp(-np.arange(500) / 80) * np.cos(np.arange(500) / 9)
    histories = [generator.normal(0, 1e-5, 400), fading, np.full(7, 1e-7), np.array([1e-6, 9e-6])]
    script = """
        import { errorFigures } from "${page}/figures.js";
        const result = given.map((error) => errorFigures(error, 2, 5e-6));
    """
    for found, error in zip(node(script, [list(each) for each in histories]), histories, strict=True):
        expected = error_metrics(STEP * np.arange(error.size), error, 5e-6)
        assert found["within"] == expected.time_to_tolerance_s
        shown = (found["largest"], found["rms"], found["p95"])
        assert shown == pytest.approx((expected.max_abs_um, expected.rms_um, expected.p95_abs_um), rel=1e-12)


def test_expressions_give_the_same_values_on_the_page() -> None:
    texts = [
        "link.elongation - compensator.correction",
        "-a.x ** 2 / 3 + abs(-b.y[2]) * sqrt(a.x) - 2 ** -1",
        "(a.x - b.y[2]) ** (1 / 2) ** 2",
    ]
    values = {"link.elongation": 0.75, "compensator.correction": 0.5, "a.x": 7.0, "b.y[2]": 3.0}
    script = """
        const written = given.texts.map((text) => new Function("v", `return ${text}`));
        const result = written.map((each) => each((name) => given.values[name]));
    """
    found = node(script, {"texts": [Expression(text).javascript for text in texts], "values": values})
    assert found == pytest.approx([Expression(text).value(values.__getitem__) for text in texts], rel=1e-15)
