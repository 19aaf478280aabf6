"""Readings beside flags that say whether they are valid, for hosts in which NaN is not allowed."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeVar

from warmlink.fmus.component import Component, Input, Output, Record, State, Terminal, Values
from warmlink.fmus.component.arithmetic import Number, finite, where

Flag = TypeVar("Flag", Input, Output)


def flag_of(name: str) -> str:
    """Name of the flag of a variable or scalar, as `reading_valid[1]` of `reading[1]`."""
    variable, bracket, element = name.partition("[")
    return f"{variable}_valid{bracket}{element}"


def flagged(component: Component) -> Component:
    """Component with a flag (Boolean) beside each output that may be NaN and each input that copes with NaN.

    The output holds the last number there was, its nominal value before there is one. The input counts as
    missing while its flag is false. Connected flag to flag, components do what they do with NaN, bit for bit.
    """
    missing = {state.name for state in component.states if state.accepts_nan}
    outputs = {each.name: each for each in component.outputs if each.name in missing}
    inputs = {each.name: each for each in component.inputs if each.accepts_nan}
    if not outputs and not inputs:
        return component
    observe, update, begin = component.observe, component.update, component.started
    nominals = {name: each.nominal or 0.0 for name, each in outputs.items()}

    def inside(u: Record) -> Record:
        """Inputs as the component itself has them."""
        values = {each.name: getattr(u, each.name) for each in component.inputs}
        for name in inputs:
            values[name] = where(getattr(u, flag_of(name)) > 0.5, values[name], math.nan)
        return component.u.record(values)

    def with_held(states: Values, before: Values) -> Values:
        return {**states, **{_held(n): where(finite(states[n]), states[n], before[n]) for n in outputs}}

    def begin_held(u: Record, p: Record) -> Values:
        return with_held(begin(inside(u), p), nominals)

    def update_held(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
        assert update is not None
        held = {name: getattr(x, _held(name)) for name in outputs}
        return with_held(update(x, inside(u), p, time, step), held)

    def observe_held(x: Record, u: Record, p: Record, time: Number) -> Values:
        shown = dict(observe(x, inside(u), p, time))
        for name in outputs:
            shown[flag_of(name)] = where(finite(shown[name]), 1.0, 0.0)
            shown[name] = getattr(x, _held(name))
        return shown

    return replace(
        component,
        inputs=(*component.inputs, *(_flag(Input, each, start=1.0) for each in inputs.values())),
        outputs=(
            *(_holding(each) if each.name in outputs else each for each in component.outputs),
            *(_flag(Output, each) for each in outputs.values()),
        ),
        states=(*component.states, *(State(_held(v.name), v.unit, size=v.size) for v in outputs.values())),
        begin=begin_held,
        update=None if update is None else update_held,
        observe=observe_held,
        terminals=tuple(
            replace(each, members=tuple(_members(each, {*inputs, *outputs}))) for each in component.terminals
        ),
    )


def _held(name: str) -> str:
    return f"held_{name}"


def _holding(reading: Output) -> Output:
    about = reading.description.partition("; NaN")[0]
    return replace(reading, description=f"{about}; its last value while there is none")


def _flag(kind: type[Flag], reading: Input | Output, **more: Any) -> Flag:
    about = f"whether {reading.name} is a reading"
    return kind(flag_of(reading.name), "1", about, size=reading.size, type="Boolean", discrete=True, **more)


def _members(terminal: Terminal, flags: set[str]) -> Iterator[tuple[str, str]]:
    """Members of a terminal, with the flag behind what has one."""
    for member, scalar in terminal.members:
        yield member, scalar
        if scalar.partition("[")[0] in flags:
            yield f"{member}_valid", flag_of(scalar)
