"""A component running in Python: the inside of the Python FMU, and of quick looks and tests."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arithmetic import Number
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging import limits
from warmlink.fmus.packaging.component import Component, Input, Parameter
from warmlink.fmus.packaging.integrator import ComplexStepJacobian, Vector, rosenbrock_step
from warmlink.fmus.packaging.snapshot import CLOCK_TOLERANCE, TICK_TOLERANCE, Snapshot, samples_until


class Instance:
    """One running component.

    Values are set and got by value reference or by name; outputs belong to the present inputs.

    Raises
    ------
    InputError
        On leaving initialization with parameters out of range, and on a step that is too long, is not from
        the time reached, has inputs out of range, or lets a state grow beyond all bounds.
    """

    def __init__(self, component: Component, name: str | None = None) -> None:
        self.component = component
        self.name = name or component.snake_name
        self._scalars = list(component.scalars())
        self._references = {s.name: s.reference for s in self._scalars}
        starts = [s.start for s in self._scalars if s.start is not None]
        self._p: Vector = np.array(starts[: component.p.size], dtype=float)
        self._u: Vector = np.array(starts[component.p.size :], dtype=float)
        self._settled: Vector = self._p
        self._x: Vector = np.zeros(component.x.size)
        self._y: Vector | None = None
        self._start_time = self._time = 0.0
        self._samples = 0
        self._initialized = False
        self._jacobian: ComplexStepJacobian | None = None

    @property
    def time(self) -> float:
        """Time in s that the instance has reached."""
        return self._time

    def set(self, values: Mapping[str, float]) -> None:
        """Set inputs, and before initialization ends parameters, by name, in SI units."""
        for name, value in values.items():
            if name not in self._references:
                raise InputError(
                    f"{self.name}.{name}: {self.component.name} has no such variable; "
                    f"{instead(name, self._references)}"
                )
            self.set_reference(self._references[name], value)

    def get(self, name: str) -> float:
        """Value of a variable by name, in its SI unit."""
        return self.get_reference(self._references[name])

    def set_reference(self, reference: int, value: float) -> None:
        """Set the variable of a value reference."""
        scalar = self._scalars[reference]
        if isinstance(scalar.variable, Parameter):
            if self._initialized:
                raise InputError(
                    f"{self.name}.{scalar.name}: parameters are fixed once the run has begun; "
                    "set it before initialization"
                )
            self._p[reference] = value
        elif isinstance(scalar.variable, Input):
            self._u[reference - self.component.p.size] = value
        else:
            raise InputError(f"{self.name}.{scalar.name}: an output cannot be set; set an input")
        self._y = None

    def get_reference(self, reference: int) -> float:
        """Value of the variable of a value reference."""
        first_output = self.component.p.size + self.component.u.size
        if reference >= first_output:
            return float(self.outputs()[reference - first_output])
        if reference < self.component.p.size:
            return float(self._p[reference])
        return float(self._u[reference - self.component.p.size])

    def outputs(self) -> Vector:
        """All outputs at the present time, state and inputs, shape (y.size,)."""
        if self._y is None:
            if not self._initialized:
                self._begin()
            self._y = np.asarray(
                self.component.outputs_of(self._x, self._u, self._settled, self._time), dtype=float
            )
        return self._y

    def begin(self, time: float = 0.0) -> None:
        """Set the start time in s."""
        if not math.isfinite(time):
            raise InputError(f"{self.name}: a run from {time:g} s; give a finite start")
        self._start_time = self._time = float(time)
        self._y = None

    def initialize(self) -> None:
        """Leave initialization: from here parameters are fixed and the states are their own."""
        for sentence in limits.problems(self.component, self.name, self._p.tolist()):
            raise InputError(sentence)
        self._begin()
        self._check_states(self._time)
        self._initialized = True

    def step(self, time: float, step: float) -> None:
        """Go from `time` to `time + step`, both in s, with the inputs held."""
        if not self._initialized:
            raise InputError(f"{self.name}: a step before initialization; initialize it first")
        longest = self.component.longest_step(self._p)
        if not 0 < step <= longest:
            raise InputError(
                f"{self.name}: a step of {step:g} s; give one above 0 s and at most {longest:g} s"
            )
        if not abs(time - self._time) <= min(longest, CLOCK_TOLERANCE * (abs(time) + step)):
            raise InputError(
                f"{self.name}: a step from {time:.9g} s, but {self._time:.9g} s is reached; step from there, "
                "or restore a state"
            )
        self._check_inputs()
        before = self._x, self._samples
        try:
            with np.errstate(all="ignore"):
                if self.component.sampled:
                    self._sample_until(time + step)
                elif self.component.states:
                    self._integrate(time, step)
            self._check_states(time)
        except BaseException:
            # A step that fails leaves the instance where it was, so that it may be tried again.
            self._x, self._samples = before
            raise
        self._time = time + step
        self._y = None

    def snapshot(self) -> Snapshot:
        """Everything that the instance remembers."""
        return Snapshot(
            self._p.tolist(),
            self._u.tolist(),
            self._x.tolist(),
            self._start_time,
            self._time,
            self._samples,
            self._initialized,
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot; what follows is bit for bit what followed then."""
        if snapshot.parameters != self._p.tolist() or snapshot.initialized != self._initialized:
            self._p = np.array(snapshot.parameters)
            self._settled = self._settle()
            self._jacobian = None
        self._u = np.array(snapshot.inputs)
        self._x = np.array(snapshot.states)
        self._start_time, self._time = snapshot.start_time, snapshot.time
        self._samples, self._initialized = snapshot.samples, snapshot.initialized
        self._y = None

    def _settle(self) -> Vector:
        with np.errstate(all="ignore"):
            return np.asarray(self.component.settled(self._p), dtype=float)

    def _begin(self) -> None:
        self._settled = self._settle()
        with np.errstate(all="ignore"):
            self._x = np.asarray(self.component.states_at_start(self._u, self._settled), dtype=float)
        self._samples = 0

    def _check_inputs(self) -> None:
        for scalar, value in zip(self._scalars[self.component.p.size :], self._u.tolist(), strict=False):
            sentence = limits.problem(scalar, value)
            if sentence is not None:
                raise InputError(f"{self.name}.{sentence}")

    def _check_states(self, since: float) -> None:
        wild = limits.wild_state(self.component, self._x.tolist())
        if wild is not None:
            raise InputError(
                f"{self.name}: {wild} is not finite after {since:g} s; "
                "look for inputs and parameters far from their nominal values"
            )

    def _sample_until(self, time: float) -> None:
        period = self._p[self.component.p.index["sample_time"]]
        due = samples_until(time, self._start_time, period)
        while self._samples < due:
            self._samples += 1
            instant = self._start_time + self._samples * period
            self._x = np.asarray(
                self.component.updated(self._x, self._u, self._settled, instant, period), dtype=float
            )

    def _integrate(self, time: float, step: float) -> None:
        count = max(1, math.ceil(step / self.component.micro_step - TICK_TOLERANCE))
        micro = step / count
        if self._jacobian is None:
            self._jacobian = ComplexStepJacobian(self._structure(time))
        for i in range(count):
            now = time + i * micro
            matrix = self._jacobian(partial(self._rates, time=now), self._x)
            self._x = rosenbrock_step(self._rates, matrix, self._x, now, micro)

    def _rates(self, x: Number, time: float) -> Number:
        return self.component.rates_of(x, self._u, self._settled, time)

    def _structure(self, time: float) -> NDArray[np.bool_]:
        """Where the Jacobian differs from zero, found a column at a time.

        The diagonal always counts: a loss that inputs switch on and off lies there, and the structure
        must not depend on when it is found.
        """
        size = self.component.x.size
        every = ComplexStepJacobian(np.ones((size, size), dtype=bool))
        found = every(partial(self._rates, time=time), self._x) != 0
        return found | np.eye(size, dtype=bool)
