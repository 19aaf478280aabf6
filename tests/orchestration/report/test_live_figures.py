"""What the page computes besides the run: the same figures and expressions as the command."""

from pathlib import Path

import numpy as np
import pytest

from tests.node import node
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.orchestration.closed_loop.metrics import error_metrics
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.report.live.content import columns
from warmlink.orchestration.scenarios.duties.duty import Segment, demands_at
from warmlink.orchestration.scenarios.duties.recorded import read_recorded
from warmlink.orchestration.system.units import ZERO_CELSIUS
from warmlink.orchestration.written.expression import Expression

pytestmark = pytest.mark.platform

STEP = 2.0


def test_figures_of_an_error_are_the_commands() -> None:
    generator = np.random.default_rng(3)
    fading = 2e-5 * np.exp(-np.arange(500) / 80) * np.cos(np.arange(500) / 9)
    histories = [generator.normal(0, 1e-5, 400), fading, np.full(7, 1e-7), np.array([1e-6, 9e-6])]
    script = """
        import { errorFigures } from "${page}/figures.js";
        const result = given.map((error) => errorFigures(error, 2, 5));
    """
    for found, error in zip(node(script, [list(1e6 * each) for each in histories]), histories, strict=True):
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
        const written = given.texts.map((text) => new Function("v", "i", `return ${text}`));
        const result = written.map((each) => each(given.values, 1));
    """
    steps = {name: [0.0, value] for name, value in values.items()}
    found = node(script, {"texts": [Expression(text).javascript for text in texts], "values": steps})
    assert found == pytest.approx([Expression(text).value(values.__getitem__) for text in texts], rel=1e-15)


READ = """
    import { readMeasured, measuredSegments } from "${page}/measured.js";
    const read = (text) => {
      const rows = readMeasured(text, given.columns);
      return { rows, segments: measuredSegments(rows) };
    };
    const told = (text) => { try { return read(text); } catch (fault) { return fault.message; } };
    const result = given.texts.map(told);
"""


def shown_from(name: str) -> float:
    """Zero of what the page shows of a demand, in SI units."""
    return ZERO_CELSIUS if name.endswith("_temperature") else 0.0


def test_a_measured_run_is_read_as_the_command_reads_it(tmp_path: Path) -> None:
    text = (
        "\ufefftime [min],speed [deg/s],torque [N.m],ambient_temperature [degC],pad_power [kW],"
        "elongation [um]\n"
        "1,90,2,20,,0\n\n2,90,2,,Off,1.5\n3,,,25,0.01,\n4,0,0,,,4\n6,0,0,,,5\n"
    )
    (found,) = node(READ, {"columns": columns(WARMUP_CELL.plots), "texts": [text]})
    path = tmp_path / "run.csv"
    path.write_text(text, "utf-8")
    duty = read_recorded(path)
    times = np.arange(0.0, duty.stop_time, 10.0)
    segments = [
        Segment(s["duration"], **{name: s[name] + shown_from(name) for name in DEMANDS})
        for s in found["segments"]
    ]
    for name, expected in demands_at(duty.segments, times).items():
        np.testing.assert_allclose(demands_at(segments, times)[name], expected, err_msg=name)
    assert [s.pad_mode for s in segments] == [0, 1, 0]
    assert [row.get("elongation") for row in found["rows"]] == pytest.approx([0, 1.5, None, 4, 5])


@pytest.mark.parametrize(
    ("separator", "mark", "head"),
    [
        (";", ",", "time [s];Speed [1/min];torque (Nm);ambient temperature [°C];elongation_um"),
        ("\t", ",", "time (min)\tspeed_rpm\ttorque [N.m]\tambient_temperature [degC]\telongation [mm]"),
        ("|", ".", "time [s]|speed [rad/s]|torque [mNm]|ambient_temperature [F]|elongation [um]"),
        (
            ";",
            ".",
            "sep=;\n# in hall 3\nTime_s;speed [rad/s];torque [N.m];ambient_temperature [C];elongation [um]",
        ),
    ],
)
def test_a_measured_run_is_read_however_a_logger_separates_it(
    separator: str, mark: str, head: str, tmp_path: Path
) -> None:
    rows = [
        [0, 1.5, 2.25, 20.5, 0.0],
        [60, 1.5, 2.25, 20.5, 1.5],
        [90, 0.5, 0.25, 21.5, 4.5],
        [120, 0, 0, 21, 5],
    ]
    lines = [separator.join(f"{value:.2f}".replace(".", mark) for value in row) for row in rows]
    text = "\n".join((head, *lines, ""))
    (found,) = node(READ, {"columns": columns(WARMUP_CELL.plots), "texts": [text]})
    path = tmp_path / "run.csv"
    path.write_text(text, "utf-8")
    expected = read_recorded(path).segments
    assert len(found["segments"]) == len(expected) == 2
    for shown, segment in zip(found["segments"], expected, strict=True):
        assert shown["duration"] == pytest.approx(segment.duration)
        for name in DEMANDS:
            assert shown[name] + shown_from(name) == pytest.approx(getattr(segment, name)), name


def test_what_a_measured_run_does_not_tell_is_as_the_command_takes_it(tmp_path: Path) -> None:
    text = "time [s],speed [rad/s]\n0,\n60,2\n90,2\n"
    (found,) = node(READ, {"columns": columns(WARMUP_CELL.plots), "texts": [text]})
    path = tmp_path / "run.csv"
    path.write_text(text, "utf-8")
    expected = read_recorded(path).segments
    assert len(found["segments"]) == len(expected)
    for shown, segment in zip(found["segments"], expected, strict=True):
        for name in DEMANDS:
            assert shown[name] + shown_from(name) == getattr(segment, name), name


def test_a_measured_run_is_refused_in_a_sentence() -> None:
    heads = {
        "time [s],speed\n0,1\n": "column 'speed' is not of the form 'name [unit]'; rename it",
        "time [s],sped [rad/s]\n": "column 'sped' is not known; use one of time, speed",
        "time [s],speed [m]\n": "column 'speed': this page does not know the unit 'm'; use one of rad/s",
        "time [s],time [min]\n": "column 'time' stands twice; keep one",
        "speed [rad/s]\n1\n": "no column 'time [s]'; add it",
        "time [s]\n0\n0\n": "line 3: time is missing or does not increase; give increasing times",
        "time [s],speed [rad/s]\n0\n": "line 2: 1 cells under 2 columns; mend the row",
        "time [s],speed [rad/s]\n0,fast\n": "line 2: 'fast' in column 'speed' is no number",
        "time [s]\n0\n": "1 rows under the header; give at least two times",
        "time [s],pad_power [W],pad_temperature [degC]\n0,1,30\n": "line 2: pad_temperature and pad_power",
        "\n": "is empty; give a header and at least two times",
        "time [s],constructor [name]\n": "column 'constructor' is not known; use one of time, speed",
        "time_s;speed_rad_s\n": "column 'speed': this page does not know the unit 'rad_s'; use one of rad/s",
        "time [constructor]\n": "column 'time': this page does not know the unit 'constructor'; use one of s",
        "time [s];torque [N.m]\n0;1,5\n1;2.5\n": "has numbers with commas and with points; write one decimal",
        "time [s];torque [N.m]\n0;1,500\n1;2,500\n": "'1,500' may have a decimal mark or one for thousands",
        "1,2," * 300_000: "column '1' is not of the form 'name [unit]'; rename it",
    }
    for told, expected in zip(
        node(READ, {"columns": columns(WARMUP_CELL.plots), "texts": list(heads)}), heads.values(), strict=True
    ):
        assert expected in told
