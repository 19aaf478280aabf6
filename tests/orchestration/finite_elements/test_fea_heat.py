"""The finite-element heat equation against closed forms, its balance, and its orders of convergence."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import simpson

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install 'warmlink[fea]'")

from tests import closed_forms
from tests.bars import bar
from warmlink.fmus.errors import InputError
from warmlink.fmus.thermal_link.equations import STEFAN_BOLTZMANN
from warmlink.orchestration.finite_elements.body import HeatModel
from warmlink.orchestration.finite_elements.transient import (
    Fea,
    HeatDrive,
    HeatStepper,
    graded,
    held_course,
    within,
)
from warmlink.orchestration.paper.data import GEOMETRY, MATERIALS
from warmlink.orchestration.paper.mesh import RodMesh, paper_assembly

LINK = MATERIALS["link"]
SIZE = (0.3302, 0.0254, 0.00635)
AMBIENT = 295.15


def order(errors: list[float], ratio: float = 2.0) -> float:
    """Observed order between the last two errors."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(ratio))


def test_insulated_bar_with_held_end_converges_to_the_series_with_order_2() -> None:
    """Space and time refined together: trilinear elements and the stepping are both of order 2."""
    errors = []
    for n in (8, 16, 32):
        body = bar(SIZE, (n, 1, 1), LINK)
        drive = HeatDrive(0.0, AMBIENT, temperature=AMBIENT + 14.0)
        grid = 120.0 / n * np.arange(5 * n + 1)
        history = Fea(body, 1).run(drive, grid, AMBIENT)
        exact = closed_forms.bar_fourier_rise(SIZE[0], 600.0, SIZE[0], 14.0, LINK.diffusivity)
        errors.append(abs(history.temperature["tip"][-1] - AMBIENT - float(exact)))
    assert errors[-1] < 0.01
    assert order(errors) == pytest.approx(2.0, abs=0.25)


def test_steady_fin_converges_with_order_2() -> None:
    h, perimeter, section = 7.75, 2 * (SIZE[1] + SIZE[2]), SIZE[1] * SIZE[2]
    m = closed_forms.fin_parameter(h, perimeter, LINK.conductivity, section)
    exact = float(closed_forms.fin_rise(SIZE[0], SIZE[0], 14.0, m, h / (LINK.conductivity * m)))
    errors = []
    for n in (4, 8, 16):
        # Beyond n = 8 the fin formula's own neglect of the section's temperature differences shows.
        body = bar(SIZE, (n, 1, 1), LINK)
        drive = HeatDrive(h, AMBIENT, temperature=AMBIENT + 14.0)
        history = Fea(body, 1).run(drive, 500.0 * np.arange(40 + 1), AMBIENT)
        errors.append(abs(history.temperature["tip"][-1] - AMBIENT - exact))
    assert errors[-1] < 0.005
    assert order(errors[:2]) == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize("radiation", [False, True])
def test_time_stepping_is_of_order_2(radiation: bool) -> None:
    """Smoothly varying ambient, heat flow and coefficient, on a fixed mesh, against small steps."""
    body = bar(SIZE, (6, 1, 1), LINK)
    drive = HeatDrive(
        convection=lambda t: 8 + 4 * np.sin(t / 300),
        ambient=lambda t: AMBIENT + 3 * np.sin(t / 500),
        heat_flow=lambda t: 5 * np.sin(t / 200) ** 2,
        radiation=radiation,
    )
    model = HeatModel(body)

    def final(steps: int) -> np.ndarray:
        stepper, field = HeatStepper(model, drive), np.full(model.size, AMBIENT)
        for i in range(steps):
            field = stepper.step(field, i * 1200.0 / steps, 1200.0 / steps)
        return field

    reference = final(320)
    errors = [float(np.abs(final(n) - reference).max()) for n in (20, 40, 80)]
    assert order(errors) == pytest.approx(2.0, abs=0.15)


def test_stepping_damps_what_it_cannot_resolve() -> None:
    """L-stable: one step of 1e7 s lands on the steady state from anywhere."""
    model = HeatModel(bar(SIZE, (6, 2, 1), LINK))
    start = AMBIENT + np.random.default_rng(1).normal(0, 50, model.size)
    stepper = HeatStepper(model, HeatDrive(5.0, AMBIENT, heat_flow=0.0))
    end = stepper.step(start, 0.0, 1e7)
    assert np.abs(end - AMBIENT).max() < 0.02


@pytest.mark.parametrize("radiation", [False, True])
def test_energy_balance_with_quantities_integrated_apart_from_the_solver(radiation: bool) -> None:
    """Heat given (known) = heat stored (from the final field) + heat lost (Simpson over the times)."""
    body = paper_assembly()
    model = HeatModel(body)
    drive = HeatDrive(7.75, AMBIENT, heat_flow=3.0, radiation=radiation)
    stepper = HeatStepper(model, drive)
    field, lost = np.full(model.size, AMBIENT), [0.0]
    for i in range(360):
        field = stepper.step(field, i * 10.0, 10.0)
        surface = model.points @ field
        flux = 7.75 * (surface - AMBIENT)
        if radiation:
            flux = flux + model.emissivity * STEFAN_BOLTZMANN * (surface**4 - AMBIENT**4)
        lost.append(float(model.area @ flux))
    at_points = np.asarray(model.basis.interpolate(field - AMBIENT))
    stored = 0.0
    for name, cells in body.mesh.subdomains.items():
        m = body.materials[name]
        stored += m.density * m.specific_heat * float((at_points * model.basis.dx)[cells].sum())
    given = 3.0 * 3600.0
    assert stored + simpson(lost, dx=10.0) == pytest.approx(given, rel=1e-3)
    assert stored > 0.1 * given


def test_heat_through_a_held_end_equals_the_fin_formula() -> None:
    """What the steady surface loses is the flow of the fin, a quantity the solver does not know."""
    h, section, perimeter = 7.75, SIZE[1] * SIZE[2], 2 * (SIZE[1] + SIZE[2])
    m = closed_forms.fin_parameter(h, perimeter, LINK.conductivity, section)
    exact = closed_forms.fin_heat_flow(
        SIZE[0], 14.0, m, LINK.conductivity, section, h / (LINK.conductivity * m)
    )
    model = Fea(bar(SIZE, (32, 1, 1), LINK), 1)
    drive = HeatDrive(h, AMBIENT, temperature=AMBIENT + 14.0)
    steady = model.fields(drive, 500.0 * np.arange(40 + 1), AMBIENT)[-1]
    assert h * (model.heat.load @ (steady - AMBIENT)) == pytest.approx(exact, rel=2e-3)


def test_radiation_balances_a_black_plate_at_the_stefan_boltzmann_temperature() -> None:
    black = replace(LINK, emissivity=1.0, conductivity=1e5)
    body = bar((0.02, 0.02, 0.002), (2, 2, 1), black)
    model = HeatModel(body)
    drive = HeatDrive(0.0, AMBIENT, heat_flow=0.5, radiation=True)
    history = Fea(body, 1).run(drive, 100.0 * np.arange(200 + 1), AMBIENT)
    expected = (0.5 / (STEFAN_BOLTZMANN * model.area.sum()) + AMBIENT**4) ** 0.25
    assert history.temperature["tip"][-1] == pytest.approx(expected, abs=0.01)


def test_assembly_has_the_counts_of_the_paper() -> None:
    mesh = paper_assembly().mesh
    # Each of the two holes takes the place of 2 x 2 elements of 23 x 4 x 1.
    assert len(mesh.subdomains["link"]) == 23 * 4 * 1 - 2 * 4
    assert len(mesh.subdomains["shaft"]) == 7 * 8
    assert len(mesh.subdomains["diode"]) == 10 * 12


def test_assembly_surface_and_volume_converge_to_the_exact_ones() -> None:
    g = GEOMETRY
    holes = np.pi / 4 * np.array([g.shaft_diameter**2, g.diode_diameter**2])
    exact = (g.length * g.width - holes.sum()) * g.thickness
    for n, slack in ((1, 5e-3), (2, 1.3e-3), (4, 4e-4)):
        model = HeatModel(paper_assembly(RodMesh(refinement=n, only_link_cooled=True)))
        volume = model.basis.dx[model.body.mesh.subdomains["link"]].sum()
        faces = 2 * (g.length * g.width - holes.sum()) + 2 * g.thickness * (g.length + g.width)
        assert volume == pytest.approx(exact, rel=slack)
        # Only the two faces and the rim are free: the holes are filled without a crack.
        assert model.area.sum() == pytest.approx(faces, rel=slack)


def test_held_series_jumps_only_where_a_step_begins() -> None:
    series = held_course((0.0, 100.0), (1.0, 2.0))
    assert within(series, 90.0, 10.0, 1.0) == 1.0
    assert within(series, 100.0, 10.0, 0.0) == 2.0


def test_graded_grid_meets_every_breakpoint() -> None:
    grid = graded([0.0, 37.0, 1000.0, 3601.0])
    for point in (37.0, 1000.0, 3601.0):
        assert np.abs(grid - point).min() < 1e-9


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: HeatDrive(1.0, 1.0), "either temperature or heat_flow"),
        (lambda: Fea(bar(SIZE, (1, 1, 1), LINK), 3).elasticity, "order: 3"),
    ],
)
def test_wrong_use_is_refused_in_one_sentence(wrong, words: str) -> None:
    with pytest.raises(InputError, match=words):
        wrong()


def test_absent_library_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "skfem", None)
    with pytest.raises(InputError, match=r"warmlink\[fea\]"):
        bar(SIZE, (1, 1, 1), LINK)
