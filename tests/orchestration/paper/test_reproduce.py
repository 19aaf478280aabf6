"""Every number that the reproduction prints, with its tolerance, and the page that shows them."""

import io
import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install 'warmlink[fea]'")

from rich.console import Console

from benchmarks.optics import Camera, drift_noise
from tests import closed_forms
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.paper.cases import PaperCase, fea, steady_time
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS, PAPER
from warmlink.orchestration.paper.presentation import readable, terminal, write_report
from warmlink.orchestration.paper.reproduce import Reproduction
from warmlink.orchestration.paper.tried import implied_by_temperatures

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("reproduction")]

NUMBER = float | None
# place: measured, predicted, Eq. (4) printed, corrected, 1-D link, 3-D FEA. The first two are the paper's.
ROWS: dict[str, tuple[NUMBER, ...]] = {
    "stationary: elongation after 1 h": (34.3, 33.2, 57.03, 80.67, 73.75, 72.9),
    "moving: elongation after 1 h": (45.2, 46.8, 81.47, 115.24, 91.81, 90.7),
    "stationary: steady elongation after": (2250.0, None, None, None, 808.0, 807.0),
    "moving: link above the shaft": (36.6, 36.0, None, 42.0, 42.0, 41.7),
    "moving: link above the diode": (28.2, 27.4, None, 35.58, 32.05, 31.89),
    "moving: steady tip after": (None, 1800.0, None, None, 1349.0, 1345.0),
}
# case, attempt: base and tip [degC], elongation [um], steady [s]
ATTEMPTS = {
    ("stationary", "as described"): (35.91, 30.95, 73.36, 786),
    ("stationary", "radiation"): (35.83, 27.86, 58.57, 518),
    ("stationary", "joint resistance"): (33.22, 29.16, 58.75, 1456),
    ("stationary", "heater lag"): (35.91, 30.95, 73.36, 1446),
    ("stationary", "cooled link only"): (35.91, 31.09, 73.81, 797),
    ("stationary", "effective length"): (35.91, 30.95, 70.85, 778),
    ("stationary", "radiation and joint resistance"): (32.72, 26.49, 44.91, 846),
    ("stationary", "all of these together"): (32.72, 26.49, 43.39, 1490),
    ("moving", "as described"): (41.80, 31.97, 91.53, 613),
    ("moving", "radiation"): (41.70, 28.83, 75.89, 430),
    ("moving", "joint resistance"): (36.60, 29.27, 66.79, 1124),
    ("moving", "heater lag"): (41.80, 31.97, 91.53, 1283),
    ("moving", "cooled link only"): (41.80, 32.18, 92.17, 623),
    ("moving", "effective length"): (41.80, 31.97, 88.44, 608),
    ("moving", "radiation and joint resistance"): (36.60, 27.00, 55.55, 707),
    ("moving", "all of these together"): (36.60, 27.00, 53.69, 1355),
}
DIGIT = {"um": 0.05, "degC": 0.05, "s": 3.0}


def test_progress_is_told_from_beginning_to_end(result: Reproduction, told: list[float]) -> None:
    assert told[0] == 0.0
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_every_row_has_the_numbers_of_the_paper_and_ours(result: Reproduction) -> None:
    assert {f"{r.case}: {r.quantity}" for r in result.rows} == set(ROWS)
    for row in result.rows:
        shown = (row.measured, row.predicted, row.printed_eq4, row.corrected, row.link, row.fea)
        for ours, expected in zip(shown, ROWS[f"{row.case}: {row.quantity}"], strict=True):
            assert (ours is None) == (expected is None), row
            assert expected is None or ours == pytest.approx(expected, abs=DIGIT[row.unit]), row


def test_differences_are_of_the_finite_elements_against_the_paper(result: Reproduction) -> None:
    first, *_, last = result.rows
    assert first.difference == pytest.approx(72.9 - 34.3, abs=0.05)
    assert first.difference_percent == pytest.approx(100 * (72.9 / 34.3 - 1), abs=0.2)
    assert last.difference == pytest.approx(1345 - 1800, abs=3)


@pytest.mark.parametrize(("name", "row"), [("stationary", 0), ("moving", 1)])
def test_link_and_finite_elements_lie_where_the_fin_formula_does(
    result: Reproduction, name: str, row: int
) -> None:
    """A fin with the shaft's temperature at its root, the overhang beyond the diode included."""
    g, link, case = GEOMETRY, MATERIALS["link"], PaperCase.printed(name)
    section, perimeter = g.width * g.thickness, 2 * (g.width + g.thickness)
    m = closed_forms.fin_parameter(case.convection, perimeter, link.conductivity, section)
    fin = closed_forms.fin_elongation(
        g.span, g.length - g.shaft_centre, case.rise, m, link.expansion_coefficient,
        case.convection / (link.conductivity * m),
    )  # fmt: skip
    assert result.rows[row].link == pytest.approx(fin * 1e6, rel=2e-3)
    # The shaft's rim, not its centre, is at that temperature; holes and diode are there too.
    assert result.rows[row].fea == pytest.approx(fin * 1e6, rel=0.02)


def test_every_attempt_has_its_numbers(result: Reproduction) -> None:
    assert {(a.case, a.name) for a in result.attempts} == set(ATTEMPTS)
    for a in result.attempts:
        base, tip, elongation, steady = ATTEMPTS[a.case, a.name]
        assert (a.base, a.tip) == pytest.approx((base, tip), abs=0.02), a
        assert a.elongation == pytest.approx(elongation, abs=0.05), a
        assert a.steady == pytest.approx(steady, abs=3), a
        described = ATTEMPTS[a.case, "as described"][2]
        measured = PAPER[a.case]["elongation_measured"].value
        assert a.effect == pytest.approx(elongation - described, abs=0.1)
        assert a.left == pytest.approx(elongation - measured, abs=0.05)


def test_joint_resistance_meets_the_measured_base_by_the_gaps_found(result: Reproduction) -> None:
    assert result.pad_gaps["without"] == pytest.approx(6.08e-3, abs=0.02e-3)
    assert result.pad_gaps["with"] == pytest.approx(3.72e-3, abs=0.02e-3)
    measured = PAPER["moving"]["base_measured"].value
    joined = [a for a in result.attempts if a.case == "moving" and "joint" in a.name]
    assert [a.base for a in joined] == pytest.approx([measured] * 2, abs=0.01)


def test_temperatures_imply_the_elongation_of_the_profile_between_them(result: Reproduction) -> None:
    implied = {c.name: c.implied for c in result.consistency}
    assert list(implied.values()) == pytest.approx([60.6, 46.4, 55.3], abs=0.05)
    g, m = GEOMETRY, 5.0
    base, tip = closed_forms.fin_rise([0.0, g.span], g.span, 14.0, m)
    direct = closed_forms.fin_elongation(g.span, g.span, 14.0, m, 23.6e-6)
    assert implied_by_temperatures(base, tip) == pytest.approx(direct)


def test_statements_hold_and_fail_with_their_figures(result: Reproduction) -> None:
    figures = {
        s.claim: (s.holds, [float(n) for n in re.findall(r"-?\d+\.?\d*", s.figures)])
        for s in result.statements
    }
    expected = [
        (True, [6, 1345]), (True, [22.06, 22]), (True, [41.4, 31.9]), (True, [93.9, 6.0, 14.3]),
        (False, [96.2, 73.7, 1]), (False, [3.2, 3.5]),
    ]  # fmt: skip
    for (holds, numbers), (should, wanted) in zip(figures.values(), expected, strict=True):
        assert holds == should
        assert numbers == pytest.approx(wanted, abs=3 if wanted[-1] > 1000 else 0.1)


def test_findings_and_notes_print_the_computed_numbers(result: Reproduction) -> None:
    text = " ".join((*result.findings, *(r.note for r in result.rows)))
    numbers = {float(n) for n in re.findall(r"\d+\.\d+", text)}
    for a in result.attempts:
        if a.name == "all of these together":
            assert round(a.left, 1) in numbers
            assert round(a.left * 1e-6 / (23.6e-6 * 0.1), 1) in numbers
    assert {round(c.implied, 1) for c in result.consistency} <= numbers
    assert {round(1e3 * gap, 1) for gap in result.pad_gaps.values()} <= numbers
    assert round(drift_noise().total * Camera.printed().cell_width * 1e6, 2) in numbers


def test_mesh_converges_with_order_2_on_the_link_and_more_slowly_on_the_assembly(
    result: Reproduction,
) -> None:
    alone = np.array([(r.tip, r.elongation) for r in result.refinements if r.body.startswith("link")])
    change = np.abs(np.diff(alone, axis=0))
    assert np.log2(change[0] / change[1]) == pytest.approx(2.0, abs=0.25)
    whole = np.array([r.elongation for r in result.refinements if r.body == "assembly"])
    assert whole == pytest.approx([91.62, 90.73, 90.28], abs=0.05)
    # Falling by less each time: 0.9 from 1 to 2, 0.5 from 2 to 3 um.
    assert np.all(np.diff(np.abs(np.diff(whole))) < 0)


@pytest.fixture(scope="module")
def printed(result: Reproduction) -> str:
    console = Console(width=80, file=io.StringIO())
    console.print(terminal(result))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_terminal_of_80_columns_shows_every_row_on_a_line_of_its_own(printed: str) -> None:
    lines = [" ".join(line.split()) for line in printed.splitlines()]
    assert max(map(len, printed.splitlines())) <= 80
    assert "…" not in printed
    assert "elongation after 1 h [µm] 34.3 33.2 57.0 80.7 73.7 72.9 +38.6 +113" in lines
    assert "link above the shaft [°C] 36.6 36.0 – 42.0 42.0 41.7 +5.1 K –" in lines
    # Case by case, in the order of the table.
    table = [line for line in lines if re.match(r"[a-z0-9 ]+\[(µm|s|°C)\]", line)]
    assert len(table) == len(ROWS)


def test_terminal_shows_every_attempt_on_a_line_of_its_own(result: Reproduction, printed: str) -> None:
    lines = [" ".join(line.split()) for line in printed.splitlines()]
    for a in result.attempts:
        beginning = f"{a.name} {a.base:.1f} {a.tip:.1f} {a.elongation:.1f} "
        assert sum(line.startswith(beginning) for line in lines) >= 1, beginning
    assert "radiation and joint resistance 36.6 27.0 55.6 -36.0 +10.4 707" in lines


def test_terminal_shows_every_sentence(result: Reproduction, printed: str) -> None:
    words = "".join(printed.split())
    sentences = [r.note for r in result.rows] + [s.claim for s in result.statements] + list(result.findings)
    for sentence in sentences:
        assert "".join(readable(sentence).split()) in words
    assert "doesnothold:" in words


def test_page_opens_from_disk_without_a_network(result: Reproduction, tmp_path: Path) -> None:
    file = tmp_path / "report.html"
    write_report(result, file)
    html = file.read_text("utf-8")
    assert "mesh3d" in plots(file)
    for words in (
        "Figure 3",
        "Figure 5",
        "Figure 6",
        "Figure 7",
        "Figure 8",
        "Table I",
        "radiation and joint",
    ):
        assert words in html
    # Of 39.1 and 46.3 um, 28.5 and 36.0 are accounted for.
    assert "account for 73 % and 78 % of the difference" in html
    assert list(tmp_path.iterdir()) == [file]


def test_page_that_cannot_be_written_is_refused_and_leaves_nothing(
    result: Reproduction, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_report(result, tmp_path / "absent" / "report.html")
    assert list(tmp_path.iterdir()) == []


def test_steady_time_is_three_time_constants_of_an_exponential() -> None:
    time = np.linspace(0, 5000, 5001)
    assert steady_time(time, 1 - np.exp(-time / 250)) == pytest.approx(750, abs=0.1)


def test_a_model_is_made_once() -> None:
    from warmlink.orchestration.paper.mesh import RodMesh

    assert fea(RodMesh()) is fea(RodMesh())
