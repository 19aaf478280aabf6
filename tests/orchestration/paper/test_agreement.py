"""The 1-D link against the 3-D finite elements: alike where given the same, and why not elsewhere."""

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install 'warmlink[fea]'")

from warmlink.orchestration.finite_elements.transient import Fea
from warmlink.orchestration.paper.mesh import bare_link
from warmlink.orchestration.paper.reproduce import Reproduction
from warmlink.orchestration.paper.tried import AMBIENT, DUTY_CYCLES, Agreement, duty_drive

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("reproduction")]

RUNS = ("stationary", "moving", *DUTY_CYCLES)
HELD, GIVEN = ("stationary", "moving"), tuple(DUTY_CYCLES)


@pytest.fixture(scope="module")
def found(result: Reproduction) -> dict[tuple[str, str], Agreement]:
    return {(a.run, a.body): a for a in result.agreements}


def test_every_run_is_compared_with_every_body(found: dict[tuple[str, str], Agreement]) -> None:
    assert {run for run, _ in found} == set(RUNS)
    assert len(found) == 4 * len(RUNS)


@pytest.mark.parametrize("run", RUNS)
def test_link_alone_agrees_within_1_percent_and_a_fifth_of_a_kelvin(found, run: str) -> None:
    a = found[run, "link alone"]
    assert abs(a.elongation) < 1.0
    assert max(abs(a.base), abs(a.tip)) < 0.2
    # Under a given heat flow nothing jumps, and the two agree far better.
    assert run in HELD or abs(a.elongation) < 0.05
    assert run in HELD or max(abs(a.base), abs(a.tip)) < 0.01


@pytest.mark.parametrize("run", GIVEN)
def test_what_the_shaft_adds_under_a_given_heat_flow_is_the_heat_that_it_stores(found, run: str) -> None:
    shaft, storeless = found[run, "with shaft"], found[run, "with a shaft that stores no heat"]
    assert 5.0 < shaft.elongation < 10.0
    assert 0.9 < shaft.base < 1.2
    assert abs(storeless.elongation) < 1.0
    assert max(abs(storeless.base), abs(storeless.tip)) < 0.2


@pytest.mark.parametrize("run", RUNS)
def test_diode_adds_less_than_one_percent_and_a_third_of_a_kelvin(found, run: str) -> None:
    shaft, diode = found[run, "with shaft"], found[run, "with shaft and diode"]
    assert abs(diode.elongation - shaft.elongation) < 1.0
    assert abs(diode.tip - shaft.tip) < 0.31
    assert abs(diode.base - shaft.base) < 0.05


def test_finite_elements_meet_the_independent_figures_of_the_cell() -> None:
    """100 % duty from cold: 14.07, 49.95, 75.77 um by other finite elements and fine finite volumes."""
    drive, link = duty_drive(DUTY_CYCLES["continuous"])
    history = Fea(bare_link(2), 1).run(drive, link.time, AMBIENT)
    ours = np.interp([600.0, 1800.0, 3600.0], history.time, history.elongation) * 1e6
    np.testing.assert_allclose(ours, [14.07, 49.95, 75.77], rtol=1e-3)
