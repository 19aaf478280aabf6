"""The declaration of a component: its variables once, and the functions that give it behaviour.

Both FMUs, their model descriptions, the documentation tables and the SSP connectors are derived from a
`Component`; no list of variables is written anywhere else.
"""

from __future__ import annotations

import re
from collections import namedtuple
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, Literal, Protocol

import numpy as np

from warmlink.fmus.arithmetic import Number, stack

Record = Any
"""Named values, one attribute a variable: a number, or a vector where the variable has a size."""

VariableType = Literal["Real", "Integer", "Boolean"]

SHORTEST_SAMPLE_TIME = 1e-3
"""s; nothing warms up in less, and a run of hours with a shorter one would not end."""

MOST_IN_A_STEP = 10_000
"""Samples, or micro steps, that one communication step may take: no host waits for it for minutes."""


@dataclass(frozen=True)
class _Named:
    name: str
    unit: str
    size: int | None = field(default=None, kw_only=True)

    @property
    def count(self) -> int:
        """Number of scalars."""
        return 1 if self.size is None else self.size

    @property
    def scalar_names(self) -> list[str]:
        """Names of the scalars: `heat_flow`, or `position[1]` to `position[8]`."""
        if self.size is None:
            return [self.name]
        return [f"{self.name}[{i}]" for i in range(1, self.size + 1)]


@dataclass(frozen=True)
class _Variable(_Named):
    """What inputs, parameters and outputs have in common.

    Attributes
    ----------
    unit : SI unit in Modelica's notation, as `W/(m2.K)`; "1" for a pure number
    display : unit in which people read it, as `degC` or `um`; None where it is the unit itself
    nominal : size of an ordinary value, by which tolerances are scaled
    minimum, maximum : bounds that the value may reach
    """

    display: str | None = field(default=None, kw_only=True)
    nominal: float | None = field(default=None, kw_only=True)
    minimum: float | None = field(default=None, kw_only=True)
    maximum: float | None = field(default=None, kw_only=True)
    type: VariableType = field(default="Real", kw_only=True)


@dataclass(frozen=True)
class Input(_Variable):
    """A variable that the master sets; `accepts_nan` for one that copes with a missing value."""

    description: str
    start: float = field(default=0.0, kw_only=True)
    accepts_nan: bool = field(default=False, kw_only=True)
    discrete: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Parameter(_Variable):
    """A value fixed before the run.

    Attributes
    ----------
    starts : start values of a vector whose elements differ
    positive : the value must lie above 0, which it may not reach
    """

    start: float
    description: str
    starts: tuple[float, ...] | None = field(default=None, kw_only=True)
    positive: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Output(_Variable):
    """A variable that the component computes."""

    description: str
    discrete: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class State(_Named):
    """Part of what a component remembers; `start` is a number or the name of a parameter.

    It is finite at all times, or NaN where `accepts_nan` says that a value may be missing.
    """

    start: float | str = field(default=0.0, kw_only=True)
    accepts_nan: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Derived(_Named):
    """A quantity that parameters alone settle, computed once before the run."""


@dataclass(frozen=True)
class Scalar:
    """One scalar of the interface: its value reference, its name, and the declaration it belongs to."""

    reference: int
    name: str
    variable: Input | Parameter | Output
    element: int

    @property
    def start(self) -> float | None:
        """Start value; None for an output, which is computed."""
        if isinstance(self.variable, Output):
            return None
        if isinstance(self.variable, Parameter) and self.variable.starts is not None:
            return self.variable.starts[self.element]
        return self.variable.start

    @property
    def lower(self) -> float | None:
        """The bound that a model description states: the minimum, or 0 for a positive parameter."""
        positive = isinstance(self.variable, Parameter) and self.variable.positive
        return 0.0 if positive else self.variable.minimum


@dataclass(frozen=True)
class Check:
    """A condition across parameters: `margin(p)` must not be negative (NaN fails too).

    The sentence is given the parameter values, with nine digits, as
    `"tip_position: {tip_position} m lies beyond the link's end; keep it within length ({length} m)"`;
    `{sensor_position[1]}` is the first element of a vector.
    """

    margin: Callable[[Record], Number]
    sentence: str


FIELD = re.compile(r"\{([\w.]+(?:\[\d+\])?)\}")
"""A parameter's name in the sentence of a check."""


class Layout:
    """How named variables lie in one flat vector.

    Names with dots, as `link.conductivity`, are read as records within records, so that the part of a joined
    component finds its own values as if it stood alone: `values.link.conductivity`.
    """

    def __init__(self, variables: Sequence[_Named]) -> None:
        self.variables = tuple(variables)
        self.names = [name for variable in self.variables for name in variable.scalar_names]
        self.size = len(self.names)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._places: dict[str, int | slice] = {}
        inner: dict[str, list[tuple[_Named, slice]]] = {}
        start = 0
        for variable in self.variables:
            end = start + variable.count
            part, dot, rest = variable.name.partition(".")
            if dot:
                inner.setdefault(part, []).append((replace(variable, name=rest), slice(start, end)))
            else:
                self._places[variable.name] = start if variable.size is None else slice(start, end)
            start = end
        self._inner = {
            part: (Layout([v for v, _ in held]), _merged([place for _, place in held]))
            for part, held in inner.items()
        }
        plain = not inner and all(name.isidentifier() for name in self._places)
        self._record: Any = _record_type(list(self._places)) if plain else None

    def read(self, vector: Number) -> Record:
        """Named values of a flat vector of any arithmetic, shape (size,)."""
        if self._record is not None:
            return self._record._make([vector[place] for place in self._places.values()])
        values = {name: vector[place] for name, place in self._places.items()}
        values |= {part: layout.read(vector[place]) for part, (layout, place) in self._inner.items()}
        return SimpleNamespace(**values)

    def values(self, vector: Number) -> dict[str, Number]:
        """Values of a flat vector by the variables' names, shape (size,)."""
        found, start = {}, 0
        for variable in self.variables:
            end = start + variable.count
            found[variable.name] = vector[start] if variable.size is None else vector[start:end]
            start = end
        return found

    def record(self, values: Mapping[str, Number]) -> Record:
        """Record of named values, each a number or a vector, for a layout whose names have no dots."""
        return SimpleNamespace(**values) if self._record is None else self._record(**values)

    def flat(self, values: Mapping[str, Number]) -> Number:
        """Flat vector of named values, shape (size,).

        Raises
        ------
        KeyError
            A variable is missing, or one is named that is not declared.
        """
        if values.keys() != {v.name for v in self.variables}:
            missing = [v.name for v in self.variables if v.name not in values]
            unknown = [name for name in values if name not in {v.name for v in self.variables}]
            raise KeyError(f"missing: {missing}, not declared: {unknown}")
        return stack(*(values[v.name] for v in self.variables))


def _record_type(names: list[str]) -> Any:
    return namedtuple("Values", names)


def _merged(places: Sequence[slice]) -> slice | list[int]:
    """One place that holds several in their order: a slice where they adjoin."""
    if all(a.stop == b.start for a, b in pairwise(places)):
        return slice(places[0].start, places[-1].stop)
    return [i for place in places for i in range(place.start, place.stop)]


@dataclass(frozen=True)
class Clock:
    """What is sampled together: some of the states, at one sample time.

    Attributes
    ----------
    sample_time : name of the parameter that gives the time between two samples, in s
    states : the states that it gives, which lie side by side
    update : `update(x, u, p, time, step)`, their next values by name
    """

    sample_time: str
    states: tuple[State, ...]
    update: Callable[[Record, Record, Record, Number, Number], Mapping[str, Number]]

    @cached_property
    def layout(self) -> Layout:
        """Layout of the states."""
        return Layout(self.states)


class Joint(Protocol):
    """What a joined component consists of (see `join`)."""

    @property
    def parts(self) -> Mapping[str, Component]:
        """The components by instance name, none of them joined itself."""

    @property
    def wires(self) -> Mapping[str, str]:
        """Source of each input that a wire feeds, both as `instance.variable`."""

    def inputs(self, key: str, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Flat inputs of a part during the run."""

    @property
    def starting(self) -> Sequence[str]:
        """Parts with states in an order in which they may begin; some come more than once."""

    def rates(
        self, x: Record, u: Record, p: Record, time: Number, since: Number | None = None
    ) -> Mapping[str, Number]:
        """Time derivatives of the continuous states by name; `since` as for `Component.rates_of`."""


@dataclass(frozen=True)
class Component:
    """A component with its variables and its behaviour.

    Attributes
    ----------
    rates : `rates(x, u, p, time)`, the time derivative of every state that is not sampled, by name; for
        components that are differential equations
    update : `update(x, u, p, time, step)`, the next value of every state, by name; for components that
        sample: called each `sample_time` (a parameter) with the inputs held
    observe : `observe(x, u, p, time)`, the value of every output, by name
    derive : `derive(p)`, the value of every derived quantity, by name; the other functions find these
        beside the parameters in `p`
    begin : `begin(u, p)`, start value of every state, by name, where the states' own `start` is not enough
    clocks : what is sampled when, in the order of sampling, where `update` does not say it all
    joint : what the component was joined from; None for one that stands by itself
    micro_step : largest step of the integrator in s
    checks : conditions across parameters
    default_stop_time, default_step_size : experiment in s that the FMU proposes
    """

    name: str
    description: str
    observe: Callable[[Record, Record, Record, Number], Mapping[str, Number]]
    inputs: tuple[Input, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    derived: tuple[Derived, ...] = ()
    states: tuple[State, ...] = ()
    outputs: tuple[Output, ...] = ()
    rates: Callable[[Record, Record, Record, Number], Mapping[str, Number]] | None = None
    update: Callable[[Record, Record, Record, Number, Number], Mapping[str, Number]] | None = None
    derive: Callable[[Record], Mapping[str, Number]] | None = None
    begin: Callable[[Record, Record], Mapping[str, Number]] | None = None
    clocks: tuple[Clock, ...] = ()
    joint: Joint | None = None
    checks: tuple[Check, ...] = ()
    micro_step: float = 1.0
    default_stop_time: float = 3600.0
    default_step_size: float = 1.0

    def __post_init__(self) -> None:
        names = [v.name for v in (*self.inputs, *self.parameters, *self.outputs)]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"{self.name} declares more than once: {', '.join(twice)}")
        if self.update is not None:
            object.__setattr__(self, "clocks", (Clock("sample_time", self.states, self.update),))
        if self.states and not self.clocks and self.rates is None:
            raise ValueError(f"{self.name} has states, so it needs rates or update")
        if self.update is not None and self.rates is not None:
            raise ValueError(f"{self.name} has rates and update; give one of the two")
        bounded = {v.name for v in self.parameters if (v.minimum or 0.0) >= SHORTEST_SAMPLE_TIME}
        for clock in self.clocks:
            if clock.sample_time not in bounded:
                raise ValueError(
                    f"{self.name} samples, so it needs a parameter {clock.sample_time} with a minimum of at "
                    f"least {SHORTEST_SAMPLE_TIME:g} s"
                )

    @property
    def sampled(self) -> bool:
        """Whether anything in the component is sampled."""
        return bool(self.clocks)

    @cached_property
    def continuous(self) -> Layout:
        """Layout of the states that have rates, which come first in x."""
        sampled = {state.name for clock in self.clocks for state in clock.states}
        return Layout([state for state in self.states if state.name not in sampled])

    @property
    def snake_name(self) -> str:
        """Name in lower case with underscores, as `thermal_link`."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", self.name).lower()

    @cached_property
    def x(self) -> Layout:
        """Layout of the states."""
        return Layout(self.states)

    @cached_property
    def u(self) -> Layout:
        """Layout of the inputs."""
        return Layout(self.inputs)

    @cached_property
    def p(self) -> Layout:
        """Layout of the parameters."""
        return Layout(self.parameters)

    @cached_property
    def d(self) -> Layout:
        """Layout of the parameters and, after them, the derived quantities; part by part where joined."""
        named = (*self.parameters, *self.derived)
        parts = list(dict.fromkeys(v.name.rpartition(".")[0] for v in named))
        return Layout(sorted(named, key=lambda v: parts.index(v.name.rpartition(".")[0])))

    @cached_property
    def y(self) -> Layout:
        """Layout of the outputs."""
        return Layout(self.outputs)

    def scalars(self) -> Iterator[Scalar]:
        """Every scalar variable of the interface, in the order of its value reference."""
        reference = 0
        declared: tuple[Input | Parameter | Output, ...] = (*self.parameters, *self.inputs, *self.outputs)
        for variable in declared:
            for i, name in enumerate(variable.scalar_names):
                yield Scalar(reference, name, variable, i)
                reference += 1

    def start_values(self, given: Mapping[str, float] | None = None) -> tuple[Number, Number]:
        """Flat parameters and inputs at their start values, but for those given by name.

        Raises
        ------
        KeyError
            A name is neither a parameter's nor an input's.
        """
        starts = [scalar.start for scalar in self.scalars() if scalar.start is not None]
        values = np.array(starts, dtype=float)
        for name, value in (given or {}).items():
            inside = name in self.p.index
            values[self.p.index[name] if inside else self.p.size + self.u.index[name]] = value
        return values[: self.p.size], values[self.p.size :]

    def longest_step(self, p: Number) -> float:
        """Longest communication step in s, for flat parameters: so many samples or micro steps."""
        sampled = [float(p[self.p.index[clock.sample_time]]) for clock in self.clocks]
        return MOST_IN_A_STEP * min(
            [*sampled, *([self.micro_step] if self.continuous.size else [])], default=1.0
        )

    def settled(self, p: Number) -> Number:
        """Flat vector of parameters and derived quantities, shape (d.size,), for flat parameters.

        The functions below take this vector as `p`.
        """
        if self.derive is None:
            return p
        return self.d.flat({**self.p.values(p), **self.derive(self.p.read(p))})

    def states_at_start(self, u: Number, p: Number) -> Number:
        """Flat vector of start values of the states, shape (x.size,), for flat inputs and parameters."""
        return self.x.flat(self.started(self.u.read(u), self.d.read(p)))

    def started(self, u: Record, p: Record) -> Mapping[str, Number]:
        """Start values of the states by name."""
        if self.begin is not None:
            return self.begin(u, p)
        values: dict[str, Number] = {}
        for state in self.states:
            start = getattr(p, state.start) if isinstance(state.start, str) else state.start
            values[state.name] = start if state.size is None else stack(*[start] * state.size)
        return values

    def rates_of(self, x: Number, u: Number, p: Number, time: Number, since: Number | None = None) -> Number:
        """Flat vector of the time derivatives of the continuous states, shape (continuous.size,).

        Parameters
        ----------
        x, u, p : flat states, inputs, and parameters with what they settle
        time : in s
        since : time in s at which the micro step began, where it is not `time`: signals between the parts of
            a joined component that jump are those of then
        """
        assert self.rates is not None
        given = (self.x.read(x), self.u.read(u), self.d.read(p), time)
        return self.continuous.flat(
            self.rates(*given) if self.joint is None else self.joint.rates(*given, since)
        )

    def updated(
        self, x: Number, u: Number, p: Number, time: Number, step: Number, clock: Clock | None = None
    ) -> Number:
        """Flat vector of a clock's states after one sample; its only one where none is named."""
        clock = clock or self.clocks[0]
        values = clock.update(self.x.read(x), self.u.read(u), self.d.read(p), time, step)
        return clock.layout.flat(values)

    def outputs_of(self, x: Number, u: Number, p: Number, time: Number) -> Number:
        """Flat vector of the outputs, shape (y.size,)."""
        return self.y.flat(self.observe(self.x.read(x), self.u.read(u), self.d.read(p), time))
