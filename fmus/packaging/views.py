"""What hosts see of a component: its inside, states that they may integrate, flags in place of NaN."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple, TypeVar

from warmlink.fmus.component import (
    Component,
    Input,
    Local,
    Output,
    Record,
    Scalar,
    State,
    Terminal,
    Values,
    Variable,
)
from warmlink.fmus.component.arithmetic import Number, finite, where
from warmlink.fmus.component.join import Joint, Wire, join

Flag = TypeVar("Flag", Input, Output)


@cache
def opened(component: Component) -> Component:
    """Component whose local variables stand behind its outputs, as native FMUs have them."""
    observe, look_inside = component.observe, component.look_inside
    if look_inside is None:
        return component
    return replace(
        component,
        outputs=(*component.outputs, *component.local),
        observe=lambda *given: {**observe(*given), **look_inside(*given)},
        look_inside=None,
    )


class ExchangedState(NamedTuple):
    """A continuous state as hosts see it, as `state.temperature`, and its rate; numbered after all else."""

    state: Scalar
    rate: Scalar


def exchanged_states(component: Component) -> list[ExchangedState]:
    """States of a component that its host may integrate; none where anything is sampled."""
    found: list[ExchangedState] = []
    first, count = component.p.size + component.u.size + component.y.size + 1, component.x.size
    known = {variable.name: variable.nominal for variable in (*component.parameters, *component.outputs)}
    for each in component.states if not component.sampled else ():
        whole, dot, _ = each.name.rpartition(".")
        # As the output of the same name, or the parameter that it starts from.
        nominal = known.get(each.name) or known.get(f"{whole}{dot}{each.start}") or 1.0
        for name in (f"state.{own}" for own in each.scalar_names):
            state = Local(name, each.unit, "state, for hosts that integrate it", nominal=nominal)
            rate, at = Local(f"der({name})", f"{each.unit}/s", "rate of change"), first + len(found)
            found.append(ExchangedState(Scalar(at, name, state, 0), Scalar(at + count, rate.name, rate, 0)))
    return found


def flag_of(name: str) -> str:
    """Name of the flag of a variable or scalar, as `reading_valid[1]` of `reading[1]`."""
    variable, bracket, element = name.partition("[")
    return f"{variable}_valid{bracket}{element}"


def with_flag_wires(wires: Collection[Wire], ends: Collection[str]) -> list[Wire]:
    """Wires, and those between the flags of what they connect, where both flags are among the `ends`."""
    flags = ((flag_of(source), flag_of(target)) for source, target in wires)
    return [*wires, *(each for each in flags if each[0] in ends and each[1] in ends)]


def flagged(component: Component) -> Component:
    """Component with a flag (Boolean) beside each output that may be NaN and each input that copes with NaN.

    The output holds the last number there was, its nominal value before there is one. The input counts as
    missing while its flag is false. Connected flag to flag, components do what they do with NaN, bit for bit.
    """
    if component.joint is not None:
        return _joined_with_flags(component, component.joint)
    missing = {state.name for state in component.states if state.accepts_nan}
    outputs = {each.name: each for each in component.outputs if each.name in missing}
    inputs = {each.name: each for each in component.inputs if each.accepts_nan}
    if not outputs and not inputs:
        return component
    observe, update, begin = component.observe, component.update, component.started

    def inside(u: Record) -> Record:
        """Inputs as the component itself has them."""
        values = {each.name: getattr(u, each.name) for each in component.inputs}
        for name in inputs:
            values[name] = where(getattr(u, flag_of(name)) > 0.5, values[name], math.nan)
        return component.u.record(values)

    def with_held(states: Values, before: Values) -> Values:
        return {**states, **{_held(n): where(finite(states[n]), states[n], before[n]) for n in outputs}}

    def begin_held(u: Record, p: Record) -> Values:
        return with_held(begin(inside(u), p), {n: each.nominal or 0.0 for n, each in outputs.items()})

    def update_held(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
        assert update is not None
        before = {name: getattr(x, _held(name)) for name in outputs}
        return with_held(update(x, inside(u), p, time, step), before)

    def observe_held(x: Record, u: Record, p: Record, time: Number) -> Values:
        shown = dict(observe(x, inside(u), p, time))
        for name in outputs:
            shown[flag_of(name)] = where(finite(shown[name]), 1.0, 0.0)
            shown[name] = getattr(x, _held(name))
        return shown

    terminals = ((each, tuple(_members(each, {*inputs, *outputs}))) for each in component.terminals)
    kept = (_holding(each) if each.name in outputs else each for each in component.outputs)
    return replace(
        component,
        inputs=(*component.inputs, *_flags(Input, inputs, start=1.0)),
        outputs=(*kept, *_flags(Output, outputs)),
        states=(*component.states, *(State(_held(v.name), v.unit, size=v.size) for v in outputs.values())),
        begin=begin_held,
        update=None if update is None else update_held,
        observe=observe_held,
        terminals=tuple(replace(each, members=members) for each, members in terminals),
    )


def _joined_with_flags(component: Component, joint: Joint) -> Component:
    """Component joined of the same parts with flags, and wires between them where both ends have one."""
    parts = {key: flagged(part) for key, part in joint.parts.items()}
    ends = {f"{key}.{scalar.name}" for key, part in parts.items() for scalar in part.scalars()}
    wires = [(source, target) for target, source in joint.wires.items()]
    return replace(
        join(component.name, parts, with_flag_wires(wires, ends), component.description),
        parameters=component.parameters,
        default_stop_time=component.default_stop_time,
        default_step_size=component.default_step_size,
    )


def _held(name: str) -> str:
    return f"held_{name}"


def _holding(reading: Output) -> Output:
    about = reading.description.partition("; NaN")[0]
    return replace(reading, description=f"{about}; its last value while there is none")


def _flags(kind: type[Flag], readings: Mapping[str, Variable], **more: Any) -> Iterator[Flag]:
    for name, each in readings.items():
        told = (flag_of(name), "1", f"whether {name} is a reading")
        yield kind(*told, size=each.size, type="Boolean", discrete=True, **more)


def _members(terminal: Terminal, flags: set[str]) -> Iterator[tuple[str, str]]:
    """Members of a terminal, with the flag behind what has one."""
    for member, scalar in terminal.members:
        yield member, scalar
        if scalar.partition("[")[0] in flags:
            yield f"{member}_valid", flag_of(scalar)
