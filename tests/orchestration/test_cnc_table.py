"""A law as a line and a table for a CNC: units, places, and how far they are off the law."""

import csv
import io
import re

import numpy as np
import pytest

import warmlink as wl
from warmlink.controllers.export.core import designed
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.products.cnc import CncTable, cnc_table, formula

CELSIUS = 273.15


@pytest.fixture(scope="module")
def table() -> CncTable:
    return cnc_table("regression", duties=["stop_and_go"])


def _rows(text: str) -> tuple[list[str], np.ndarray]:
    head, *rows = csv.reader(io.StringIO(text))
    return head, np.array([[float(each) for each in row[1:]] for row in rows])


def test_it_is_as_close_to_the_law_as_it_says(table: CncTable) -> None:
    head, rows = _rows(table.csv())
    assert head[1:] == [f"{table.thermometer} [degC]", "offset [um]", "coefficient [um/m]", "position [m]"]
    outcome = wl.run("stop_and_go", "regression")
    source = outcome.scenario.machine.fed[f"compensator.{table.thermometer}"]
    at_tool = rows[:, 1] + rows[:, 2] * (0.3170 - rows[:, 3])
    corrected = np.interp(outcome.table[source] - CELSIUS, rows[:, 0], at_tool)
    off = corrected - 1e6 * outcome.table["compensator.correction"]
    (said,) = table.errors
    assert 1e6 * said.table[1] == pytest.approx(np.abs(off).max(), rel=1e-3)
    assert 1e6 * said.table[0] == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-3)
    assert said.table[0] <= said.line[0]
    assert f"| stop_and_go | {1e6 * said.table[0]:.3g} |" in table.readme()


def test_units_change_the_numbers_and_not_the_table(table: CncTable) -> None:
    other = cnc_table("regression", duties=["stop_and_go"], unit="mm", temperature="K")
    (_, um), (head, mm) = _rows(table.csv()), _rows(other.csv())
    assert head[1].endswith("[K]")
    np.testing.assert_allclose(mm[:, 0] - um[:, 0], CELSIUS, atol=2e-3)
    np.testing.assert_allclose(1e3 * mm[:, 2], um[:, 2], rtol=1e-4)
    slope, zero = map(float, re.findall(r"\d[\d.e-]*", table.straight.partition("=")[2]))
    assert 1e6 * table.line[1] == pytest.approx(abs(slope), rel=1e-4)
    assert 1e6 * table.line[0] == pytest.approx(-slope * (abs(zero) + CELSIUS), rel=1e-3)


def test_a_regression_is_one_formula() -> None:
    law = designed(controller("regression"), {"intercept": 1e-6, "coefficients[5]": 5e-6})
    said = formula(law, "um", "degC")
    assert said is not None
    values = {"base_temperature": 30.0, "tip_temperature": 25.0}
    expected = 1.0 + 2.19687533822 * 8.0 + 5.0 * 3.0
    assert eval(said.partition("=")[2], {}, values) == pytest.approx(expected, rel=1e-5)
    assert formula(controller("lag"), "um", "degC") is None


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"unit": "kg"}, "is no unit of a length"),
        ({"temperature": "um"}, "is no unit of a temperature"),
        ({"thermometer": "tp_temperature"}, "did you mean tip_temperature"),
        ({"duties": ["nosuch"]}, "nosuch"),
    ],
)
def test_what_it_cannot_do_is_refused(given: dict[str, object], said: str) -> None:
    with pytest.raises(wl.InputError, match=said):
        cnc_table("regression", **{"duties": ["stop_and_go"], **given})  # type: ignore[arg-type]
