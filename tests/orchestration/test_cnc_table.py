"""A law as a line and a table for a CNC: units, places, and how far they are off the law."""

import csv
import io
import re
from pathlib import Path

import numpy as np
import pytest

import warmlink as wl
from tests.orchestration.machine.strangers import machine
from warmlink.controllers.export.core import designed
from warmlink.controllers.start_values import by_scalar
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.products.cnc import CncTable, cnc_table, formula
from warmlink.orchestration.products.cnc_axis import ROWS
from warmlink.orchestration.replay.compare import run_over
from warmlink.orchestration.replay.logs import read_logs

CELSIUS = 273.15


@pytest.fixture(scope="module")
def table() -> CncTable:
    return cnc_table("regression", duties=["stop_and_go"])


def _rows(text: str) -> tuple[list[str], np.ndarray]:
    head, *rows = csv.reader(io.StringIO(text))
    return head, np.array([[float(each) for each in row[2:-1]] for row in rows])


def test_it_is_as_close_to_the_law_as_it_says(table: CncTable) -> None:
    head, rows = _rows(table.csv())
    lengths = ["offset [um]", "coefficient [um/m]", "position [m]"]
    assert head == ["axis", "thermometer", "temperature [degC]", *lengths, "design"]
    (axis,) = table.axes
    assert {tuple(row.split(",")[:2]) for row in table.csv().splitlines()[1:]} == {("link", axis.thermometer)}
    outcome = wl.run("stop_and_go", "regression")
    source = outcome.scenario.machine.fed[f"compensator.{axis.thermometer}"]
    at_tool = rows[:, 1] + rows[:, 2] * (0.3170 - rows[:, 3])
    corrected = np.interp(outcome.table[source] - CELSIUS, rows[:, 0], at_tool)
    off = corrected - 1e6 * outcome.table["compensator.correction"]
    (said,) = axis.errors
    assert 1e6 * said.table[1] == pytest.approx(np.abs(off).max(), rel=1e-3)
    assert 1e6 * said.table[0] == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-3)
    assert said.table[0] <= said.line[0]
    assert f"| stop_and_go | {1e6 * said.table[0]:.3g} |" in table.readme()


def test_units_change_the_numbers_and_not_the_table(table: CncTable) -> None:
    other = cnc_table("regression", duties=["stop_and_go"], unit="mm", temperature="K")
    (_, um), (head, mm) = _rows(table.csv()), _rows(other.csv())
    assert head[2].endswith("[K]")
    np.testing.assert_allclose(mm[:, 0] - um[:, 0], CELSIUS, atol=2e-3)
    np.testing.assert_allclose(1e3 * mm[:, 2], um[:, 2], rtol=1e-4)
    slope, zero = map(float, re.findall(r"\d[\d.e-]*", table.straight(table.axes[0]).partition("=")[2]))
    start, steep = table.axes[0].line
    assert 1e6 * steep == pytest.approx(abs(slope), rel=1e-4)
    assert 1e6 * start == pytest.approx(-slope * (abs(zero) + CELSIUS), rel=1e-3)


def test_a_regression_is_one_formula() -> None:
    law = designed(controller("regression"), {"intercept": 1e-6, "coefficients[5]": 5e-6})
    said = formula(law, "um", "degC")
    assert said is not None
    values = {"base_temperature": 30.0, "tip_temperature": 25.0}
    expected = 1.0 + 2.19687533822 * 8.0 + 5.0 * 3.0
    assert eval(said.partition("=")[2], {}, values) == pytest.approx(expected, rel=1e-5)
    assert formula(controller("lag"), "um", "degC") is None


def test_each_link_of_a_machine_is_an_axis(tmp_path: Path) -> None:
    """A machine whose controller has another name, and more links than one, ended in a KeyError."""
    gantry = str(machine("gantry", tmp_path))
    table = cnc_table("lag", duties=[gantry])
    assert [each.name for each in table.axes] == ["x_link", "y_link"]
    lines = [each.split(",") for each in table.csv().splitlines()[1:]]
    assert [row[0] for row in lines] == ["x_link"] * ROWS + ["y_link"] * ROWS
    assert {row[-1] for row in lines} == {table.core.mark}
    outcome = wl.run(gantry, "lag")
    corrected = 0.0
    for axis in table.axes:
        kelvin = outcome.table[outcome.scenario.machine.fed[f"brain.{axis.thermometer}"]]
        corrected = corrected + np.interp(kelvin, axis.temperature, axis.growth)
    assert np.abs(corrected - outcome.table["brain.correction"]).max() <= 2.0 * table.largest
    assert "SHA-256" in table.duties[0]
    assert "## Axis y_link" in table.readme()
    assert "| `time_constant` |" in table.readme()


def test_logs_of_a_machine_need_no_model(tmp_path: Path) -> None:
    """The table of a law learnt from a log was close to it on the shipped cell, which the machine is not."""
    log = tmp_path / "log.csv"
    wl.hide(["radiation"], seed=3).to_csv(log, index=False)
    learnt = wl.design("WarmupCell", "regression", data=[log])
    learnt.write(tmp_path / "law.ssv")
    table = cnc_table("regression", tmp_path / "law.ssv", data=[log])
    (axis,) = table.axes
    assert (axis.name, axis.places) == ("1", None)
    law = designed(controller("regression"), by_scalar(learnt.values))
    inputs, outputs, _ = run_over(law, read_logs([log])[0])
    kelvin = inputs[:, law.u.index[axis.thermometer]]
    off = np.interp(kelvin, axis.temperature, axis.growth) - outputs.correction
    assert axis.errors[0].table[1] == pytest.approx(np.abs(off).max(), rel=1e-6)
    assert "log.csv (SHA-256" in table.readme()
    assert "without a model" in table.readme()
    assert "learnt from log.csv (SHA-256" in table.readme()


def test_scenarios_of_two_machines_are_refused(tmp_path: Path) -> None:
    with pytest.raises(wl.InputError, match="of another machine"):
        cnc_table("lag", duties=["stop_and_go", str(machine("gantry", tmp_path))])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"unit": "kg"}, "is no unit of a length"),
        ({"temperature": "um"}, "is no unit of a temperature"),
        ({"thermometer": "tp_temperature"}, "did you mean tip_temperature"),
        ({"duties": ["nosuch"]}, "nosuch"),
        ({"data": ["log.csv"]}, "either duty cycles or logs"),
        ({"duties": (), "data": ["nosuch.csv"]}, "nosuch.csv"),
    ],
)
def test_what_it_cannot_do_is_refused(given: dict[str, object], said: str) -> None:
    with pytest.raises(wl.InputError, match=said):
        cnc_table("regression", **{"duties": ["stop_and_go"], **given})  # type: ignore[arg-type]
