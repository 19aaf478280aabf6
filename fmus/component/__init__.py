"""What a component is: its declaration, and what follows from it without any FMI.

A declaration states the variables once, and the functions that give them behaviour. Both FMUs, their model
descriptions, the documentation tables and the SSP connectors are derived from a `Component`; no list of
variables is written anywhere else.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from warmlink.fmus.component.arithmetic import Number, stack, symbolic
from warmlink.fmus.component.variables import (  # noqa: F401 - what a component is declared with
    Choice,
    Derived,
    Input,
    Layout,
    Local,
    Output,
    Parameter,
    Record,
    Scalar,
    State,
    Terminal,
    Values,
    Variable,
    VariableType,
)

if TYPE_CHECKING:
    from warmlink.fmus.component.join import Joint
    from warmlink.fmus.component.table import Played

SHORTEST_SAMPLE_TIME = 1e-3
"""s; nothing warms up in less, and a run of hours with a shorter one would not end."""

MOST_IN_A_STEP = 10_000
"""Samples, or micro steps, that one communication step may take: no host waits for it for minutes."""


@dataclass(frozen=True)
class Check:
    """A condition across parameters: `margin(p)` must not be negative (NaN fails too).

    The sentence is given parameter values with nine digits, as `"tip_position: {tip_position} m lies ..."`;
    `{sensor_position[1]}` is the first element of a vector.
    """

    margin: Callable[[Record], Number]
    sentence: str


FIELD = re.compile(r"\{([\w.]+(?:\[\d+\])?)\}")
"""A parameter's name in the sentence of a check."""


@dataclass(frozen=True)
class Clock:
    """Some of the states, side by side, that are sampled together.

    The parameter `sample_time` gives the time between two samples in s, `update(x, u, p, time, step)` the
    states' next values by name.
    """

    sample_time: str
    states: tuple[State, ...]
    update: Callable[[Record, Record, Record, Number, Number], Values]

    @cached_property
    def layout(self) -> Layout:
        """Layout of the states."""
        return Layout(self.states)


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
    solve : `solve(right, p, step)`, by name the y of (I - step J) y = right, for components of many coupled
        states: J stands in for the Jacobian of the rates, and holds its stiff part. Without it, or once
        joined, the equations are solved with the Jacobian itself
    derive : `derive(p)`, the value of every derived quantity, by name; the other functions find these
        beside the parameters in `p`
    begin : `begin(u, p)`, start value of every state, by name, where the states' own `start` is not enough
    clocks : what is sampled when, in the order of sampling, where `update` does not say it all
    joint : what the component was joined from; None for one that stands by itself
    terminals : which scalars belong together where components are connected
    tables : tables that it plays; a derived quantity stands for each in the functions above
    local, look_inside : variables that show the inside, and `look_inside(x, u, p, time)`, their values by
        name; native FMUs have them (see `packaging.views.opened`)
    micro_step : largest step of the integrator in s
    checks : conditions across parameters
    default_stop_time, default_step_size : experiment in s that the FMU proposes
    """

    name: str
    description: str
    observe: Callable[[Record, Record, Record, Number], Values]
    inputs: tuple[Input, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    derived: tuple[Derived, ...] = ()
    states: tuple[State, ...] = ()
    outputs: tuple[Output, ...] = ()
    rates: Callable[[Record, Record, Record, Number], Values] | None = None
    update: Callable[[Record, Record, Record, Number, Number], Values] | None = None
    solve: Callable[[Record, Record, Number], Values] | None = None
    derive: Callable[[Record], Values] | None = None
    begin: Callable[[Record, Record], Values] | None = None
    clocks: tuple[Clock, ...] = ()
    joint: Joint | None = None
    terminals: tuple[Terminal, ...] = ()
    tables: tuple[Played, ...] = ()
    local: tuple[Local, ...] = ()
    look_inside: Callable[[Record, Record, Record, Number], Values] | None = None
    checks: tuple[Check, ...] = ()
    micro_step: float = 1.0
    default_stop_time: float = 3600.0
    default_step_size: float = 1.0

    def __post_init__(self) -> None:
        counts = Counter(v.name for v in (*self.inputs, *self.parameters, *self.outputs))
        twice = sorted(name for name, count in counts.items() if count > 1)
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

    x = cached_property(lambda self: Layout(self.states))
    """Layout of the states."""

    u = cached_property(lambda self: Layout(self.inputs))
    """Layout of the inputs."""

    p = cached_property(lambda self: Layout(self.parameters))
    """Layout of the parameters."""

    y = cached_property(lambda self: Layout(self.outputs))
    """Layout of the outputs."""

    @cached_property
    def d(self) -> Layout:
        """Layout of the parameters and, after them, the derived quantities; part by part where joined."""
        named = (*self.parameters, *self.derived)
        parts = list(dict.fromkeys(v.name.rpartition(".")[0] for v in named))
        return Layout(sorted(named, key=lambda v: parts.index(v.name.rpartition(".")[0])))

    @property
    def output_count(self) -> int:
        """Number of scalar outputs; what follows them in y are local variables."""
        return sum(variable.count for variable in self.outputs if not isinstance(variable, Local))

    def scalars(self) -> tuple[Scalar, ...]:
        """Every scalar variable of the interface, in the order of its value reference."""
        return self._scalars

    @cached_property
    def _scalars(self) -> tuple[Scalar, ...]:
        declared: tuple[Input | Parameter | Output, ...] = (*self.parameters, *self.inputs, *self.outputs)
        each = ((name, variable, i) for variable in declared for i, name in enumerate(variable.scalar_names))
        return tuple(Scalar(reference, *scalar) for reference, scalar in enumerate(each))

    def start_values(self, given: Mapping[str, float] | None = None) -> tuple[Number, Number]:
        """Flat parameters and inputs at their start values, but for those given by name.

        KeyError: a name is neither a parameter's nor an input's.
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
        settled = self.d.flat({**self.p.values(p), **self.derive(self.p.read(p))})
        for played in () if symbolic(p) else self.tables:
            settled[self.d.index[played.name]] = played.table.handle
        return settled

    def states_at_start(self, u: Number, p: Number, time: Number = 0.0) -> Number:
        """Flat vector of start values of the states, shape (x.size,), for flat inputs and parameters.

        The run starts at a time in s, at which a joined component's parts see each other's outputs.
        """
        return self.x.flat(self.started(self.u.read(u), self.d.read(p), time))

    def started(self, u: Record, p: Record, time: Number = 0.0) -> Values:
        """Start values of the states by name."""
        if self.joint is not None:
            return self.joint.begin(u, p, time)
        if self.begin is not None:
            return self.begin(u, p)
        values: dict[str, Number] = {}
        for state in self.states:
            start = getattr(p, state.start) if isinstance(state.start, str) else state.start
            values[state.name] = start if state.size is None else stack(*[start] * state.size)
        return values

    def rates_of(
        self, x: Number, u: Number, p: Number, time: Number, held_at: Number | None = None
    ) -> Number:
        """Flat vector of the time derivatives of the continuous states, shape (continuous.size,).

        Arguments are flat, and time in s. The discrete outputs of a joined component's parts are evaluated at
        `held_at`, the beginning of the micro step, or at `time` if it is None.
        """
        assert self.rates is not None
        given = (self.x.read(x), self.u.read(u), self.d.read(p), time)
        return self.continuous.flat(
            self.rates(*given) if self.joint is None else self.joint.rates(*given, held_at)
        )

    def solved(self, right: Number, p: Number, step: Number) -> Number:
        """Solution by `solve` for flat right-hand side and settled parameters, shape (continuous.size,)."""
        assert self.solve is not None
        return self.continuous.flat(self.solve(self.continuous.read(right), self.d.read(p), step))

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
