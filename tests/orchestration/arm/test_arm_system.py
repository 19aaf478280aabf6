"""The arm as a system: each axis is a warm-up cell, heat is kept, and its SSPs say the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.rollout import demand_table
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source import equations as motor_equations
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.orchestration.arm.chain import arm_chain, arm_values, axes, axis, axis_name
from warmlink.orchestration.arm.program import Program
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.files import write_machine
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.scenarios.duties.duty import Duty
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import DefaultExperiment

from .conftest import MakeArm, load_program

HOUR = 3600.0


def one_axis_moves(program: Program, moving: int) -> Program:
    """The same program with all joints but one at rest."""

    def at_rest(duty: Duty) -> Duty:
        return replace(duty, segments=tuple(replace(s, speed=0.0, torque=0.0) for s in duty.segments))

    duties = (duty if j == moving else at_rest(duty) for j, duty in enumerate(program.duties, start=1))
    return replace(program, duties=tuple(duties))


@pytest.mark.parametrize("moving", [1, 3, 6])
def test_with_the_chain_cut_a_moving_axis_is_the_warm_up_cell(
    moving: int, plain_arm: MakeArm, inspection: Program, fmu_store: FmuStore
) -> None:
    arm = plain_arm(one_axis_moves(inspection, moving), cut=True)
    found = simulate(arm, 600.0, 1.0, Jacobi())

    none = controller("none").name
    kinds = WARMUP_CELL.parts_with(none)
    values = {
        "duty": inspection.start_values()[f"axis{moving}.duty"],
        "motor": {**axis(moving).motor, "neighbour_conductance": 0.0},
        "link": dict(axis(moving).link),
    }
    cell = simulate(WARMUP_CELL.system(fmu_store.files(set(kinds.values())), none, values), 600.0, 1.0)
    for name in (
        "link.elongation",
        "motor.shaft_temperature",
        "motor.heat_delivered",
        "link.tip_temperature",
    ):
        assert np.array_equal(found[f"{axis_name(moving)}.{name}"], cell[name])
    assert cell["link.elongation"][-1] > 1e-8
    for other in set(range(1, 7)) - {moving}:
        assert np.abs(found[f"{axis_name(other)}.link.elongation"]).max() < 1e-15


def generated(result: Result, name: str, program: Program, number: int) -> np.ndarray:
    """Heat in W that a motor's losses make, by its own equations from the recorded temperatures."""
    start = {s.name: s.start for s in MOTOR.scalars() if s.start is not None}
    p = MOTOR.p.read(np.array([{**start, **axis(number).motor}[n] for n in MOTOR.p.names]))
    demands = demand_table(program.duties[number - 1], 1.0, result.times[-1])
    u = MOTOR.u.read(np.zeros(MOTOR.u.size))._replace(speed=demands[:, 0], torque=demands[:, 1], current=0.0)
    winding, shaft = result[f"{name}.motor.winding_temperature"], result[f"{name}.motor.shaft_temperature"]
    return np.asarray(
        motor_equations.copper_loss(winding, u, p)
        + motor_equations.iron_loss(u, p)
        + motor_equations.friction_loss(shaft, u, p)
    )


def test_heat_balances_over_the_whole_arm(plain_arm: MakeArm) -> None:
    """What the losses made was stored in windings, shafts and links, or left by housings and surfaces."""
    program = load_program("six_axis_iso_9283")
    result = simulate(plain_arm(program), 2 * HOUR, 1.0, GaussSeidel())
    made = lost = stored = 0.0
    for number in range(1, 7):
        name, this = axis_name(number), axis(number)

        def rise(variable: str, name: str = name) -> float:
            return float(result[f"{name}.{variable}"][-1] - result[f"{name}.{variable}"][0])

        ambient = result[f"{name}.duty.ambient_temperature"]
        housing = this.motor["housing_conductance"] * (result[f"{name}.motor.shaft_temperature"] - ambient)
        made += np.trapezoid(generated(result, name, program, number), result.times)
        lost += np.trapezoid(housing + result[f"{name}.link.surface_heat_loss"], result.times)
        stored += this.motor["winding_heat_capacity"] * rise("motor.winding_temperature")
        stored += this.motor["shaft_heat_capacity"] * rise("motor.shaft_temperature")
        link = this.link
        per_metre = link["density"] * link["specific_heat"] * link["cross_section"]
        stored += per_metre * rise("link.elongation") / link["expansion_coefficient"]
    assert made > 1e5
    assert min(stored, lost) > 0.1 * made
    assert abs(made - lost - stored) < 1e-4 * made, (made, lost, stored)


def test_heat_passes_along_the_chain(plain_arm: MakeArm, inspection: Program) -> None:
    """A warm shoulder warms the column's tip and, through the upper arm, the elbow."""
    program = one_axis_moves(load_program("six_axis_iso_9283"), 2)
    linked = simulate(plain_arm(program), HOUR, 1.0, GaussSeidel())
    apart = simulate(plain_arm(program, cut=True), HOUR, 1.0, GaussSeidel())
    for name, least in (("axis1.link.tip_temperature", 0.5), ("axis3.motor.shaft_temperature", 0.1)):
        assert linked[name][-1] - 295.15 > least
        assert abs(apart[name][-1] - 295.15) < 1e-9
    given = linked["axis2.motor.neighbour_heat_flow"][-1]
    assert given > 0.1
    assert linked["axis2.motor.shaft_temperature"][-1] < apart["axis2.motor.shaft_temperature"][-1]


def test_the_tool_point_s_error_is_the_sum_over_the_axes(plain_arm: MakeArm, inspection: Program) -> None:
    result = simulate(plain_arm(inspection), 600.0, 1.0, Jacobi())
    for k, coordinate in enumerate("xyz", start=1):
        # With Jacobi the kinematics see elongations and angles of one step before.
        by_axis = sum(
            result[f"kinematics.sensitivity_{coordinate}[{i}]"][1:] * result[f"axis{i}.link.elongation"][:-1]
            for i in range(1, 7)
        )
        assert np.abs(result[f"kinematics.error[{k}]"][1:] - by_axis).max() < 1e-15


def test_nested_and_flat_ssp_hold_the_same_arm(
    plain_arm: MakeArm, inspection: Program, tmp_path: Path
) -> None:
    arm = replace(plain_arm(inspection), default_experiment=DefaultExperiment(0.0, 60.0, 1.0))
    nested, flat, _ = write_machine(arm, arm_chain(compensated=False).ports, tmp_path)
    assert (nested.name, flat.name) == ("SixAxisArm.ssp", "SixAxisArm-flat.ssp")
    read = read_system(nested, tmp_path / "nested")
    other = read_system(flat, tmp_path / "flat")
    assert set(read.components) == set(arm.components)
    assert {name.replace(".", "_") for name in read.components} == set(other.components)
    for name, held in read.components.items():
        assert held.values == other.components[name.replace(".", "_")].values
        assert held.values == arm.components[name].values
    assert set(read.connections) == set(arm.connections)
    assert len(other.connections) == len(arm.connections)
    a, b = simulate(read, 60.0, 1.0, Jacobi()), simulate(other, 60.0, 1.0, Jacobi())
    for name in ("axis2.link.elongation", "axis6.motor.shaft_temperature"):
        assert np.array_equal(a[name], b[name.replace(".", "_", 1)])
    assert a["axis2.link.elongation"][-1] > 0


@pytest.mark.parametrize("count", [1, 2, 6, 12])
def test_arms_of_any_length(count: int, plain_arm: MakeArm, inspection: Program) -> None:
    arm = plain_arm(inspection, count)
    arms = (count + 5) // 6
    assert len(arm.components) == 3 * count + 1 + arms
    result = simulate(arm, 60.0, 1.0, Jacobi())
    last = "kinematics" if arms == 1 else f"kinematics{arms}"
    assert result[f"{last}.error_norm"][-1] > 0


def test_an_arm_has_at_least_one_axis() -> None:
    with pytest.raises(InputError, match="give an arm at least 1 axis"):
        arm_chain(0)


def test_the_geometry_is_the_kinematics_own() -> None:
    from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS

    start = {s.name: s.start for s in KINEMATICS.scalars()}
    lengths = [each.link["length"] for each in axes()]
    assert start["link_offset[1]"] == pytest.approx(lengths[0])
    assert start["link_length[2]"] == pytest.approx(lengths[1])
    assert start["link_offset[4]"] == pytest.approx(lengths[2] + lengths[3])
    assert start["link_offset[6]"] == pytest.approx(lengths[4] + lengths[5])
    assert 10 < sum(each.mass for each in axes()) < 35
    assert arm_values(6)["axis1.motor"]["neighbour_conductance"] == 0
