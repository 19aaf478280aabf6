"""The warm-up cell in libcosim and in Ecos: the same algorithm, the same step, the same elongation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.referees import Variables, ecos, libcosim
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import PARAMETER_SET, write_ssp

STEPS = 600
WATCHED = (
    "link.elongation",
    "compensator.correction",
    "camera.measured_drift",
    "motor.shaft_temperature",
    "sensors.reading[5]",
)
TOLERANCE = np.array([1e-9, 1e-9, 1e-9, 1e-6, 1e-6])
"""m and K."""


@pytest.fixture(scope="module", params=FMU_KINDS)
def cell(request: pytest.FixtureRequest) -> System:
    """Stop and go, so that speeds change on the way, with a controller in the loop."""
    law = controller("lag")
    files = FmuStore(request.param).files(WARMUP_CELL.parts_with(law.name).values())
    duty = load_scenario("stop_and_go").duty.component_parameters
    duty |= {"duration[1]": 200.0, "duration[2]": 150.0}
    return WARMUP_CELL.system(files, law.name, {"duty": duty})


@pytest.fixture(scope="module")
def ssp(cell: System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cell") / "WarmupCell.ssp"
    write_ssp(cell, path)
    return path


@pytest.fixture(scope="module")
def ours(cell: System) -> np.ndarray:
    result = simulate(cell, float(STEPS), 1.0, Jacobi())
    return np.column_stack([result[name] for name in WATCHED])[1:]


def variables(cell: System) -> Variables:
    found = []
    for name in WATCHED:
        instance, _, variable = name.partition(".")
        info = read_description(cell.components[instance].fmu)
        found.append((name, info.variables[variable].value_reference))
    return found


@pytest.mark.platform
def test_libcosim_agrees(cell: System, ssp: Path, ours: np.ndarray) -> None:
    theirs = libcosim(ssp, STEPS, variables(cell))
    assert np.all(np.abs(theirs - ours) < TOLERANCE), np.abs(theirs - ours).max(axis=0)


@pytest.mark.platform
def test_ecos_agrees(cell: System, ssp: Path, ours: np.ndarray) -> None:
    theirs = ecos(ssp, STEPS, 1.0, PARAMETER_SET, variables(cell))
    assert np.all(np.abs(theirs - ours) < TOLERANCE), np.abs(theirs - ours).max(axis=0)


def test_the_run_is_no_triviality(ours: np.ndarray) -> None:
    assert ours[-1, 0] > 5e-6
    assert np.ptp(ours[:, 2]) > 1e-6
