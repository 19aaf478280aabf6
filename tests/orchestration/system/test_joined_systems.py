"""Cell and arm as one FMU each: exact, and like the co-simulation but for its coupling error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.referees import ecos, libcosim
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component.reference import integrate
from warmlink.fmus.packaging.native.fmu import FmiVersion, build_native_fmus
from warmlink.fmus.plant import demand, plant
from warmlink.orchestration.arm.program import Program, arm
from warmlink.orchestration.catalogue import controller, shipped
from warmlink.orchestration.check.cases import CASES
from warmlink.orchestration.check.fmu import check_fmu
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel
from warmlink.orchestration.master.error_budget import coupling_error
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.assemble import component
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, System
from warmlink.orchestration.system.write import PARAMETER_SET, write_ssp

HOME = "warmlink.orchestration.machine.machine"
LAW = controller("lag").name
DUTY = {"duration[1]": 1200.0, "duration[2]": 600.0, "segment_speed[2]": 0.0, "segment_torque[2]": 0.5}
PHASES = [demand(1200.0, 3.43, 2.5), demand(600.0, 0.0, 0.5)]
STOP = 1800.0
WATCHED = ("link.elongation", "compensator.correction", "sensors.reading[5]", "camera.measured_drift")


def alone(fmu: Path) -> System:
    return System(
        "Alone", {"whole": component("whole", fmu)}, (), default_experiment=DefaultExperiment(0.0, STOP, 1.0)
    )


@pytest.fixture(scope="module")
def cells(tmp_path_factory: pytest.TempPathFactory) -> dict[FmiVersion, Path]:
    joined = WARMUP_CELL.joined(controller("lag"), {"duty": DUTY})
    folder = tmp_path_factory.mktemp("joined")
    versions: tuple[FmiVersion, ...] = ("2.0", "3.0")
    return {v: build_native_fmus([Entry(joined, HOME)], folder / v, v)[0] for v in versions}


@pytest.fixture(scope="module")
def run(cells: dict[FmiVersion, Path]) -> dict[str, np.ndarray]:
    result = simulate(alone(cells["2.0"]), STOP, 1.0)
    return {name: result[f"whole.{name}"] for name in WATCHED}


@pytest.mark.slow
def test_the_joined_cell_is_exact(run: dict[str, np.ndarray]) -> None:
    exact = integrate(plant(), PHASES, ["link.elongation"], every=60.0, tolerance=1e-11)
    off = run["link.elongation"][::60] - exact.values["link.elongation"]
    assert np.abs(off).max() < 1e-10


def test_the_co_simulated_cell_differs_by_its_coupling_error(run: dict[str, np.ndarray]) -> None:
    files = FmuStore("native").files(WARMUP_CELL.parts_with(LAW).values())
    system = WARMUP_CELL.system(files, LAW, {"duty": DUTY})
    names = ("link.elongation", "compensator.correction")
    coupled = simulate(system, STOP, 1.0, GaussSeidel())
    bounds = coupling_error(coupled, simulate(system, STOP, 0.5, GaussSeidel(), record=names), 1, names)
    off = [np.abs(coupled[name] - run[name]).max() for name in names]
    assert off[0] > 0, "the coupled cell has an error"
    assert all(each <= bounds[name] for each, name in zip(off, names, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_joined_cell_is_sound(cells: dict[FmiVersion, Path], version: FmiVersion) -> None:
    # A million steps take some seconds, and the C that takes memory is that of any FMU.
    cases = [name for name in CASES if name != "memory growth"]
    found = check_fmu(cells[version], cases=cases)
    assert not [each for each in found if each.verdict == "fail"]


def test_both_versions_give_the_same_numbers(
    cells: dict[FmiVersion, Path], run: dict[str, np.ndarray]
) -> None:
    result = simulate(alone(cells["3.0"]), STOP, 1.0)
    for name, values in run.items():
        np.testing.assert_array_equal(result[f"whole.{name}"], values)


def test_samples_fall_between_communication_points(
    cells: dict[FmiVersion, Path], run: dict[str, np.ndarray]
) -> None:
    """A master that communicates once a minute misses no sample, and micro steps stay as they are."""
    coarse = simulate(alone(cells["2.0"]), STOP, 60.0)
    for name, values in run.items():
        np.testing.assert_array_equal(coarse[f"whole.{name}"], values[::60])


@pytest.mark.platform
@pytest.mark.parametrize("referee", ["libcosim", "ecos"])
def test_other_masters_run_it(
    cells: dict[FmiVersion, Path], run: dict[str, np.ndarray], referee: str, tmp_path: Path
) -> None:
    path = tmp_path / "Alone.ssp"
    write_ssp(alone(cells["2.0"]), path)
    known = read_description(cells["2.0"]).variables
    asked = [(f"whole.{name}", known[name].value_reference) for name in WATCHED]
    if referee == "libcosim":
        theirs = libcosim(path, 300, asked)
    else:
        theirs = ecos(path, 300, 1.0, PARAMETER_SET, asked)
    ours = np.column_stack([run[name] for name in WATCHED])[1:301]
    np.testing.assert_array_equal(theirs, ours)


@pytest.mark.slow
def test_an_arm_is_one_fmu(tmp_path: Path) -> None:
    """Of two axes: six take a compiler half a minute, and `warmlink build` makes them."""
    count = 2
    scenario = load_scenario("six_axis_shift")
    assert isinstance(scenario.duty, Program)
    program = replace(scenario.duty, axes=count)
    scenario = replace(scenario, controller=shipped("lag"), machine=arm(count), duty=program)
    (fmu,) = build_native_fmus([Entry(scenario.joined(), HOME)], tmp_path)
    found = check_fmu(fmu, cases=["runs its default experiment", "state restore is bit-identical"])
    assert not [each for each in found if each.verdict == "fail"]
    names = [f"axis{i}.link.elongation" for i in range(1, count + 1)]
    stop = 600.0
    whole = simulate(alone(fmu), stop, 1.0)
    system = scenario.system(scenario.files(FmuStore("native")))
    coupled = simulate(system, stop, 1.0, GaussSeidel())
    bounds = coupling_error(coupled, simulate(system, stop, 0.5, GaussSeidel(), record=names), 1, names)
    for name, bound in bounds.items():
        assert 0 < np.abs(coupled[name] - whole[f"whole.{name}"]).max() <= bound, name
