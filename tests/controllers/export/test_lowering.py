"""What a law computes, as statements: the same numbers, whatever is changed in place and in which order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.controllers.export.interpreter import Interpreter
from warmlink.controllers.export.program.program import LawProgram, program
from warmlink.controllers.export.program.statements import kinds_of
from warmlink.controllers.export.vectors import said
from warmlink.controllers.interface import SENSED
from warmlink.controllers.matrices import dot, matrix, outer, symmetric, upper
from warmlink.controllers.own import Law, component_of
from warmlink.fmus.calls import as_c_function, skip_if_zero, vectorised_pair
from warmlink.fmus.component import Component, State
from warmlink.fmus.component.arithmetic import absolute, exp, maximum, stack, total, truth, where

ROOM = 295.15

Step = Callable[[Any, Any, Any], Any]
"""A vector of four a sample later: by itself, by the readings in K above the room, and by the time in s."""


@skip_if_zero
def swapped(both: tuple[Any, Any], share: Any, asked: Any) -> tuple[Any, Any]:
    """Two vectors that become each other, changed in place."""
    one, other = both
    mixed = other + share * one
    return where(asked > 0, mixed, one), where(asked > 0, one - 0.5 * other, other)


@skip_if_zero
def turned(vector: Any, asked: Any) -> Any:
    """Elements that move on, changed in place."""
    return where(asked > 0, stack(vector[3], vector[0], vector[1], vector[2]), vector)


@skip_if_zero
def reflected(vector: Any, asked: Any) -> Any:
    """Elements that change places and shrink, changed in place."""
    return where(asked > 0, 0.5 * vector[::-1], vector)


@as_c_function
def mixed(vector: Any, other: Any) -> Any:
    """A result that may not be written over what it is made of: each element is read again later."""
    return vector[::-1] + other * dot(vector, other)


@as_c_function
def shrunk(vector: Any) -> Any:
    """A result that may be written over what it is made of."""
    return vector / (1.0 + absolute(vector))


@as_c_function
def measured(vector: Any) -> tuple[Any, Any]:
    """A number and a vector, of which one may be left unread."""
    return total(absolute(vector)), shrunk(vector)


def followed(both: Any, share: Any) -> Any:
    """One of two side by side that follows a share."""
    return both + 0.1 * (share - both[::-1])


def exchanged(x: Any, u: Any, time: Any) -> Any:
    asked = truth(u[0] > 0.0)
    one, other = swapped((x[:2], x[2:]), 0.25, asked)
    return stack(other, one)


def twice(x: Any, u: Any, time: Any) -> Any:
    later = mixed(x, u[:4])
    return mixed(later, later) + 0.1 * mixed(u[:4], x)


STEPS: dict[str, Step] = {
    "element by element": lambda x, u, time: 0.5 * x + exp(-absolute(x)) * u[1],
    "in another order": lambda x, u, time: stack(x[2], 0.5 * x[0], u[0], x[1] - x[3]),
    "a product with a matrix": lambda x, u, time: matrix(stack(*([0.2, -0.1, 0.3, 0.05] * 4)), 4) @ x + u[:4],
    "the triangle of a matrix": lambda x, u, time: upper(symmetric(x[:3], 2) @ symmetric(u[:3], 2).T)[
        [0, 1, 2, 0]
    ],
    "a product of vectors": lambda x, u, time: 0.1 * outer(x[:2], u[:2]).ravel(),
    "two that are swapped": exchanged,
    "elements that move on": lambda x, u, time: 0.9 * turned(x, truth(u[1] < u[2])) + 0.1 * u[:4],
    "elements that change places": lambda x, u, time: reflected(x, truth(u[1] < u[2])) + 0.1 * u[:4],
    "a function that is called on its own result": twice,
    "a result that is left unread": lambda x, u, time: measured(x)[1] + measured(u[:4])[0],
    "both of a pair": lambda x, u, time: vectorised_pair(followed, 1)(x, u[0] + 1e-3 * time),
}


def law_of(step_of: Step) -> Component:
    """A law with a vector of four that goes on so."""

    class Tried(Law):
        """A law with one vector."""

        states = (State("held", "K", size=4),)

        def begin(self, u: Any, p: Any) -> dict[str, Any]:
            """The states at the start."""
            return {"held": stack(*[u.tip_temperature - ROOM] * 2, 0.5, -0.25)}

        def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
            """The states after a sample, which stay within bounds."""
            readings = stack(*(getattr(u, name) - ROOM for name in SENSED))
            later = step_of(x.held, readings, time + step)
            return {"held": later / (1.0 + 0.01 * total(absolute(later)))}

        def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
            """The correction in m."""
            return 1e-6 * dot(x.held, np.array([1.0, 2.0, 4.0, 8.0]))

    return component_of(Tried)


def program_of(component: Component) -> LawProgram:
    settled = component.settled(component.start_values()[0])
    return program(component, settled, "tried", False)


@pytest.mark.parametrize("name", STEPS)
def test_statements_give_the_numbers_of_the_law(name: str) -> None:
    component = law_of(STEPS[name])
    draw = np.random.default_rng(5)
    rows = np.tile(component.start_values()[1], (8, 1))
    places = [component.u.index[each] for each in SENSED]
    rows[:, places] = ROOM + draw.normal(size=(8, len(places)))
    wanted = said(component, rows, 1.0)[:, component.y.index["correction"]]
    law, found = Interpreter(program_of(component)), []
    for sample, row in enumerate(rows):
        u = dict(zip(component.u.names, row.tolist(), strict=True))
        told = law.begin(u) if sample == 0 else law.step(u, float(sample))
        found.append(float(told["correction"][0]))
    assert np.ptp(wanted) > 1e-8
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize(
    ("step_of", "kinds"),
    [
        (lambda x, u, time: u[:4] / x, {"ratio"}),
        (lambda x, u, time: u[:4] / (1.0 + absolute(x)), {"div"}),
        (lambda x, u, time: u[:4] * x**0.5, {"root"}),
        (lambda x, u, time: u[:4] * maximum(x, 0.0) ** 0.5, {"sqrt"}),
    ],
)
def test_a_quotient_or_a_root_is_guarded_where_it_may_be_none(step_of: Step, kinds: set[str]) -> None:
    update = next(each for each in program_of(law_of(step_of)).routines if each.name == "update")
    # The state that it becomes is divided by what is never 0.
    assert set(kinds_of(update.body)) & {"ratio", "root", "sqrt"} == kinds - {"div"}


def test_a_result_is_written_over_an_argument_only_where_that_is_not_read_later() -> None:
    every = {each.name: each for each in program_of(law_of(twice)).routines}
    assert every["mixed"].over == {0: 1}  # the first one is read in another order
    later = {each.name: each for each in program_of(law_of(lambda x, u, time: shrunk(x))).routines}
    assert later["shrunk"].over == {0: 0}
