"""The paper's tables, temperatures and times, beside what the models here give for them.

Four of our own answers stand beside the measured and the predicted number: Eq. (4) as printed, its
correction, the 1-D link and the 3-D finite elements, these two with the boundary conditions of the paper.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warmlink.controllers.analytic import law
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.drift_camera.component import COMPONENT as DRIFT_CAMERA
from warmlink.orchestration.paper.agreement import agreements
from warmlink.orchestration.paper.cases import Case, fea
from warmlink.orchestration.paper.data import load_geometry, load_materials
from warmlink.orchestration.paper.fea.drive import Drive
from warmlink.orchestration.paper.fea.mesh import Assembly, bare_link
from warmlink.orchestration.paper.fea.simulate import Fea
from warmlink.orchestration.paper.link_model import run_link
from warmlink.orchestration.paper.results import CaseResult, Refinement, Reproduction
from warmlink.orchestration.paper.rows import paper_rows
from warmlink.orchestration.paper.statements import findings, paper_statements
from warmlink.orchestration.paper.tried import consistency, try_everything
from warmlink.orchestration.system.units import ZERO_CELSIUS

#: The paper's mesh with every element divided in two each way.
FINE = Assembly(refinement=2)


def reproduce(progress: Callable[[float, str], None] | None = None) -> Reproduction:
    """Compute every number; about a minute.

    Parameters
    ----------
    progress : receives the fraction done and what is being done

    Raises
    ------
    MissingExtraError
        scikit-fem is not installed.
    """
    tell = progress or (lambda fraction, what: None)
    cases: dict[str, CaseResult] = {}
    for start, name in ((0.0, "stationary"), (0.14, "moving")):
        tell(start, f"{name} case: 1-D link and 3-D finite elements")
        cases[name] = _run_case(Case.printed(name))
    tell(0.2, "what was tried on the disagreements")
    attempts, gaps = try_everything(lambda f: tell(0.2 + 0.2 * f, "what was tried on the disagreements"))
    tell(0.45, "mesh convergence")
    refinements = _refinements()
    tell(0.7, "1-D link against 3-D finite elements")
    agreed = agreements(lambda f: tell(0.7 + 0.28 * f, "1-D link against 3-D finite elements"))
    tell(0.98, "the paper's statements")
    consistent = consistency()
    camera = Instance(DRIFT_CAMERA)
    result = Reproduction(
        rows=tuple(paper_rows(cases, attempts)),
        statements=tuple(paper_statements(cases)),
        attempts=tuple(attempts),
        pad_gaps=gaps,
        consistency=tuple(consistent),
        findings=tuple(
            findings(attempts, gaps, consistent, camera.get("pixel_size") * camera.get("centroid_noise"))
        ),
        refinements=tuple(refinements),
        agreements=tuple(agreed),
        cases=cases,
    )
    tell(1.0, "done")
    return result


def _run_case(case: Case) -> CaseResult:
    model = fea(FINE)
    history = model.run(case.drive(), case.times, case.ambient)
    link, span = load_materials().link, load_geometry().span
    depth = np.sqrt(link.diffusivity * np.maximum(history.time, 1e-9))
    return CaseResult(
        case=case,
        fea=history,
        link=run_link(case),
        body=model.body,
        displacement=model.elasticity.displacement(history.final - case.ambient),
        corrected=np.asarray(law.corrected(case.rise, depth, span, link.expansion_coefficient)),
        printed=np.asarray(law.printed(case.rise, depth, span, link.expansion_coefficient)),
    )


def _refinements() -> list[Refinement]:
    """Convergence on the assembly (8-node displacement, to afford three meshes) and on the link alone."""
    case = Case.printed("moving")
    heated = Drive(case.convection, case.ambient, heat_flow=1.7)
    runs = [
        *(("assembly", n, fea(Assembly(refinement=n)).body, case.drive(), case.times) for n in (1, 2, 3)),
        *(
            (
                "link alone, 1.7 W",
                n,
                bare_link(load_geometry(), load_materials(), n),
                heated,
                np.linspace(0.0, 3600.0, 61),
            )
            for n in (1, 2, 4)
        ),
    ]
    found = []
    for name, n, body, drive, times in runs:
        history = Fea(body, displacement_order=1).run(drive, times, case.ambient)
        tip = float(history.temperature["tip"][-1]) - ZERO_CELSIUS
        found.append(Refinement(name, n, tip, float(history.elongation[-1]) * 1e6))
    return found
