"""A component running in Python, as it does in a Python FMU and in tests."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from warmlink.fmus.component import Component, Input, Parameter, limits
from warmlink.fmus.component.arithmetic import Number, stack
from warmlink.fmus.component.coupling import coupling
from warmlink.fmus.component.integrator import GAMMA, ComplexStepJacobian, Vector, ros2, solution_of
from warmlink.fmus.errors import InputError

TICK_TOLERANCE = 1e-9
"""Share of a sample time, or of a micro step, by which a communication point may miss it."""

CLOCK_TOLERANCE = 1e-6
"""Share of time and step by which a master's sum of steps may miss our time."""

VECTORS = ("parameters", "inputs", "states")
"""Fields of a snapshot that are vectors of floats."""


@dataclass(frozen=True)
class Snapshot:
    """All that an instance remembers; JSON-ready, and exact since floats are written in full."""

    parameters: list[float]
    inputs: list[float]
    states: list[float]
    start_time: float
    time: float
    samples: list[int]
    initialized: bool


class Instance:
    """One running component.

    Values are set and got by value reference or by name; outputs belong to the present inputs. `warn` is
    called with a sentence on what was mended. InputError on leaving initialization with parameters out of
    range, and on a step that is too long, is not from the time reached, has inputs out of range, or lets a
    state grow beyond all bounds.
    """

    def __init__(self, component: Component, name: str | None = None) -> None:
        self.component = component
        self.name = name or component.snake_name
        self._scalars = list(component.scalars())
        self._references = {s.name: s.reference for s in self._scalars}
        self._p, self._u = component.start_values()
        self._settled: Vector = self._p
        self._x: Vector = np.zeros(component.x.size)
        self._y: Vector | None = None
        self._start_time = self._time = 0.0
        self._samples = [0] * len(self.component.clocks)
        self._initialized = False
        self._jacobian: ComplexStepJacobian | None = None
        self._clamped: set[str] = set()
        self._ended: set[str] = set()
        self.warn: Callable[[str], object] = lambda sentence: None

    @property
    def time(self) -> float:
        """Time in s that the instance has reached."""
        return self._time

    def set(self, values: Mapping[str, float]) -> None:
        """Set inputs, tunable parameters, and before initialization ends all, by name, in SI units."""
        for name, value in values.items():
            if name not in self._references:
                raise InputError(limits.unknown(self.component, self.name, name))
            self.set_reference(self._references[name], value)

    def get(self, name: str) -> float:
        """Value of a variable by name, in its SI unit."""
        return self.get_reference(self._references[name])

    def set_reference(self, reference: int, value: float) -> None:
        """Set the variable of a value reference."""
        scalar = self._scalars[reference]
        variable, named = scalar.variable, f"{self.name}.{scalar.name}"
        if isinstance(variable, Input):
            self._u[reference - self.component.p.size] = value
        elif not isinstance(variable, Parameter):
            raise InputError(f"{named}: an output cannot be set; set an input")
        elif not self._initialized:
            self._p[reference] = value
        elif variable.tunable:
            changed = self._p.copy()
            changed[reference] = value
            limits.refuse_problems(self.component, self.name, changed.tolist())
            self._settle(changed)
        else:
            told = "parameters are fixed once the run has begun; set it before initialization"
            raise InputError(f"{named}: {told}")
        self._y = None

    def get_reference(self, reference: int) -> float:
        """Value of the variable of a value reference."""
        for known in (self._p, self._u):
            if reference < known.size:
                return float(known[reference])
            reference -= known.size
        return float(self.outputs()[reference])

    def outputs(self) -> Vector:
        """All outputs at the present time, state and inputs, shape (y.size,)."""
        if self._y is None:
            if not self._initialized:
                self._begin()
            found = self.component.outputs_of(self._x, self._u, self._settled, self._time)
            self._y = np.asarray(found, dtype=float)
        return self._y

    def begin(self, time: float = 0.0) -> None:
        """Set the start time in s."""
        if not math.isfinite(time):
            raise InputError(f"{self.name}: a run from {time:g} s; give a finite start")
        self._start_time = self._time = float(time)
        self._y = None

    def initialize(self) -> None:
        """Leave initialization: from here parameters are fixed and the states are their own."""
        limits.refuse_problems(self.component, self.name, self._p.tolist())
        self._begin()
        self._check_states(self._time)
        self._initialized = True

    def step(self, time: float, step: float) -> None:
        """Go from `time` to `time + step`, both in s, with the inputs held."""
        if not self._initialized:
            raise InputError(f"{self.name}: a step before initialization; initialize it first")
        longest = self.component.longest_step(self._p)
        if not 0 < step <= longest:
            told = f"a step of {step:g} s; give one above 0 s and at most {longest:g} s"
            raise InputError(f"{self.name}: {told}")
        if not abs(time - self._time) <= min(longest, CLOCK_TOLERANCE * (abs(time) + step)):
            told = f"a step from {time:.9g} s, but {self._time:.9g} s is reached; step from there"
            raise InputError(f"{self.name}: {told}, or restore a state")
        self._check_inputs()
        before = self._x, list(self._samples)
        try:
            with np.errstate(all="ignore"):
                self._go(time, time + step)
            self._check_states(time)
        except BaseException:
            self._x, self._samples = before  # so that the step may be tried again
            raise
        self._time = time + step
        self._y = None
        for played in self.component.tables:
            if played.name not in self._ended and played.table.ends_before(self._time):
                self._ended.add(played.name)
                self.warn(f"{self.name}{played.ended}")

    def snapshot(self) -> Snapshot:
        """Everything that the instance remembers."""
        vectors = self._p.tolist(), self._u.tolist(), self._x.tolist()
        return Snapshot(*vectors, self._start_time, self._time, list(self._samples), self._initialized)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot; what follows is bit for bit what followed then."""
        if snapshot.parameters != self._p.tolist() or snapshot.initialized != self._initialized:
            self._settle(np.array(snapshot.parameters))
        self._u, self._x = np.array(snapshot.inputs), np.array(snapshot.states)
        self._start_time, self._time = snapshot.start_time, snapshot.time
        self._samples, self._initialized = list(snapshot.samples), snapshot.initialized
        self._y = None

    def _settle(self, parameters: Vector) -> None:
        self._p = parameters
        with np.errstate(all="ignore"):
            self._settled = np.asarray(self.component.settled(parameters), dtype=float)

    def _begin(self) -> None:
        self._settle(self._p)
        with np.errstate(all="ignore"):
            begun = self.component.states_at_start(self._u, self._settled, self._time)
            self._x = np.asarray(begun, dtype=float)
        self._samples = [0] * len(self.component.clocks)

    def _check_inputs(self) -> None:
        for i, value in enumerate(self._u.tolist()):
            scalar = self._scalars[self.component.p.size + i]
            sentence = limits.problem(scalar, value)
            if sentence is None:
                continue
            self._u[i] = limits.clamped(scalar, value)
            if self._u[i] == value or math.isnan(value):
                raise InputError(f"{self.name}.{sentence}")
            if scalar.name not in self._clamped:
                self._clamped.add(scalar.name)
                self.warn(f"{self.name}.{limits.taken_for(scalar, value)}")

    def _check_states(self, since: float) -> None:
        wild = limits.wild_state(self.component, self._x.tolist())
        if wild is not None:
            remedy = "look for inputs and parameters far from their nominal values"
            raise InputError(f"{self.name}: {wild} is not finite after {since:g} s; {remedy}")

    def _go(self, time: float, until: float) -> None:
        """From sample to sample; of those due at once, first the first clock's."""
        clocks = range(len(self._samples))
        first: int | None = 0
        while first is not None:
            first = min((i for i in clocks if self._is_due(i, until)), key=self._next_sample, default=None)
            instant = until if first is None else min(until, self._next_sample(first))
            if self.component.continuous.size and instant - time > TICK_TOLERANCE * self.component.micro_step:
                self._integrate(time, instant - time)
            time = instant
            for i in clocks if first is not None else ():
                if i == first or self._is_due(i, instant):  # by rounding also one before it
                    self._sample(i)

    def _period(self, clock: int) -> float:
        return float(self._p[self.component.p.index[self.component.clocks[clock].sample_time]])

    def _is_due(self, clock: int, time: float) -> bool:
        return self._samples[clock] < samples_until(time, self._start_time, self._period(clock))

    def _next_sample(self, clock: int) -> float:
        return self._start_time + (self._samples[clock] + 1) * self._period(clock)

    def _sample(self, clock: int) -> None:
        what = self.component.clocks[clock]
        instant, period = self._next_sample(clock), self._period(clock)
        self._samples[clock] += 1
        sampled = self.component.updated(self._x, self._u, self._settled, instant, period, what)
        first = self.component.x.index[what.layout.names[0]] if what.states else 0
        self._x = self._x.copy()
        self._x[first : first + what.layout.size] = sampled

    def _integrate(self, time: float, step: float) -> None:
        count = max(1, math.ceil(step / self.component.micro_step - TICK_TOLERANCE))
        micro = step / count
        size = self.component.continuous.size
        held = self._x[size:]

        def rates(x: Number, now: float, held_at: float) -> Number:
            return self.component.rates_of(stack(x, held), self._u, self._settled, now, held_at)

        if self._jacobian is None and self.component.solve is None:
            self._jacobian = ComplexStepJacobian(coupling(self.component))
        x = self._x[:size]
        solve: Callable[[Number], Number] = partial(
            self.component.solved, p=self._settled, step=GAMMA * micro
        )
        for now in (time + i * micro for i in range(count)):
            if self._jacobian is not None:
                solve = solution_of(self._jacobian(partial(rates, now=now, held_at=now), x), micro)
            x = ros2(rates(x, now, now), solve, partial(rates, now=now + micro, held_at=now), x, micro)
        self._x = np.concatenate([x, held])


def samples_until(time: float, start_time: float, period: float) -> int:
    """Samples from the start until a time, all in s."""
    return math.floor((time - start_time) / period + TICK_TOLERANCE)


def is_possible(component: Component, snapshot: Snapshot) -> bool:
    """Whether an instance of a component could have remembered this; TypeError for some that it could not."""
    start, time, samples = snapshot.start_time, snapshot.time, snapshot.samples
    sizes = [len(getattr(snapshot, name)) for name in VECTORS]
    if sizes != [component.p.size, component.u.size, component.x.size]:
        return False
    kinds = [type(each) for each in (start, time, snapshot.initialized, *samples)]
    if kinds != [float, float, bool, *[int] * len(component.clocks)] or not math.isfinite(start + time):
        return False
    for scalar, value in zip(component.scalars(), snapshot.parameters + snapshot.inputs, strict=False):
        kind = scalar.variable.type
        if (kind == "Boolean" and value not in (0, 1)) or (kind == "Integer" and not value.is_integer()):
            return False
    if not snapshot.initialized:
        return time == start and not any(samples)
    # Time by which masters' sums of steps may have missed ours.
    slack = 4 * CLOCK_TOLERANCE * (abs(start) + abs(time))
    refused = any(limits.problems(component, "", snapshot.parameters))
    if refused or limits.wild_state(component, snapshot.states) is not None or time < start - slack:
        return False
    for clock, count in zip(component.clocks, samples, strict=True):
        period = snapshot.parameters[component.p.index[clock.sample_time]]
        if not math.isfinite((time - start) / period):
            return False
        due = max(0, samples_until(time, start, period))
        if not due <= count <= due + 1 + slack / period:
            return False
    return True
