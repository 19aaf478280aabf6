"""A law as a program without a language: its records, its constants, and functions made of statements."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warmlink.controllers.export.program import tracing
from warmlink.controllers.export.program.expressions import Given
from warmlink.controllers.export.program.lowering import Lowering
from warmlink.controllers.export.program.noted import Noted
from warmlink.controllers.export.program.places import RESERVED, FreeNames, Tables
from warmlink.controllers.export.program.statements import Routine, Slot
from warmlink.controllers.export.program.tracing import TracedFunction, leaf
from warmlink.fmus.component import Component
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.variables import Layout

RECALLED = ("recalled", "recalled_for")
"""Parameters of a law that goes on after a restart: what was retained, and for how long in s."""


_HELPERS = ("left", "larger", "smaller", "ratio", "root", "no_number", "floor", "erf")
_TYPES = ("outputs", "table", "real", "inputs", "state", "recall", "vector", "places")
_FUNCTIONS = (*_HELPERS, *_TYPES, "begin", "update", "tell", "init", "step")
"""Names of functions and types that every law has."""


@dataclass(frozen=True)
class LawProgram:
    """A law's functions and variables.

    Attributes
    ----------
    states, inputs, outputs : of its records
    design : constants that it reads: parameters, what follows from them, and tables
    recall : what a restart gives back, empty where nothing is retained
    routines : its functions, each after those that it calls
    begin, update, outputs_of : those that a host calls; None where there is nothing to do
    """

    states: list[Slot]
    inputs: list[Slot]
    outputs: list[Slot]
    design: list[Slot]
    recall: list[Slot]
    routines: list[Routine]
    begin: Routine
    update: Routine
    outputs_of: Routine
    timed: bool


def program(component: Component, settled: Number, name: str, single: bool) -> LawProgram:
    """The program of a law that samples, for its parameters and what they settle, shape (d.size,).

    No variable gets the law's name. In single precision what rounding leaves of slow states is a state too.

    Raises
    ------
    InputError
        If the law decides or computes in a way that cannot be written down.
    """
    leaves: dict[tuple[str, str], Slot] = {}
    slow = {v.name: _rest_of(v) for v in component.states if single and v.slow}
    with tracing.traced(Noted, tuple(slow)):
        x = _record(component.x, "state", leaves)
        u = _record(component.u, "input", leaves)
        for of, rest in slow.items():
            x[of].rest = leaf("state", rest.name, rest.shape)
            leaves["state", rest.name] = rest
        p = _record(component.d, "design", leaves, component.d.values(settled))
        time = leaf("clock", "time", ())
        leaves[time.data] = Slot("elapsed", (), "clock", unit="s")
        assert component.update is not None
        update, updated = tracing.run(
            "update",
            "The states after a sample.",
            component.update,
            x,
            u,
            p,
            time,
            p["sample_time"],
            states=True,
        )
        begin, begun = tracing.of_records(_started(component), u, p)
        told, named = tracing.run("outputs", "What the law says.", component.observe, x, u, p, time)
        functions = tracing.functions()
    known = (slot for slot in leaves.values() if slot.record not in ("state", "recall"))
    taken = {slot.name.lower() for slot in known} | {v.name.lower() for v in component.outputs}
    taken |= RESERVED | {
        "x",
        "u",
        "y",
        "next",
        "fresh",
        "running",
        "samples",
        "passed",
        "retained",
        *RECALLED,
        *_HELPERS,
    }
    everywhere = set(taken)
    tables = Tables(FreeNames(everywhere))
    routines: dict[int, Routine] = {}
    roots = {
        id(begin): (begun, "next"),
        id(update): (tuple(updated), "next"),
        id(told): (tuple(named), "output"),
    }
    variables = {"next": component.states, "output": component.outputs}
    made = {record: {v.name: _slot(v, record) for v in declared} for record, declared in variables.items()}
    made["next"] |= {rest.name: replace(rest, record="next") for rest in slow.values()}
    of_functions = FreeNames(set(_FUNCTIONS))
    of_roots = FreeNames(taken, everywhere, tables.names)
    order = [*functions, update, told]
    for traced in order:
        if id(traced) in roots:
            fields, record = roots[id(traced)]
            targets = [made[record][name] for name in fields]
            traced.name = {id(begin): "begin", id(update): "update"}.get(id(traced), "tell")
        else:
            traced.name = of_functions.fresh(traced.name)
        local = of_roots if id(traced) in roots else FreeNames(taken, everywhere, tables.names)
        if id(traced) not in roots:
            targets = _targets(traced, leaves, local)
        else:
            _arguments(traced, leaves, local)
        routines[id(traced)] = Lowering(traced, targets, leaves, tables, local, routines).lowered()
    every = list(routines.values())
    read = {id(slot): slot for routine in every for slot in routine.slots() if slot.record == "design"}
    recall = [slot for name in RECALLED if (slot := leaves.get(("recall", name)))]
    return LawProgram(
        list(made["next"].values()),
        [leaves["input", v.name] for v in component.inputs],
        list(made["output"].values()),
        _in_order(read.values(), component),
        recall,
        every,
        routines[id(begin)],
        routines[id(update)],
        routines[id(told)],
        any(slot.record == "clock" for routine in every for slot in routine.slots()),
    )


def _rest_of(state: Any) -> Slot:
    """The state that holds what rounding leaves of another one."""
    like = _slot(state, "state")
    about = f"what rounding left of {state.name}"
    return Slot(f"{state.name}_rest", like.shape, "state", unit=like.unit, about=about)


def _started(component: Component) -> Callable[..., Any]:
    return component.begin if component.begin is not None else component.started


def _record(
    layout: Layout, record: str, leaves: dict[tuple[str, str], Slot], values: dict[str, Number] | None = None
) -> Given:
    found = {}
    for variable in layout.variables:
        of = record
        value = None if values is None else np.asarray(values[variable.name], dtype=float)
        if record == "design" and variable.name in RECALLED:
            of, value = "recall", None
        slot = _slot(variable, of)
        slot.values = None if value is None else np.atleast_1d(value)
        found[variable.name] = leaf(of, variable.name, slot.shape, value)
        leaves[found[variable.name].data] = slot
    return Given(found)


def _slot(variable: Any, record: str) -> Slot:
    shape = () if variable.size is None else (variable.size,)
    about = getattr(variable, "description", "").replace("*/", "* /").replace("*)", "* )")
    return Slot(variable.name, shape, record, unit=variable.unit, about=about)


def _arguments(traced: TracedFunction, leaves: dict[tuple[str, str], Slot], names: FreeNames) -> None:
    for k, each in enumerate(traced.arguments):
        record = "kept" if k < traced.kept else "argument"
        paired = k < traced.paired
        leaves[each.data] = Slot(names.fresh(each.name), each.shape, record, paired=paired)


def _targets(traced: TracedFunction, leaves: dict[tuple[str, str], Slot], names: FreeNames) -> list[Slot]:
    """Variables of a function that take its results."""
    _arguments(traced, leaves, names)
    if traced.kept:
        return [leaves[each.data] for each in traced.arguments[: traced.kept]]
    found = []
    for each in traced.results:
        if any(each is argument for argument in traced.arguments):
            found.append(leaves[each.data])
            continue
        name = names.fresh(each.name or each.fallback or traced.name)
        found.append(Slot(name, each.shape, "result", paired=traced.paired > 0))
    return found


def _in_order(slots: Iterable[Slot], component: Component) -> list[Slot]:
    """Parameters as they are declared, then what follows from them, then tables."""
    order = {variable.name: k for k, variable in enumerate(component.d.variables)}
    last = len(order)
    return sorted(slots, key=lambda slot: (slot.whole, order.get(slot.name, last)))
