"""A few random runs of the benchmark: bounds hold, and would not for a model that is worse than stated."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("gmsh", reason="gmsh is not installed: pip install 'warmlink[cad]'")
pytest.importorskip("pymor", reason="pyMOR is not installed: pip install 'warmlink[cad]'")

from benchmarks.reduction import COLD, Run, compared, random_run
from warmlink.orchestration.reduction.elements import Use
from warmlink.orchestration.reduction.order import range_of
from warmlink.orchestration.reduction.part import Part, reduce_part
from warmlink.orchestration.reduction.solid import HEAT_FACE, TOOL_POINT, gmsh_session, ribbed_link

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Part:
    """The example on one coarse mesh; of a STEP file, two coarser ones would be made to tell its error."""
    path = tmp_path_factory.mktemp("part") / "link.step"
    ribbed_link(path)
    with gmsh_session(path) as gmsh:
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 40.0)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path.with_suffix(".msh")))
    use, within = Use([HEAT_FACE], TOOL_POINT), range_of("aluminium_6061")
    return reduce_part(path.with_suffix(".msh"), use, within, unit="mm", order=30)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_stated_bounds_hold(part: Part, seed: int) -> None:
    kept = compared(part, random_run(part, [seed], 100))
    assert kept.held
    assert np.all(kept.errors > 0)
    assert np.all(kept.bounds < 300 * kept.errors)


def test_the_bounds_hold_where_the_speed_changes_of_a_link_that_is_warm(part: Part) -> None:
    lever = float(np.linalg.norm(part.elements.heat.reach)) / 2
    parameters = {
        "conductivity": part.within.conductivity[0],
        "density": part.within.material["density"],
        "expansion_coefficient": part.within.material["expansion_coefficient"],
        "convection_still": 3.0,
        "convection_per_speed": 55.0 / (4.0 * lever),
        "reference_temperature": COLD,
    }
    rest = {"ambient_temperature": COLD, "tip_sink_temperature": COLD}
    warm = rest | {"heat_flow": 10.0, "speed": 0.0}
    cooled = rest | {"heat_flow": 10.0, "speed": 4.0}
    assert compared(part, Run(parameters, ((600, warm), (60, cooled)))).held


def test_a_model_that_is_worse_than_stated_is_found(part: Part) -> None:
    stiffer = replace(part, model=replace(part.model, conduction=1.3 * part.model.conduction))
    assert not compared(stiffer, random_run(part, [1], 100)).held
