"""A law as a program: which variables it has and how they are named, and that functions stand in order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from warmlink.controllers.export.program.places import RESERVED
from warmlink.controllers.export.program.program import RECALLED, LawProgram, program
from warmlink.controllers.export.program.statements import Slot
from warmlink.controllers.matrices import dot
from warmlink.controllers.own import Law, component_of
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Component, Parameter, State


@as_c_function
def inner(value: Any) -> Any:
    """What a function calls, with a result that may not be called so."""
    real = value * value
    return real  # noqa: RET504 - the name is what is tried


@as_c_function
def update(value: Any, gain: Any) -> Any:
    """A function with a name that each law's program has."""
    Gain = inner(value) + 1.0
    return Gain * inner(Gain) * gain


WEIGHTS = np.array([0.5, 0.25, 0.125])


class Tried(Law):
    """A law whose author has used names that are taken."""

    parameters = (
        Parameter("second", "m/K", 2e-6, "declared first"),
        Parameter("unread", "m", 1.0, "which the law does not use"),
        Parameter("first", "1", 3.0, "declared last"),
    )
    states = (State("mean", "K", size=3), State("slow_sum", "K", slow=True))

    def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
        """The states after a sample."""
        real = update(u.tip_temperature, p.first)
        integral = x.mean + step * real
        return {"mean": integral, "slow_sum": x.slow_sum + dot(WEIGHTS, integral)}

    def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        """The correction in m."""
        return p.second * update(x.slow_sum, p.first)


class Timed(Law):
    """A law that reads the clock, and remembers nothing of what it was told."""

    states = (State("seen", "K"),)

    def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
        """The states after a sample."""
        return {"seen": u.tip_temperature}

    def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        """The correction in m."""
        return 1e-9 * time * x.seen


class Resumed(Law):
    """A law that goes on where it was."""

    parameters = (
        Parameter("recalled", "m", 0.0, "retained"),
        Parameter("recalled_for", "s", 0.0, "for so long"),
    )
    states = (State("seen", "m"),)

    def begin(self, u: Any, p: Any) -> dict[str, Any]:
        """The states at the start."""
        return {"seen": p.recalled * (p.recalled_for < 3600.0)}

    def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
        """The states after a sample."""
        return {"seen": 0.9 * x.seen}

    def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        """The correction in m."""
        return x.seen


def program_of(law: type[Law], single: bool = False) -> tuple[Component, LawProgram]:
    component = component_of(law)
    settled = component.settled(component.start_values()[0])
    return component, program(component, settled, law.__name__.lower(), single)


def slots(made: LawProgram) -> list[Slot]:
    """Each variable that any of the functions reads or writes."""
    return list({id(s): s for routine in made.routines for s in routine.slots()}.values())


def test_its_constants_are_those_that_it_reads_as_they_are_declared_and_then_its_tables() -> None:
    component, made = program_of(Tried)
    names = [slot.name for slot in made.design]
    values = component.d.values(component.settled(component.start_values()[0]))
    declared = [name for name in names if name in component.d.index]
    assert "unread" not in names
    assert [n for n in declared if n in ("first", "second")] == ["second", "first"]
    assert names[: len(declared)] == declared
    for slot in made.design[: len(declared)]:
        assert np.array_equal(slot.values, np.atleast_1d(values[slot.name])), slot.name
    tables = [slot.values.tolist() for slot in made.design[len(declared) :]]
    assert WEIGHTS.tolist() in tables


def test_its_records_hold_all_that_the_law_declares_and_nothing_is_left_undeclared() -> None:
    component, made = program_of(Tried)
    assert [slot.name for slot in made.states] == ["mean", "slow_sum"]
    assert [slot.size for slot in made.states] == [3, 1]
    assert [slot.name for slot in made.inputs] == list(component.u.names)
    assert [slot.name for slot in made.outputs] == list(component.y.names)
    known = {id(slot) for slot in (*made.states, *made.inputs, *made.outputs, *made.design)}
    for slot in slots(made):
        assert slot.record not in ("input", "output", "next", "design") or id(slot) in known, slot.name


def test_functions_stand_after_those_that_they_call() -> None:
    _, made = program_of(Tried)
    assert {"inner", "begin", "tell"} < {routine.name for routine in made.routines}
    for place, routine in enumerate(made.routines):
        for called in routine.calls():
            assert any(called is earlier for earlier in made.routines[:place]), (routine.name, called.name)


def test_no_name_is_given_twice_or_means_something_in_a_language() -> None:
    _, made = program_of(Tried)
    functions = [routine.name.lower() for routine in made.routines]
    assert len(set(functions)) == len(functions)
    assert (made.begin.name, made.update.name, made.outputs_of.name) == ("begin", "update", "tell")
    shared = {s.name.lower() for s in (*made.inputs, *made.states, *made.outputs, *made.design)}
    for routine in made.routines:
        own = [*routine.arguments, *routine.results, *routine.kept, *routine.locals]
        names = [slot.name.lower() for slot in {id(s): s for s in own}.values()]
        assert len(set(names)) == len(names), names
        assert not RESERVED & set(names)
        assert not shared & set(names)


@pytest.mark.parametrize("single", [False, True])
def test_what_rounding_leaves_of_slow_states_is_a_state_in_single_precision(single: bool) -> None:
    _, made = program_of(Tried, single)
    assert [slot.name for slot in made.states] == ["mean", "slow_sum"] + ["slow_sum_rest"] * single


def test_a_law_has_a_clock_only_where_it_reads_it_and_a_memory_only_where_it_retains() -> None:
    assert program_of(Timed)[1].timed
    assert not program_of(Tried)[1].timed
    assert program_of(Tried)[1].recall == []


def test_what_a_restart_gives_back_is_no_constant() -> None:
    _, made = program_of(Resumed)
    assert [slot.name for slot in made.recall] == list(RECALLED)
    assert not {slot.name for slot in made.design} & set(RECALLED)
