"""Parts whose answers are known: a straight bar beside ThermalLink, bending, a uniform rise."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gmsh", reason="gmsh is not installed: pip install 'warmlink[cad]'")
pytest.importorskip("pymor", reason="pyMOR is not installed: pip install 'warmlink[cad]'")

from tests.orchestration.reduction.parts import LENGTH, THICKNESS, WIDTH, bar
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.thermal_link.component import thermal_link
from warmlink.orchestration.reduction.elements import Elements, Use
from warmlink.orchestration.reduction.order import range_of
from warmlink.orchestration.reduction.part import Part, reduce_part
from warmlink.orchestration.reduction.solid import read_solid

TOOL_POINT = f"{LENGTH}, {WIDTH / 2}, {THICKNESS / 2} mm"
COOLED = "; ".join(f"#{i}" for i in range(1, 7))


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Part:
    path = bar(tmp_path_factory.mktemp("part") / "bar.step")
    use = Use(["0, 10, 3 mm"], TOOL_POINT, cooled=[COOLED])
    within = range_of("aluminium_6061", displacement=50e-9, temperature=20e-3)
    return reduce_part(path, use, within, size=0.016)


def test_a_straight_bar_grows_as_thermal_link(part: Part) -> None:
    whole = {"base_position": 0.0, "tip_position": 0.3302}
    phases = [Phase(600.0, {"heat_flow": 8.0, "speed": 2.0}), Phase(3000.0, {"heat_flow": 3.0, "speed": 0.0})]
    slender = integrate(
        thermal_link(40), phases, ["elongation"], every=600.0, tolerance=1e-6, parameters=whole
    )
    names = ["elongation", *(f"displacement[{i}]" for i in (1, 2, 3)), "rotation[2]"]
    solid = integrate(reduced_link("Bar", part.model), phases, names, every=600.0, tolerance=1e-6).values
    expected = slender.values["elongation"]
    assert expected.min() == 0
    assert expected.max() > 1e-4
    assert np.all(np.abs(solid["elongation"] - expected) <= 0.002 * expected)
    assert solid["displacement[1]"] == pytest.approx(solid["elongation"], rel=1e-6)
    assert np.abs(solid["displacement[2]"]).max() < 1e-8
    assert np.abs(solid["rotation[2]"]).max() * LENGTH / 1e3 < 1e-3 * expected.max()


def test_a_bar_that_is_warmer_on_one_side_bends_by_the_closed_form(part: Part) -> None:
    """Temperature g z: no stress, rotation -g L about y, and u_z = -g L^2 / 2 up to the faces' own shape."""
    length, height = LENGTH / 1e3, part.elements.places[2] - THICKNESS / 2e3
    found = part.elements.heat.outputs[:6] @ height
    assert found[4] == pytest.approx(length, rel=0.005)
    assert found[2] == pytest.approx(-(length**2) / 2, rel=0.005)
    assert np.abs(found[[0, 1, 3, 5]]).max() < 1e-5
    assert part.elements.heat.outputs[:6] @ np.ones_like(height) == pytest.approx(
        [*part.elements.heat.reach, 0, 0, 0], abs=1e-8
    )


def test_the_order_meets_the_tolerance_and_the_search_needed_several(part: Part) -> None:
    assert part.error <= 1 < part.search[0].error
    assert part.model.order == part.search[-1].basis.shape[1] > 6
    assert part.model.area.sum() == pytest.approx(
        sum(face.area for face in part.elements.solid.faces), rel=1e-9
    )
    assert 0 < part.mesh.share < 0.002


def test_an_initial_rise_at_the_sensors_lies_along_the_part(part: Part) -> None:
    linear = part.model.initial @ np.array([0.0, 5.0, 10.0, 10 / 6, 20 / 6, 5.0, 40 / 6, 50 / 6])
    assert part.model.outputs[7] @ linear == pytest.approx(5.0, abs=0.05)
    assert part.model.outputs[0] @ linear == pytest.approx(5.0 * LENGTH / 1e3, rel=0.005)


@pytest.mark.parametrize("suffix", [".msh", ".inp"])
def test_a_mesh_is_the_part_that_a_step_file_is(part: Part, suffix: str, tmp_path: Path) -> None:
    named = {"groups": ((1, "flange"), (2, "seat"))} if suffix == ".msh" else {}
    path = bar(tmp_path / f"bar{suffix}", mesh=16.0, **named)
    solid = read_solid(path, "mm")
    assert len(solid.faces) == 6
    heated = ["flange"] if named else ["0, 10, 3 mm"]
    heat = Elements(solid, Use(heated, TOOL_POINT)).heat
    assert heat.mass.sum() == pytest.approx(LENGTH * WIDTH * THICKNESS * 1e-9)
    assert heat.outputs[:6] @ np.ones(heat.integrals.size) == pytest.approx([0.3302, 0, 0, 0, 0, 0], abs=1e-8)
