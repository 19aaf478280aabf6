"""A reduced link in other people's tools: in the cell in libcosim and Ecos, and alone in FMPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.fmus.reduced_bar import bar_link, bar_model
from tests.referees import ecos, libcosim
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component.reference import Phase, integrate
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import compilers, platforms_named
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.reduced_link.equations import STORED, stored
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.replacement import Replacements
from warmlink.orchestration.system.write import PARAMETER_SET, write_ssp

ORDER = 13
STEPS = 600
WATCHED = ("link.elongation", "link.tip_temperature", "link.displacement[1]", "compensator.correction")
TOLERANCE = np.array([1e-9, 1e-6, 1e-9, 1e-9])
"""m and K."""


@pytest.fixture(scope="module")
def link(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = compilers(platforms_named(None))
    if not found:
        pytest.skip("there is no C compiler")
    fmu = tmp_path_factory.mktemp("fmu") / "BarLink.fmu"
    entry = Entry(bar_link(ORDER), "warmlink.fmus.reduced_link.component")
    write_archive(fmu, {**native_fmu_files(entry, "2.0", found), STORED: stored(bar_model(ORDER))})
    return fmu


@pytest.fixture(scope="module")
def cell(link: Path) -> System:
    """Stop and go, so that speeds change on the way, with a controller in the loop."""
    law = controller("lag")
    files = FmuStore("native").files(WARMUP_CELL.parts_with(law.name).values())
    duty = load_scenario("stop_and_go").duty.component_parameters
    duty |= {"duration[1]": 200.0, "duration[2]": 150.0}
    return Replacements({"link": link}, {}).in_system(WARMUP_CELL.system(files, law.name, {"duty": duty}))


@pytest.mark.platform
def test_other_masters_agree(cell: System, tmp_path: Path) -> None:
    result = simulate(cell, float(STEPS), 1.0, Jacobi())
    ours = np.column_stack([result[name] for name in WATCHED])[1:]
    assert np.ptp(ours, axis=0).min() > 1e-7, "all of them move"
    write_ssp(cell, tmp_path / "Cell.ssp")
    variables = []
    for name in WATCHED:
        instance, _, variable = name.partition(".")
        known = read_description(cell.components[instance].fmu).variables
        variables.append((name, known[variable].value_reference))
    others = (
        libcosim(tmp_path / "Cell.ssp", STEPS, variables),
        ecos(tmp_path / "Cell.ssp", STEPS, 1.0, PARAMETER_SET, variables),
    )
    for theirs in others:
        assert (np.abs(theirs - ours).max(axis=0) <= TOLERANCE).all()


def test_fmpy_gives_what_the_equations_give_and_all_checks_pass(link: Path) -> None:
    from fmpy import simulate_fmu

    assert not [each for each in check_fmu(link) if each.verdict == "fail"]
    heated = {"heat_flow": 5.0}
    theirs = simulate_fmu(
        str(link), stop_time=600.0, output_interval=1.0, start_values=heated, output=["elongation"]
    )
    exact = integrate(bar_link(ORDER), [Phase(600.0, heated)], ["elongation"]).values["elongation"]
    assert theirs["elongation"][-1] == pytest.approx(exact[-1], rel=1e-4)
