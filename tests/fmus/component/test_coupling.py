"""Which states act on whose rates, whatever is on when the question comes up."""

from dataclasses import replace

import casadi
import numpy as np
import pytest

from warmlink.fmus.component import Component, Input, Output, Parameter, Record, State, Values
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.coupling import coupling
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.plant import plant
from warmlink.orchestration.catalogue import components

KNOWN = {**components(), "Plant": plant()}
INTEGRATED = [
    name for name, each in KNOWN.items() if each.rates is not None and each.continuous.size and not each.solve
]

SWITCHED = Component(
    name="Switched",
    description="Two lumps, between which a fan blows air",
    inputs=(Input("air", "W/K", "conductance of the air", nominal=1),),
    parameters=(Parameter("heat_capacity", "J/K", 2, "of each lump", positive=True),),
    states=(State("cold", "K", start=300.0), State("warm", "K", start=400.0)),
    outputs=(Output("temperature", "K", "temperature of the cold lump"),),
    rates=lambda x, u, p, time: {
        "cold": u.air * (x.warm - x.cold) / p.heat_capacity,
        "warm": u.air * (x.cold - x.warm) / p.heat_capacity,
    },
    observe=lambda x, u, p, time: {"temperature": x.cold},
    micro_step=0.1,
)


@pytest.mark.parametrize("name", INTEGRATED)
def test_it_is_that_of_the_equations_as_expressions(name: str) -> None:
    component, size = KNOWN[name], KNOWN[name].continuous.size
    sizes = (component.x.size, component.u.size, component.p.size, 1)
    x, u, p, time = (casadi.SX.sym(kind, count) for kind, count in zip("xupt", sizes, strict=True))
    rates = casadi.SX(component.rates_of(x, u, component.settled(p), time))
    expected = casadi.DM(casadi.jacobian_sparsity(rates, x[:size]), 1).full() != 0
    np.testing.assert_array_equal(coupling(component), expected | np.eye(size, dtype=bool))


def test_equations_that_refuse_some_points_are_asked_at_the_others() -> None:
    def early(x: Record, u: Record, p: Record, time: Number) -> Values:
        if time > 0:
            raise ArithmeticError("no such time")
        return {"cold": x.warm - x.cold, "warm": 0.0 * time}

    assert coupling(replace(SWITCHED, rates=early)).tolist() == [[True, True], [False, True]]


def test_a_state_goes_on_alike_where_a_coupling_was_off_before() -> None:
    lumps = Instance(SWITCHED)
    lumps.initialize()
    lumps.step(0.0, 5.0)
    lumps.set({"air": 0.5})
    saved = lumps.snapshot()
    lumps.step(5.0, 5.0)
    other = Instance(SWITCHED)
    other.restore(saved)
    other.step(5.0, 5.0)
    assert lumps.get("temperature") == other.get("temperature")
    exact = 350.0 - 50.0 * np.exp(-2 * 0.5 / 2 * 5.0)
    assert lumps.get("temperature") == pytest.approx(exact, abs=0.01)
