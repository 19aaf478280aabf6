"""What is made once for a kind of part: its outputs in blocks, and its part of a step's matrix."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from warmlink.fmus.component import Component
from warmlink.fmus.component.dependencies import dependencies
from warmlink.fmus.component.integrator import GAMMA, ComplexStepJacobian, Vector
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.packaging.native.kinds import Kind
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

STEP, TIME, BACK = 0.5, 30.0, 0.7


def driven(component: Component, **parameters: float) -> tuple[Vector, Vector, Vector]:
    """States, inputs and settled parameters with which something happens."""
    p, u = component.start_values(parameters)
    u = (
        u
        + np.array([scalar.variable.nominal or 1.0 for scalar in component.scalars()[p.size :][: u.size]]) / 7
    )
    d = np.asarray(component.settled(p), dtype=float)
    x = np.asarray(component.states_at_start(u, d), dtype=float)
    return x + np.sin(np.arange(x.size)), u, d


@pytest.mark.parametrize("component", [MOTOR, LINK], ids=lambda each: each.name)
def test_blocks_hold_every_output_once_with_all_that_acts_on_it(component: Component) -> None:
    kind, direct = Kind(component, several=True), dependencies(component).outputs
    given = [*driven(component), TIME]
    expected = component.outputs_of(*given)
    seen = []
    for number, block in enumerate(kind.blocks):
        seen += block.outputs
        found = kind.outputs(number)(*given)
        assert found.full().ravel() == pytest.approx(expected[list(block.outputs)], rel=1e-12)
        known = {component.u.names[i] for i in block.inputs}
        for i in block.outputs:
            assert known == {*direct[component.y.names[i]]} & {*component.u.names}
    assert sorted(seen) == [*range(component.y.size)]
    for name, (number, at) in kind.place.items():
        assert kind.blocks[number].outputs[at] == component.y.index[name]


@pytest.mark.parametrize("rare", [{}, {"viscosity_temperature_coefficient": 0.02}], ids=["usual", "rare"])
def test_a_steps_matrix_has_what_comes_back_by_way_of_other_parts(rare: dict[str, float]) -> None:
    """An input that rises with a state of the part itself makes the rates depend on that state."""
    x, u, d = driven(MOTOR, **rare)
    fed, state = MOTOR.u.index["link_base_temperature"], MOTOR.x.index["shaft_temperature"]
    run, places = Kind(MOTOR, several=True).linearised([fed], [(fed, state)])
    found = run(x, u, d, TIME, STEP, casadi.DM([BACK])).full().ravel()
    size = MOTOR.continuous.size

    def rates(states: Vector, inputs: Vector) -> Vector:
        come = np.zeros(u.size, dtype=complex)
        come[fed] = BACK * (states[state] - x[state])
        return np.asarray(MOTOR.rates_of(states, inputs + come, d, TIME))

    by_state = ComplexStepJacobian(np.ones((size, size), dtype=bool))(lambda each: rates(each, u), x)
    by_input = np.imag(rates(x, u + 1e-30j * (np.arange(u.size) == fed))) / 1e-30
    expected = np.column_stack([np.eye(size) - GAMMA * STEP * by_state, by_input])
    whole = np.column_stack([np.eye(size), np.zeros(size)])
    for place, value in zip(places, found[size:], strict=True):
        whole[place] = value
    assert found[:size] == pytest.approx(np.real(rates(x, u)), rel=1e-12)
    assert whole == pytest.approx(expected, rel=1e-9, abs=1e-15)
