"""The flat arm in libcosim and in Ecos: the same algorithm, the same step, the same tool point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.referees import Variables, ecos, libcosim
from warmlink.orchestration.arm.chain import arm_chain, arm_values
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.files import without_dots, write_machine
from warmlink.orchestration.machine.machine import merged
from warmlink.orchestration.master.algorithms.explicit import Jacobi
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.system.write import PARAMETER_SET

from .conftest import load_program

pytestmark = pytest.mark.platform

STEPS = 120
WATCHED = (
    "kinematics.error[1]",
    "kinematics.error[3]",
    "axis1_link.elongation",
    "axis6_compensator.correction",
    "axis4_motor.shaft_temperature",
    "axis3_link.tip_temperature",
    "axis3_sensors.reading[1]",
)
TOLERANCE = np.array([1e-9, 1e-9, 1e-9, 1e-9, 1e-6, 1e-6, 1e-6])
"""m and K."""

FEEDTHROUGH = slice(0, 2)
"""Those that follow their inputs at once."""


@pytest.fixture(scope="module")
def arm(fmu_store: FmuStore) -> System:
    """Native where something compiles; the cell runs with FMUs of both kinds in these masters."""
    program = load_program("six_axis_iso_9283")
    values = merged(arm_values(), program.start_values())
    machine, law = arm_chain(), controller("lag").name
    files = fmu_store.files(set(machine.parts_with(law).values()))
    return machine.system(files, law, values)


@pytest.fixture(scope="module")
def flat(arm: System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_machine(arm, None, tmp_path_factory.mktemp("arm"))[1]


@pytest.fixture(scope="module")
def ours(arm: System) -> np.ndarray:
    result = simulate(without_dots(arm), float(STEPS), 1.0, Jacobi())
    return np.column_stack([result[name] for name in WATCHED])[1:]


def variables(arm: System) -> Variables:
    found = []
    components = without_dots(arm).components
    for name in WATCHED:
        instance, _, variable = name.partition(".")
        found.append((name, read_description(components[instance].fmu).variables[variable].value_reference))
    return found


@pytest.mark.slow
def test_libcosim_agrees(arm: System, flat: Path, ours: np.ndarray) -> None:
    theirs = libcosim(flat, STEPS, variables(arm))
    assert np.all(np.abs(theirs - ours) < TOLERANCE), np.abs(theirs - ours).max(axis=0)


def test_ecos_agrees(arm: System, flat: Path, ours: np.ndarray) -> None:
    theirs = ecos(flat, STEPS, 1.0, PARAMETER_SET, variables(arm))
    # Ecos shows outputs once the inputs of the next step are set: what feeds through is a step ahead there.
    theirs[1:, FEEDTHROUGH] = theirs[:-1, FEEDTHROUGH]
    difference = np.abs(theirs - ours)[1:]
    assert np.all(difference < TOLERANCE), difference.max(axis=0)


def test_the_run_is_no_triviality(ours: np.ndarray) -> None:
    assert np.abs(ours[-1, :2]).max() > 1e-7
    assert np.ptp(ours[:, 4]) > 0.1
    assert np.ptp(ours[:, 5]) > 1e-4
