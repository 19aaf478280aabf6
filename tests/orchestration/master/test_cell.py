"""The warm-up cell itself, of native FMUs: every way of running it gives the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.fmu import build_native_fmus
from warmlink.orchestration.catalogue import controller, entries
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton
from warmlink.orchestration.master.compiled.loop import Stepping
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.system.model import System

from .pairs import interrupt_at

ELONGATION = "link.elongation"
LAW = controller("lag").name
KINDS = set(WARMUP_CELL.parts_with(LAW).values())


def cell_of(files: dict[str, Path]) -> System:
    duty = load_scenario("stop_and_go").duty.component_parameters
    return WARMUP_CELL.system(files, LAW, {"duty": duty | {"duration[1]": 200.0, "duration[2]": 150.0}})


STEPPINGS: tuple[Stepping, ...] = ("plain", "compiled")


@pytest.fixture(scope="module")
def cell() -> System:
    try:
        return cell_of(FmuStore("native").files(KINDS))
    except InputError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("algorithm", [Jacobi(), GaussSeidel()], ids=str)
def test_compiled_and_plain_stepping_give_the_same_bits(
    cell: System, algorithm: Jacobi | GaussSeidel
) -> None:
    plain, compiled = (simulate(cell, 1200.0, 1.0, algorithm, stepping=stepping) for stepping in STEPPINGS)
    assert compiled.statistics.compiled
    assert plain.status == compiled.status == "completed"
    np.testing.assert_array_equal(plain.table.values.view(np.uint64), compiled.table.values.view(np.uint64))


def test_the_iterated_master_is_of_second_order_on_the_cell(cell: System) -> None:
    # The link's heat enters at communication points of the duty cycle alone, so all steps meet its jumps.
    fine = simulate(cell, 1200.0, 0.5, InterfaceNewton(), record=[ELONGATION])
    errors = []
    for step in (5.0, 10.0):
        run = simulate(cell, 1200.0, step, InterfaceNewton(), record=[ELONGATION])
        errors.append(np.max(np.abs(run[ELONGATION] - fine[ELONGATION][:: round(step / 0.5)])))
    assert np.log2(errors[1] / errors[0]) == pytest.approx(2.0, abs=0.5)
    held = simulate(cell, 1200.0, 10.0, GaussSeidel(), record=[ELONGATION])
    assert errors[1] < 0.05 * np.max(np.abs(held[ELONGATION] - fine[ELONGATION][::20]))


def test_the_error_controlled_master_keeps_its_tolerance_on_the_cell(cell: System) -> None:
    fine = simulate(cell, 600.0, 0.25, InterfaceNewton(), record=[ELONGATION])
    chosen = StepDoubling(FixedPoint(), {ELONGATION: 1e-9}, minimum_step=0.01)
    run = simulate(cell, 600.0, 30.0, chosen, record=[ELONGATION])
    assert run.status == "completed"
    # What the FMUs' own micro steps change between communication steps of 0.25 s and of 30 s is in it, too.
    assert np.max(np.abs(run[ELONGATION] - fine[ELONGATION][::120])) < 2e-9


def test_a_resumed_cell_is_bit_identical(cell: System, tmp_path: Path) -> None:
    whole = simulate(cell, 900.0, 1.0, GaussSeidel())
    long_run = LongRun(tmp_path / "run", 150, resume=True)
    for share in (0.4, 1.0):
        part = simulate(cell, 900.0, 1.0, GaussSeidel(), long_run=long_run, progress=interrupt_at(share))
    assert part.status == "completed"
    assert part.statistics.slave_steps == whole.statistics.slave_steps
    np.testing.assert_array_equal(whole.table.values, part.table.values)


def test_an_isolated_cell_gives_the_same_values(cell: System) -> None:
    inside = simulate(cell, 60.0, 1.0, GaussSeidel())
    outside = simulate(cell, 60.0, 1.0, GaussSeidel(), isolation=Isolation())
    np.testing.assert_array_equal(inside.table.values, outside.table.values)


@pytest.mark.slow
def test_versions_of_fmi_mix(cell: System, tmp_path: Path) -> None:
    chosen = [entries()[name] for name in ("ThermalLink", "MotorHeatSource", "DutyCycle")]
    newer = {path.stem: path for path in build_native_fmus(chosen, tmp_path, "3.0")}
    older = FmuStore("native").files(KINDS)
    reference = simulate(cell, 600.0, 10.0, FixedPoint(), record=[ELONGATION])
    for names in (("ThermalLink",), ("MotorHeatSource",), tuple(newer)):
        mixed = cell_of(older | {name: newer[name] for name in names})
        run = simulate(mixed, 600.0, 10.0, FixedPoint(), record=[ELONGATION])
        assert run.status == "completed", run.reason
        np.testing.assert_allclose(run[ELONGATION], reference[ELONGATION], rtol=0, atol=1e-11)
    # Here the pad's mode goes from enumeration to enumeration.
    plain, compiled = (
        simulate(mixed, 600.0, 10.0, Jacobi(), record=[ELONGATION], stepping=stepping)
        for stepping in ("plain", "compiled")
    )
    assert compiled.statistics.compiled
    np.testing.assert_array_equal(plain[ELONGATION], compiled[ELONGATION])
