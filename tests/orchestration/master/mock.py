"""A slave made of lambdas, for tests of the master and for systems that are not FMUs."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

from warmlink.orchestration.master.slaves.slave import Names, RunSpan
from warmlink.orchestration.system.description import Capabilities, FmuVariable
from warmlink.orchestration.system.model import Value


class Inputs(dict[str, Any]):
    """Input values by name; a Real input may also carry time derivatives for the coming step."""

    def __init__(self, values: Mapping[str, Value]) -> None:
        super().__init__(values)
        self.derivatives: dict[str, tuple[float, ...]] = {}

    def coefficients(self, name: str) -> tuple[float, float, float]:
        """Give u, du/dt, d2u/dt2 at the start of the step; zero where none was set."""
        first, second = (*self.derivatives.get(name, ()), 0.0, 0.0)[:2]
        return float(self[name]), first, second

    def copied(self) -> Inputs:
        """Copy values and derivatives."""
        copy = Inputs(self)
        copy.derivatives = dict(self.derivatives)
        return copy

    def at(self, name: str, elapsed: float) -> float:
        """Evaluate an input `elapsed` seconds after the start of the step."""
        value, first, second = self.coefficients(name)
        return value + first * elapsed + 0.5 * second * elapsed**2


Advance = Callable[[Any, Inputs, float, float], Any]
Observe = Callable[[Any, Inputs, float], Value]


ABLE = Capabilities(variable_step=True, get_set_state=True, serialize_state=True, interpolate_inputs=True)


def real(
    name: str,
    causality: str,
    *,
    unit: str | None = None,
    nominal: float | None = None,
    variability: str = "continuous",
) -> FmuVariable:
    """Describe a Real variable of a mock slave."""
    return FmuVariable(name, 0, "Real", "Real", causality, variability, unit=unit, nominal=nominal)


def hold(state: Any, inputs: Inputs, time: float, step_size: float) -> Any:
    """Leave the state as it is: the advance of a slave that only computes."""
    return state


class MockSlave:
    """A slave whose behaviour is given as functions.

    Parameters
    ----------
    name : str
        The name in the system.
    inputs : mapping
        Start values of inputs (and of parameters, which are inputs nobody connects).
    outputs : mapping
        For each output a function `(state, inputs, time) -> value`.
    state : object
        Initial state; anything that can be pickled.
    advance : callable
        `(state, inputs, time, step_size) -> state`, which may raise `SlaveError`; it must not change
        the state it is given.
    feedthrough : mapping
        For each output the inputs it depends on at once; default: none.
    variables : sequence of Variable
        Types, units and nominals of those that are not plain continuous Reals.
    capabilities : Capabilities
        Default: everything, input derivatives up to order 2.
    accepts_nan : frozenset of str
        Variables for which NaN is a proper value.
    initialize : callable, optional
        `(state, inputs) -> state`, called on leaving initialization mode.
    """

    def __init__(
        self,
        name: str,
        *,
        inputs: Mapping[str, Value] | None = None,
        outputs: Mapping[str, Observe] | None = None,
        state: Any = None,
        advance: Advance = hold,
        feedthrough: Mapping[str, Sequence[str]] | None = None,
        variables: Sequence[FmuVariable] = (),
        capabilities: Capabilities | None = None,
        accepts_nan: frozenset[str] = frozenset(),
        initialize: Callable[[Any, Inputs], Any] | None = None,
    ) -> None:
        self.name = name
        self.inputs = Inputs(inputs or {})
        self.outputs = dict(outputs or {})
        self.variables: dict[str, FmuVariable] = {
            **{n: real(n, "input") for n in self.inputs},
            **{n: real(n, "output") for n in self.outputs},
            **{v.name: v for v in variables},
        }
        self.capabilities = capabilities or ABLE
        self.dependencies = {n: frozenset((feedthrough or {}).get(n, ())) for n in self.outputs}
        self.accepts_nan = accepts_nan
        self.remarks: tuple[str, ...] = ()
        self.steps = 0
        self.terminated = False
        self._state = state
        self._advance = advance
        self._initialize = initialize
        self._time = 0.0

    def setup(self, experiment: RunSpan) -> None:
        """Note the start time."""
        self._time = experiment.start_time

    def enter_initialization(self) -> None:
        """Nothing to do."""

    def exit_initialization(self) -> None:
        """Compute the initial state where there is something to compute."""
        if self._initialize is not None:
            self._state = self._initialize(self._state, self.inputs)

    def get(self, names: Names) -> list[Value]:
        """Evaluate outputs; inputs are given back as they are."""
        return [
            self.outputs[n](self._state, self.inputs, self._time) if n in self.outputs else self.inputs[n]
            for n in names
        ]

    def set(self, names: Names, values: Sequence[Value]) -> None:
        """Set inputs and drop their derivatives."""
        for n, value in zip(names, values, strict=True):
            if n not in self.inputs:
                raise KeyError(f"{self.name}.{n}")
            self.inputs[n] = value
            self.inputs.derivatives.pop(n, None)

    def set_input_derivatives(self, names: Names, order: int, values: Sequence[float]) -> None:
        """Set the derivative of one order."""
        for n, value in zip(names, values, strict=True):
            held = [*self.inputs.derivatives.get(n, ()), 0.0, 0.0][:2]
            held[order - 1] = value
            self.inputs.derivatives[n] = tuple(held)

    def step(self, time: float, step_size: float) -> None:
        """Advance the state; an output then sees the inputs as they stand at the end of the step."""
        self._state = self._advance(self._state, self.inputs, time, step_size)
        for n in self.inputs.derivatives:
            self.inputs[n] = self.inputs.at(n, step_size)
        self.inputs.derivatives.clear()
        self._time = time + step_size
        self.steps += 1

    def state(self, reuse: object = None) -> object:
        """Copy state, inputs and time."""
        return self._state, self.inputs.copied(), self._time

    def restore(self, state: object) -> None:
        """Return to a copy."""
        self._state, inputs, self._time = cast("tuple[Any, Inputs, float]", state)
        self.inputs = inputs.copied()

    def free(self, state: object) -> None:
        """Nothing to release."""

    def serialize(self) -> bytes:
        """Pickle state, inputs and time."""
        return pickle.dumps(self.state())

    def deserialize(self, data: bytes) -> None:
        """Take a pickled state."""
        self.restore(pickle.loads(data))

    def terminate(self) -> None:
        """Note the end."""
        self.terminated = True
