"""The declaration of a component: its variables once, and the functions that give it behaviour.

Both FMUs, their model descriptions, the documentation tables and the SSP connectors are derived from a
`Component`; no list of variables is written anywhere else.
"""

from __future__ import annotations

import re
from collections import namedtuple
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

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
    `"tip_position: {tip_position} m lies beyond the link's end; keep it within length ({length} m)"`.
    """

    margin: Callable[[Record], Number]
    sentence: str


def _record_type(names: list[str]) -> Any:
    return namedtuple("Values", names)


class Layout:
    """How named variables lie in one flat vector."""

    def __init__(self, variables: Sequence[_Named]) -> None:
        self.variables = tuple(variables)
        self.names = [name for variable in self.variables for name in variable.scalar_names]
        self.size = len(self.names)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._record = _record_type([v.name for v in self.variables])
        self._places: list[int | slice] = []
        start = 0
        for variable in self.variables:
            here: int | slice = start if variable.size is None else slice(start, start + variable.count)
            self._places.append(here)
            start += variable.count

    def read(self, vector: Number) -> Record:
        """Named values of a flat vector of any arithmetic, shape (size,)."""
        return self._record._make([vector[place] for place in self._places])

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


@dataclass(frozen=True)
class Component:
    """A component with its variables and its behaviour.

    Attributes
    ----------
    rates : `rates(x, u, p, time)`, the time derivative of every state, by name; for components that are
        differential equations
    update : `update(x, u, p, time, step)`, the next value of every state, by name; for components that
        sample: called each `sample_time` (a parameter) with the inputs held
    observe : `observe(x, u, p, time)`, the value of every output, by name
    derive : `derive(p)`, the value of every derived quantity, by name; the other functions find these
        beside the parameters in `p`
    begin : `begin(u, p)`, start value of every state, by name, where the states' own `start` is not enough
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
    checks: tuple[Check, ...] = ()
    micro_step: float = 1.0
    default_stop_time: float = 3600.0
    default_step_size: float = 1.0

    def __post_init__(self) -> None:
        names = [v.name for v in (*self.inputs, *self.parameters, *self.outputs)]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"{self.name} declares more than once: {', '.join(twice)}")
        if self.states and (self.update is None) == (self.rates is None):
            raise ValueError(f"{self.name} has states, so it needs rates or update, one of the two")
        if self.update is not None and not any(
            v.name == "sample_time" and v.minimum is not None and v.minimum >= SHORTEST_SAMPLE_TIME
            for v in self.parameters
        ):
            raise ValueError(
                f"{self.name} samples, so it needs a parameter sample_time with a minimum of at least "
                f"{SHORTEST_SAMPLE_TIME:g} s"
            )

    @property
    def sampled(self) -> bool:
        """Whether the component samples rather than integrates."""
        return self.update is not None

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
        """Layout of the parameters and, after them, the derived quantities."""
        return Layout((*self.parameters, *self.derived))

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

    def longest_step(self, p: Number) -> float:
        """Longest communication step in s, for flat parameters: so many samples or micro steps."""
        return MOST_IN_A_STEP * float(p[self.p.index["sample_time"]] if self.sampled else self.micro_step)

    def settled(self, p: Number) -> Number:
        """Flat vector of parameters and derived quantities, shape (d.size,), for flat parameters.

        The functions below take this vector as `p`.
        """
        if self.derive is None:
            return p
        values = self.derive(self.p.read(p))
        return stack(p, Layout(self.derived).flat(values))

    def states_at_start(self, u: Number, p: Number) -> Number:
        """Flat vector of start values of the states, shape (x.size,), for flat inputs and parameters."""
        inputs, parameters = self.u.read(u), self.d.read(p)
        if self.begin is not None:
            return self.x.flat(self.begin(inputs, parameters))
        values: dict[str, Number] = {}
        for state in self.states:
            start = getattr(parameters, state.start) if isinstance(state.start, str) else state.start
            values[state.name] = start if state.size is None else stack(*[start] * state.size)
        return self.x.flat(values)

    def rates_of(self, x: Number, u: Number, p: Number, time: Number) -> Number:
        """Flat vector of the states' time derivatives, shape (x.size,)."""
        assert self.rates is not None
        return self.x.flat(self.rates(self.x.read(x), self.u.read(u), self.d.read(p), time))

    def updated(self, x: Number, u: Number, p: Number, time: Number, step: Number) -> Number:
        """Flat vector of the states after one sample, shape (x.size,)."""
        assert self.update is not None
        return self.x.flat(self.update(self.x.read(x), self.u.read(u), self.d.read(p), time, step))

    def outputs_of(self, x: Number, u: Number, p: Number, time: Number) -> Number:
        """Flat vector of the outputs, shape (y.size,)."""
        return self.y.flat(self.observe(self.x.read(x), self.u.read(u), self.d.read(p), time))
