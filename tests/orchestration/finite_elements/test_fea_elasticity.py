"""Thermo-elasticity against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install 'warmlink[fea]'")

from tests import closed_forms
from tests.bars import bar
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.finite_elements.body import Body, Support, ThermoElasticity
from warmlink.orchestration.paper.data import MATERIALS
from warmlink.orchestration.paper.mesh import paper_assembly

SIZE = (0.3302, 0.0254, 0.00635)
ALPHA = MATERIALS["link"].expansion_coefficient


def at(points: Array, point: tuple[float, float, float] | Array) -> int:
    distance = np.linalg.norm(points - np.asarray(point)[:, None], axis=0)
    assert distance.min() < 1e-9
    return int(distance.argmin())


def on_points(body: Body) -> Body:
    """The bar held against rigid motion only, so that it may deform freely."""
    length, width, _ = body.mesh.p.max(axis=1)
    origin, along, across = np.zeros((3, 1)), np.array([[length], [0], [0]]), np.array([[0], [width], [0]])
    return replace(body, supports=(Support(origin), Support(along, (1, 2)), Support(across, (2,))))


@pytest.mark.parametrize("order", [1, 2])
def test_uniform_rise_expands_a_free_bar_by_alpha_dt_in_every_direction(order: int) -> None:
    body = on_points(bar(SIZE, (23, 4, 1), MATERIALS["link"]))
    displacement = ThermoElasticity(body, order).displacement(np.full(body.mesh.nvertices, 14.0))
    np.testing.assert_allclose(displacement, ALPHA * 14.0 * body.mesh.p, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_clamped_bar_grows_by_alpha_l_dt_but_for_its_clamped_end(order: int) -> None:
    model = ThermoElasticity(bar(SIZE, (23, 4, 1), MATERIALS["link"]), order)
    elongation = model.elongation_row @ np.full(model.body.mesh.nvertices, 14.0)
    # By Saint-Venant the clamp is felt over about one width, a thirteenth of the length.
    assert elongation == pytest.approx(ALPHA * SIZE[0] * 14.0, rel=0.02)


def bent(body: Body, order: int) -> tuple[Array, Array]:
    """Displacement of a free bar by a temperature linear through its thickness, and the closed form of it."""
    gradient = 1000.0
    x, y, z = body.mesh.p
    z = z - z.max() / 2
    computed = ThermoElasticity(on_points(body), order).displacement(gradient * z)
    # The exact field of a free body: strain alpha T in every direction, stress nowhere.
    exact = ALPHA * gradient * np.stack([x * z, y * z, (z**2 - x**2 - y**2) / 2])
    return computed, exact - rigid_motion(exact, body.mesh.p)


def rigid_motion(field: Array, p: Array) -> Array:
    """The rigid motion that the supports of `on_points` take out of a displacement field."""
    length, width, _ = p.max(axis=1)
    u_0 = field[:, at(p, (0, 0, 0))]
    u_x, u_y = field[:, at(p, (length, 0, 0))] - u_0, field[:, at(p, (0, width, 0))] - u_0
    turn = np.array([u_y[2] / width, -u_x[2] / length, u_x[1] / length])
    return np.asarray(u_0[:, None] + np.cross(turn, p.T).T)


def test_20_node_elements_bend_exactly_with_one_through_the_thickness() -> None:
    computed, exact = bent(bar(SIZE, (23, 4, 1), MATERIALS["link"]), order=2)
    np.testing.assert_allclose(computed, exact, atol=1e-8 * np.abs(exact).max())


def test_deflection_of_the_free_link_is_that_of_the_bar_formula() -> None:
    """Between its ends, both at zero deflection, constant curvature bows by kappa x (L - x) / 2."""
    body = bar(SIZE, (23, 4, 1), MATERIALS["link"])
    computed, _ = bent(body, order=2)
    middle = computed[2, at(body.mesh.p, (SIZE[0] * 12 / 23, 0, 0))]
    bow = closed_forms.thermal_bending(SIZE[0], 1000.0, ALPHA) * (12 / 23) * (11 / 23)
    assert middle == pytest.approx(bow, rel=1e-6)


def bending_error(size: tuple[float, float, float], elements: tuple[int, int, int]) -> float:
    computed, exact = bent(bar(size, elements, MATERIALS["link"]), order=1)
    return float(np.abs(computed - exact).max() / np.abs(exact).max())


def test_8_node_elements_on_the_mesh_of_the_paper_lock_in_bending() -> None:
    assert bending_error(SIZE, (23, 4, 1)) > 0.4


def test_8_node_elements_recover_from_locking_with_order_2() -> None:
    size = (0.0635, 0.0127, 0.00635)
    errors = [bending_error(size, (5 * n, n, n)) for n in (2, 4, 8)]
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.25)


def test_adjoint_elongation_equals_that_of_the_displacement_field() -> None:
    body = paper_assembly()
    model = ThermoElasticity(body)
    rise = 14.0 * np.exp(-3 * body.mesh.p[0]) + 100 * body.mesh.p[2]
    displacement = model.displacement(rise)
    expected = (body.target - body.origin) @ displacement[0]
    assert model.elongation_row @ rise == pytest.approx(expected, rel=1e-9)


def test_order_of_the_displacement_hardly_changes_the_elongation_of_the_assembly() -> None:
    body = paper_assembly()
    rise = 14.0 * np.exp(-3 * body.mesh.p[0])
    both = [ThermoElasticity(body, order).elongation_row @ rise for order in (1, 2)]
    assert both[0] == pytest.approx(both[1], rel=2e-3)
