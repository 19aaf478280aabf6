"""What a kind of part computes is written once, and gives the doubles of what is written out whole."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native import codegen, joint_code, joint_step
from warmlink.fmus.packaging.native.casadi_code import function
from warmlink.fmus.packaging.native.wired import WirePlan
from warmlink.orchestration.arm.chain import arm_chain
from warmlink.orchestration.catalogue import controller

COUNT = 2


@pytest.fixture(scope="module", params=[True, False], ids=["with laws", "plant"])
def arm(request: pytest.FixtureRequest) -> Component:
    return joined(COUNT, request.param)


def joined(count: int, compensated: bool = True) -> Component:
    machine = arm_chain(count, compensated)
    return machine.joined(controller("observer") if compensated else None)


def given(arm: Component, sizes: list[int]) -> list[NDArray[np.float64]]:
    """Numbers about those of the start for the first arguments, x, u and d; anything for the others."""
    rng = np.random.default_rng(3)
    p, u = arm.start_values()
    d = np.array(arm.settled(p), dtype=float)
    x = np.nan_to_num(np.array(arm.states_at_start(u, d), dtype=float))
    x[: arm.continuous.size] += rng.normal(size=arm.continuous.size)
    d = d * (1 + 1e-3 * rng.normal(size=d.size))
    known = {arm.x.size: x, arm.d.size: d, arm.u.size: u + 0.1}
    return [known.get(size, np.full(size, 0.7)) for size in sizes]


def test_calls_give_the_doubles_of_what_is_written_out(arm: Component) -> None:
    plan = WirePlan(arm)
    groups, seen = joint_code.output_functions(plan)
    parts = [*joint_step.stepping(plan), *seen]
    parts += [*joint_step.slopes(plan)] if not arm.sampled else []
    called = {name: function(name, *rest) for name, *rest in parts}
    written = {name: function(name, *rest) for name, *rest in codegen.written_out(arm, groups)}
    assert called.keys() == written.keys()
    for name, whole in written.items():
        values = given(arm, [whole.size1_in(k) for k in range(whole.n_in())])
        one, other = (np.array(each(*values)).ravel() for each in (called[name], whole))
        if name != "advance":
            np.testing.assert_array_equal(one, other, err_msg=name)
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12, err_msg=name)


def test_another_axis_adds_little_c() -> None:
    sizes = []
    for count in (2, 3):
        sources = codegen.generate(joined(count))
        text = sources["starting.c"] + sources["running.c"]
        sizes.append(len(text) + len(sources["deriving.c"]))
        for kind in ("begin_ThermalLink", "update_ObserverCompensator", "rates_ThermalLink"):
            assert len(re.findall(rf"^static void {kind}_\d+\(", text, re.MULTILINE)) == 1, kind
    assert sizes[1] - sizes[0] < 0.2 * sizes[0]
